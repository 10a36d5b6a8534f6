# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in Blender's own window, under a virtual display: the scenes of scenes.py and what came of them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import pytest

from .display import SIZE, XVFB, virtual_display, write_png

MEASURED = pytest.mark.skipif(not os.environ.get("WINDOW_MEASURES"), reason="takes minutes: set WINDOW_MEASURES=1")
HERE = Path(__file__).resolve().parent
# Where the photographs stay, to be looked at.
PICTURES = HERE.parents[1] / "build" / "window"

pytestmark = [
    pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module has no window: make test-blender has one"),
    pytest.mark.skipif(sys.platform != "linux", reason="a virtual display needs Linux"),
    pytest.mark.skipif(XVFB is None, reason="no virtual display: install Xvfb (package xvfb) and Mesa's software GL"),
]


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """What the scenes returned by their names, and what Blender printed; it quits by itself."""
    folder = tmp_path_factory.mktemp("window")
    with virtual_display(folder) as environment:
        geometry = [str(number) for number in (0, 0, *SIZE)]
        command = [bpy.app.binary_path, "-noaudio", "--enable-event-simulate", "--window-geometry", *geometry]
        command += ["--python-exit-code", "1", "--python", str(HERE / "director.py"), "--", str(HERE.parent), folder]
        environment["TMPDIR"] = str(folder)
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=600)
    PICTURES.mkdir(parents=True, exist_ok=True)
    for photograph in sorted(folder.glob("*.xwd")):
        write_png(PICTURES / f"{photograph.stem}.png", photograph)
    print(done.stdout)
    results = folder / "results.json"
    return json.loads(results.read_text()) if results.exists() else {}, done


@pytest.fixture
def scene(played, request):
    """What the scene returned that has the name of the test."""
    results, done = played
    name = request.function.__name__.removeprefix("test_")
    assert name in results, done.stdout + done.stderr
    assert "error" not in results[name], results[name]["error"]
    return results[name]


def changed(differences):
    """What differs but for what undo itself leaves: Blender's window manager no longer counts as a user of scenes."""
    return [line for line in differences if not line.startswith("scenes['Scene'] users: ")]


def test_see_progress_and_cancel(scene):
    print("median frame, ms, alone and beside a bake:", scene["frame_ms"], "Esc to idle, s:", scene["seconds_to_stop"])
    assert "left" in scene["pace"]
    assert "Bake Multibounce AO is running: wait for it, or press Esc" in scene["refusal"]
    assert scene["differences"] == []


def test_bake_and_undo(scene):
    assert scene["points"] == 507
    assert scene["blocking"] == ["FINISHED"]
    assert scene["same"]
    assert changed(scene["undone"]) == []


def test_undo_while_baking(scene):
    assert scene["ended"]
    assert changed(scene["differences"]) == []


def test_delete_while_baking(scene):
    assert len(scene["left"]) == 1
    assert scene["baked"]


def test_edit_while_baking(scene):
    assert scene["mode"] == "EDIT_MESH"
    assert scene["text"] == "Switch to Object Mode to store it"
    assert scene["baked"] == [True, True]


def test_close_the_window(scene):
    assert scene["windows"] == 1


def test_other_long_operators(scene):
    assert scene == {"states": [["RUNNING_MODAL"]] * 2, "fitted": False}


def test_show_another_scene_while_baking(scene):
    assert scene["baked"]


def test_open_a_file_while_baking(scene):
    assert scene == {"running": False, "objects": 0}


def test_quit_while_baking(scene, played):
    assert scene == {}
    assert played[1].returncode == 0, played[1].stdout + played[1].stderr


@MEASURED
def test_cancel_again_and_again(scene):
    print("Esc to idle, s, median and longest of 20:", scene["seconds"])
    assert scene["differences"] == []


@MEASURED
def test_large_scene(scene):
    print(scene["triangles"], "triangles, median frame, ms, alone and beside a bake:", scene["frame_ms"])
    print("of it in the bake's own steps, ms, median, longest, and longest to read the scene:", scene["step_ms"])


@MEASURED
def test_cost_of_the_window(scene):
    for kind, unit in (("", "s"), (" cpu", "s of all processors, with the window's own")):
        modal, blocking = scene["seconds"]["modal" + kind], scene["seconds"]["blocking" + kind]
        print(f"in the window {modal:.2f}, blocking {blocking:.2f} {unit}: {modal / blocking:.2f}")
    print(f"an idle window takes {scene['idle_cpu']:.2f} s of the processors a second")
    print("time left told after a tenth, over what it took:", scene["told_over_true"])
