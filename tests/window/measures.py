# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that measure, too long for every day. They are played, too, by

WINDOW_MEASURES=1 make test-blender ARGS="-rP tests/window"

On a machine that has other work, with `nice -n 10` before it: the bake's threads have that niceness in the window, and
then the blocking bake has it too.
"""

from __future__ import annotations

import time

import bpy
import numpy as np
from artist import FOR_MINUTES, change_settings, in_viewport, module, monkeys, move_into_view, press, running
from operators.snapshot import differences, snapshot
from scenes import MARK, at_work, frame_times, idle, start

ROUNDS = 20


def subdivided(levels):
    (monkey,) = monkeys()
    with in_viewport():
        monkey.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
        bpy.ops.view3d.view_selected()
    return monkey


def cancel_again_and_again(folder):
    """Twenty bakes that end by Esc, and the file as it was."""
    monkeys()
    change_settings(**FOR_MINUTES)
    before, taken = snapshot(), []
    for _ in range(ROUNDS):
        start()
        yield at_work
        move_into_view()
        yield 0.1
        began = time.perf_counter()
        press("ESC")
        yield idle
        taken.append(time.perf_counter() - began)
    return {"seconds": [float(np.median(taken)), max(taken)], "differences": differences(before, snapshot())}


def large_scene(folder):
    """Frames of a million triangles, alone and beside their bake: as they are, and as their bounds, where it is not
    software's drawing of the triangles that takes the time."""
    monkey = subdivided(5)
    change_settings(target="VERTEX", samples=1024)
    frame_ms, step_ms = {}, {}
    for display in ("TEXTURED", "BOUNDS"):
        monkey.display_type = display
        yield 1.0
        alone = yield from frame_times(3.0)
        beside, step_ms[display] = yield from beside_a_bake()
        frame_ms[display] = [alone, beside]
    return {"triangles": 2 * len(monkey.data.polygons), "frame_ms": frame_ms, "step_ms": step_ms}


def beside_a_bake():
    """Median frame, and median and longest step of the bake's own and the longest to read the scene."""
    steps, step = [], module("operators.modal").Running.step

    def timed(run, context):
        began = time.perf_counter()
        try:
            step(run, context)
        finally:
            steps.append(1000 * (time.perf_counter() - began))

    module("operators.modal").Running.step = timed
    start()
    yield at_work
    reading = max(steps)
    steps.clear()
    frame = yield from frame_times(6.0)
    running().end("")
    yield idle
    module("operators.modal").Running.step = step
    return frame, [float(np.median(steps)), max(steps), reading]


def cost_of_the_window(folder):
    """The same bake in the window and blocking, in turns; and the time left that is told after a tenth."""
    monkey = subdivided(3)
    change_settings(target="VERTEX", samples=1024)
    yield 2.0
    cpu = time.process_time()
    yield 3.0
    idle_cpu = (time.process_time() - cpu) / 3.0
    taken, left = {"modal": [], "blocking": [], "modal cpu": [], "blocking cpu": []}, []
    for round_number in range(4):
        monkey.pop(MARK, None)
        began, cpu = time.perf_counter(), time.process_time()
        start()
        yield lambda: running() is not None and running().progress.fraction >= 0.1 and running().pace.left
        told, at = running().pace.left, time.perf_counter()
        yield idle
        ended, cpu_then = time.perf_counter(), time.process_time()
        with in_viewport():
            bpy.ops.multibounce_ao.bake()
        if round_number:  # the first builds the scene for its rays
            taken["modal"].append(ended - began)
            taken["blocking"].append(time.perf_counter() - ended)
            taken["modal cpu"].append(cpu_then - cpu)
            taken["blocking cpu"].append(time.process_time() - cpu_then)
            left.append(told / (ended - at))
    seconds = {name: float(np.median(values)) for name, values in taken.items()}
    return {"seconds": seconds, "idle_cpu": idle_cpu, "told_over_true": left}


MEASURES = [cancel_again_and_again, large_scene, cost_of_the_window]
