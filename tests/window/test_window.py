# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension in Blender's own window, under a virtual display: the scenes of scenes.py and what came of them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from .display import SIZE, XVFB, picture, virtual_display, write_png

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
    """What the scenes returned by their names, their photographs, and what Blender printed; it quits by itself."""
    folder = tmp_path_factory.mktemp("window")
    with virtual_display(folder) as environment:
        geometry = [str(number) for number in (0, 0, *SIZE)]
        command = [bpy.app.binary_path, "-noaudio", "--enable-event-simulate", "--window-geometry", *geometry]
        command += ["--python-exit-code", "1", "--python", str(HERE / "director.py"), "--", str(HERE.parent), folder]
        environment["TMPDIR"] = str(folder)
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, timeout=600)
    PICTURES.mkdir(parents=True, exist_ok=True)
    photographs = {dump.stem: picture(dump) for dump in sorted(folder.glob("*.xwd"))}
    for name, photograph in photographs.items():
        write_png(PICTURES / f"{name}.png", photograph)
    print(done.stdout)
    results = folder / "results.json"
    return json.loads(results.read_text()) if results.exists() else {}, photographs, done


@pytest.fixture
def scene(played, request):
    """What the scene returned that has the name of the test."""
    results, _, done = played
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
    assert not scene["drawn"]
    assert scene["blocking"] == ["FINISHED"]
    assert scene["same"]
    assert changed(scene["undone"]) == []


def test_see_the_bake_while_it_runs(scene, played):
    """Under a sketch and later, the viewport is nearly what the view of the AO shows after a bake, and after Esc what
    it was."""
    for target, seen in scene.items():
        print(target, "seconds from the button to the sketch:", seen["seconds"])
        x, y, width, height = seen["view"]

        def view(name, box=(x, y, width, height), target=target):
            x, y, width, height = box
            shown = played[1][f"sketch_{target}{name}"].astype(float)
            return shown[SIZE[1] - y - height : SIZE[1] - y, x : x + width]

        before, truth = view("_before"), view("_truth")
        baked = np.abs(truth - before).max(axis=2) > 8
        assert 0.05 < baked.mean() < 0.9
        assert 0 < error(view(""), truth, baked) < 0.5 * error(before, truth, baked)
        assert error(view("_later"), truth, baked) < 0.3 * error(before, truth, baked)
        assert error(view("_after"), before, baked) < 0.02 * error(before, truth, baked)  # but for antialiasing


def error(shown, truth, where):
    """Rms difference between two pictures, 0 to 255."""
    return float(np.sqrt(np.square(shown - truth)[where].mean()))


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
    assert scene == {"windows": 1, "drawn": False}


def test_other_long_operators(scene):
    assert scene["states"] == [["RUNNING_MODAL"]] * 3
    assert not scene["fitted"]
    assert changed(scene["differences"]) == []
    assert scene["projected"]


def test_show_another_scene_while_baking(scene):
    assert scene["baked"]


def test_open_a_file_while_baking(scene):
    assert scene == {"running": False, "drawn": False, "objects": 0}


def test_quit_while_baking(scene, played):
    assert scene == {}
    assert played[2].returncode == 0, played[2].stdout + played[2].stderr


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
    own = scene["seconds"]["modal cpu"] - scene["idle_cpu"] * scene["seconds"]["modal"]
    print(f"an idle window takes {scene['idle_cpu']:.2f} s of the processors a second")
    print(f"without that the bake in the window takes {own / scene['seconds']['blocking cpu']:.2f} of a blocking one")
    print("time left told after a tenth, over what it took:", scene["told_over_true"])
