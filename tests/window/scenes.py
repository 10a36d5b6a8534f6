# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes that are played in the window, in this order; test_window.py judges what they return."""

from __future__ import annotations

import time

import bpy
import numpy as np
from artist import (
    FOR_MINUTES,
    change_settings,
    click_first_button,
    in_viewport,
    monkeys,
    move_into_view,
    open_sidebar,
    photograph,
    press,
    region,
    running,
    viewport,
    window,
)
from mathutils import Quaternion
from operators.bakes import attribute
from operators.snapshot import differences, snapshot

MARK = "multibounce_ao"


def idle():
    return running() is None


def at_work():
    return running() is not None and running().progress.fraction > 0.0


def draws(run):
    """Whether the preview of a bake is still drawn."""
    return run._overlay._handle is not None


def tells():
    """The bake that goes on says how long it will still take."""
    return running() is not None and running().pace.left is not None


def see_progress_and_cancel(folder):
    """The button, progress in panel and status bar, the window alive, Esc; and nothing has changed."""
    monkeys()
    change_settings(**FOR_MINUTES)
    yield from open_sidebar()
    photograph(folder / "panel.xwd")
    before = snapshot()
    alone = yield from frame_times()
    yield from click_first_button()
    yield at_work
    yield tells
    first = running().progress.fraction
    beside = yield from frame_times()
    yield lambda: running().progress.fraction > first
    photograph(folder / "progress.xwd")
    pace = running().pace.text()
    refusal = second_bake()
    move_into_view()
    yield 0.1
    began = time.perf_counter()
    press("ESC")
    yield idle
    stopped = time.perf_counter() - began
    yield 0.3
    photograph(folder / "cancelled.xwd")
    return {
        "frame_ms": [alone, beside],
        "pace": pace,
        "refusal": refusal,
        "seconds_to_stop": stopped,
        "differences": differences(before, snapshot()),
    }


def frame_times(seconds=1.5):
    """Median time between drawings of a view that turns, ms."""
    drawn = []
    handler = bpy.types.SpaceView3D.draw_handler_add(
        lambda: drawn.append(time.perf_counter()), (), "WINDOW", "POST_PIXEL"
    )
    until = time.perf_counter() + seconds
    while time.perf_counter() < until:
        viewport().spaces.active.region_3d.view_rotation.rotate(Quaternion((0.0, 0.0, 1.0), 0.02))
        region("WINDOW").tag_redraw()
        yield 0.001
    bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
    return 1000 * float(np.median(np.diff(drawn)))


def second_bake():
    try:
        start()
    except RuntimeError as error:
        return str(error)
    return "none"


def start(name="bake"):
    """The button, by the operator's name."""
    with in_viewport():
        return getattr(bpy.ops.multibounce_ao, name)("INVOKE_DEFAULT")


def bake_and_undo(folder):
    """The button again: to the end, the same bits as a blocking bake, and one undo step."""
    (monkey,) = monkeys()
    change_settings(target="VERTEX", samples=256)
    with in_viewport():
        bpy.ops.ed.undo_push(message="Before")
    before = snapshot()
    yield from click_first_button()
    run = running()
    yield lambda: idle() and MARK in monkey
    drawn = draws(run)
    yield 0.5
    with in_viewport():
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
    yield 0.5
    photograph(folder / "baked.xwd")
    in_window = attribute(monkey)
    manager = bpy.context.window_manager
    for view in ("AO", "BOUNCES", "BENT"):
        manager.multibounce_ao_view = view
        yield 0.3
        photograph(folder / f"view_{view.lower()}.xwd")
    manager.multibounce_ao_view = "OFF"
    move_into_view()
    press("Z", ctrl=True)
    yield lambda: MARK not in bpy.data.objects["Suzanne"]
    undone = differences(before, snapshot())
    with in_viewport():
        blocking = bpy.ops.multibounce_ao.bake()
    return {
        "points": len(in_window),
        "drawn": drawn,
        "undone": undone,
        "blocking": list(blocking),
        "same": bool((attribute(bpy.data.objects["Suzanne"]) == in_window).all()),
    }


def see_the_bake_while_it_runs(folder):
    """Vertices, then texels: a sketch that is soon there, gone after Esc; and what the bake is at last."""
    vertices = yield from sketch_and_bake(folder, "VERTEX")
    texels = yield from sketch_and_bake(folder, "TEXTURE")
    return {"VERTEX": vertices, "TEXTURE": texels}


def drawn_again(times=3):
    """Wait until the view was drawn so often, however long that takes."""
    drawn = []
    draw = bpy.types.SpaceView3D.draw_handler_add(lambda: drawn.append(None), (), "WINDOW", "POST_PIXEL")
    while len(drawn) < times:
        region("WINDOW").tag_redraw()
        yield 0.05
    bpy.types.SpaceView3D.draw_handler_remove(draw, "WINDOW")
    yield 0.3


def sketch_and_bake(folder, target):
    (monkey,) = monkeys()
    with in_viewport():
        monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.view3d.view_axis(type="FRONT")
        bpy.ops.view3d.view_selected()
        monkey.select_set(False)  # without an outline
    change_settings(target=target, samples=2**14, resolution=256)
    move_into_view()
    yield from drawn_again()
    photograph(folder / f"sketch_{target}_before.xwd")
    with in_viewport():
        monkey.select_set(True)
        began = time.perf_counter()
        start()
        monkey.select_set(False)
    yield lambda: running()._overlay._drawn
    seconds = time.perf_counter() - began
    yield from drawn_again()
    photograph(folder / f"sketch_{target}.xwd")
    yield 0.5
    yield from drawn_again()
    photograph(folder / f"sketch_{target}_later.xwd")
    press("ESC")
    yield idle
    yield from drawn_again()
    photograph(folder / f"sketch_{target}_after.xwd")
    change_settings(samples=64)
    with in_viewport():
        monkey.select_set(True)
        bpy.ops.multibounce_ao.bake()
        monkey.select_set(False)
    bpy.context.window_manager.multibounce_ao_view = "AO"
    yield from drawn_again()
    photograph(folder / f"sketch_{target}_truth.xwd")
    bpy.context.window_manager.multibounce_ao_view = "OFF"
    view = region("WINDOW")
    return {"seconds": seconds, "view": [view.x, view.y, view.width, view.height]}


def undo_while_baking(folder):
    """Undo ends the bake, as it ends Blender's own jobs."""
    monkeys()
    with in_viewport():
        bpy.ops.ed.undo_push(message="Made")
        before = snapshot()
        bpy.ops.transform.translate(value=(1.0, 0.0, 0.0))
        bpy.ops.ed.undo_push(message="Moved")
    change_settings(**FOR_MINUTES)
    start()
    yield at_work
    run = running()
    move_into_view()
    press("Z", ctrl=True)
    yield idle
    ended = running() is None and not draws(run)
    change_settings(target="VERTEX", samples=16, resolution=1024)
    changed = [line for line in differences(before, snapshot()) if ".multibounce_ao." not in line]
    start()
    yield lambda: idle() and MARK in bpy.data.objects["Suzanne"]
    change_settings(target="TEXTURE", resolution=128)
    start()
    yield lambda: idle() and bpy.data.objects["Suzanne"][MARK]["target"] == "TEXTURE"
    bpy.context.window_manager.multibounce_ao_view = "AO"
    yield 0.5
    photograph(folder / "view_texture.xwd")
    bpy.context.window_manager.multibounce_ao_view = "OFF"
    return {"ended": ended, "differences": changed}


def delete_while_baking(folder):
    """The other object is baked."""
    _, second = monkeys(2)
    change_settings(target="VERTEX", samples=2**10)
    start()
    yield at_work
    with in_viewport():
        second.select_set(False)
        bpy.ops.object.delete()
    yield idle
    return {"left": [obj.name for obj in bpy.data.objects], "baked": MARK in second}


def edit_while_baking(folder):
    """The result waits for Object Mode, and is then stored."""
    first, second = monkeys(2)
    change_settings(target="VERTEX", samples=256)
    start()
    yield at_work
    move_into_view()
    yield 0.1
    second.select_set(False)
    press("TAB")
    yield lambda: running() is not None and running().waits
    yield 0.3
    text, mode = running().details(), bpy.context.mode
    photograph(folder / "waiting.xwd")
    press("TAB")
    yield idle
    return {"mode": mode, "text": text, "baked": [MARK in first, MARK in second]}


def close_the_window(folder):
    """A bake ends with the window that it was started in."""
    monkeys()
    change_settings(**FOR_MINUTES)
    with in_viewport():
        bpy.ops.wm.window_new()
    yield 0.5
    windows = bpy.context.window_manager.windows
    other = windows[1]
    area = next(iter(other.screen.areas))
    with bpy.context.temp_override(window=other, area=area, region=area.regions[-1]):
        bpy.ops.multibounce_ao.bake("INVOKE_DEFAULT")
    yield at_work
    run = running()
    with bpy.context.temp_override(window=other):
        bpy.ops.wm.window_close()
    yield idle
    yield 0.3
    return {"windows": len(windows), "drawn": draws(run)}


def other_long_operators(folder):
    """An AO field to its end, bounce curves that are cancelled by the button, and a World by Esc, then to its end."""
    (monkey,) = monkeys()
    change_settings(target="VERTEX", samples=32, field_resolution=8)
    states = [list(start("bake_field"))]
    yield lambda: idle() and "multibounce_ao_field" in monkey
    states.append(list(start("fit_bounces")))
    yield at_work
    with in_viewport():
        bpy.ops.multibounce_ao.cancel()
    yield idle
    scene = window().scene
    world, nodes = scene.world, scene.world.node_tree.nodes
    color = nodes["Background"].inputs["Color"]
    world.node_tree.links.new(nodes.new("ShaderNodeTexNoise").outputs["Color"], color)
    before = snapshot()
    states.append(list(start("project_world")))
    yield at_work
    move_into_view()
    press("ESC")
    yield idle
    changed = differences(before, snapshot())
    start("project_world")
    yield idle
    return {
        "states": states,
        "fitted": "multibounce_ao_fit" in scene,
        "differences": changed,
        "projected": "multibounce_ao_world" in scene,
    }


def show_another_scene_while_baking(folder):
    """A bake goes on in the scene that it was begun in, and ends with it."""
    (monkey,) = monkeys()
    change_settings(target="VERTEX", samples=256)
    first, other = window().scene, bpy.data.scenes.new("Other")
    start()
    yield at_work
    window().scene = other
    yield idle
    baked = MARK in monkey
    window().scene = first
    change_settings(**FOR_MINUTES)
    yield 0.1
    start()
    yield at_work
    window().scene = other
    bpy.data.scenes.remove(first)
    yield idle
    return {"baked": baked}


def open_a_file_while_baking(folder):
    monkeys()
    change_settings(**FOR_MINUTES)
    start()
    yield at_work
    run = running()
    bpy.ops.wm.read_homefile(use_empty=True)
    yield 0.5
    return {"running": running() is not None, "drawn": draws(run), "objects": len(bpy.data.objects)}


def quit_while_baking(folder):
    """The last scene: Blender is to quit all the same."""
    monkeys()
    change_settings(**FOR_MINUTES)
    start()
    yield at_work
    return {}


SCENES = [
    see_progress_and_cancel,
    bake_and_undo,
    see_the_bake_while_it_runs,
    undo_while_baking,
    delete_while_baking,
    edit_while_baking,
    close_the_window,
    other_long_operators,
    show_another_scene_while_baking,
    open_a_file_while_baking,
    quit_while_baking,
]
