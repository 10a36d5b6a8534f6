# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao fit`: what it simulates, exit codes, the report, and what is saved."""

import json
import re
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest

from .bakes import operators, select
from .meshes import add, add_mesh, plate

REPORT_KEYS = {
    *("name", "source", "points", "samples", "bounces", "bins", "seconds", "fit", "outputs", "warnings", "error"),
}
FIT_KEYS = {"a", "b", "f0_factor", "f0_exponent", "f0_rms", "f1_rms", "tau_rms"}


def run(*arguments):
    return operators("command_line").run([str(argument) for argument in arguments])


@pytest.fixture
def blend(scene, tmp_path):
    """A box without a lid that is active, a plate, a lamp and an image of hills."""
    corners = [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    crate = add_mesh("Crate", corners, [(0, 1, 2, 3), *((i, i + 4, (i + 1) % 4 + 4, (i + 1) % 4) for i in range(4))])
    floor = plate("Floor", location=(9, 0, 0))
    add("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    image = bpy.data.images.new("Hills", 12, 12, float_buffer=True)
    heights = np.repeat(np.random.default_rng(0).random((144, 1), np.float32), 4, axis=1)
    image.pixels.foreach_set(heights.ravel())
    image.pack()
    image.use_fake_user = True
    bpy.context.scene.multibounce_ao.samples = 16
    select(crate, floor)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def reported(blend, *arguments, code=0):
    report = blend.parent / "reports" / "report.json"
    assert run("fit", blend, "--report", report, *arguments) == code
    report = json.loads(report.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert set(report) == {"version", "scene", "seconds", "objects"}
    assert report["scene"] == str(blend)
    (entry,) = report["objects"]
    assert set(entry) == REPORT_KEYS
    return entry


def test_report(blend):
    entry = reported(blend, "--set", "height_map=Hills")
    assert (entry["name"], entry["source"], entry["error"]) == ("Hills", "HEIGHT_MAP", None)
    assert (entry["points"], entry["samples"], entry["bounces"], entry["bins"]) == (144, 16, 20, 100)
    assert set(entry["fit"]) == FIT_KEYS
    assert entry["outputs"] == ["Hills Bounce Curves"] * 2
    stored = bpy.context.scene["multibounce_ao_fit"].to_dict()
    assert {name: stored[name] for name in FIT_KEYS} == entry["fit"]


def test_named_object_comes_before_the_height_map(blend):
    entry = reported(blend, "--object", "Crate", "--set", "height_map=Hills")
    assert (entry["name"], entry["source"]) == ("Crate", "MESH")


def test_active_object_is_the_default(blend):
    assert reported(blend)["name"] == "Crate"


def test_height_map_of_the_file(blend):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.scene.multibounce_ao.height_map = bpy.data.images["Hills"]
    bpy.ops.wm.save_mainfile()
    assert reported(blend)["name"] == "Hills"
    assert reported(blend, "--set", "height_map=")["name"] == "Crate"


def test_amplitude(blend):
    low, high = (
        reported(blend, "--set", "height_map=Hills", "--set", f"height_map_amplitude={amplitude}")["fit"]
        for amplitude in (0.1, 0.4)
    )
    assert low["a"] != high["a"]


def test_occluders(blend):
    """A lid that is hidden in renders takes part where the .blend has it selected."""

    def fitted(**settings):
        changes = [part for item in settings.items() for part in ("--set", "{}={}".format(*item))]
        return reported(blend, "--object", "Crate", *changes)["fit"]

    bpy.ops.wm.open_mainfile(filepath=str(blend))
    lid = plate("Lid", half=0.5, location=(0, 0, 1))
    lid.hide_render = True
    bpy.ops.wm.save_mainfile()
    alone, among, selected = (fitted(occluders=name) for name in ("SELF", "VISIBLE", "SELECTED"))
    assert among == selected != alone  # the plate
    bpy.data.objects["Lid"].select_set(True)
    bpy.ops.wm.save_mainfile()
    assert fitted(occluders="SELECTED") != selected
    assert fitted(occluders="SELF", use_ground_plane="on") != alone


def test_bake_leaves_the_height_map_alone(blend):
    assert run("bake", blend, "--quiet", "--set", "height_map=Hills", "--object", "Floor") == 0
    assert "height_map" not in bpy.data.objects["Floor"]["multibounce_ao"]


@pytest.mark.parametrize("to", ["", "new.blend"])
def test_save(blend, to, tmp_path):
    before = blend.read_bytes()
    target = tmp_path / to if to else blend
    assert run("fit", blend, "--quiet", "--save", *([target] if to else [])) == 0
    assert (blend.read_bytes() == before) == bool(to)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(target))
    assert bpy.context.scene["multibounce_ao_fit"]["source"] == "Crate"
    assert "Crate Bounce Curves" in bpy.data.images


def test_files(blend):
    entry = reported(blend, "--set", "output_directory=//curves")
    folder = blend.parent / "curves"
    assert [Path(path) for path in entry["outputs"]] == [
        folder / "Crate_bounce_curves.csv",
        folder / "Crate_bounce_curves.png",
    ]
    assert all(Path(path).is_file() for path in entry["outputs"])


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["--object", "Nobody"], "'Nobody'.*'Crate', 'Floor'"),
        (["--object", "Lamp"], "'Lamp' is not a mesh"),
        (["--object", "Floor"], "'Floor' cannot be fitted: .*more relief"),
        (["--set", "output_directory=//scene.blend/below"], "choose another folder"),
    ],
)
def test_what_cannot_be_fitted_is_code_1(blend, arguments, remedy, capsys):
    before = blend.read_bytes()
    entry = reported(blend, "--quiet", "--save", *arguments, code=1)
    assert re.search(remedy, entry["error"])
    assert (entry["fit"], entry["outputs"]) == (None, [])
    output = capsys.readouterr()
    assert output.out == ""
    (line,) = output.err.splitlines()
    assert line == f"Error: {entry['error']}"
    assert blend.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["--object", "Crate", "--object", "Floor"], "name one object"),
        (["--set", "height_map=Valleys"], "images of the .blend: 'Hills'"),
        (["--set", "height_map_amplitude=-1"], "number from 0"),
        (["--colour"], "unrecognized"),
    ],
)
def test_wrong_usage(blend, arguments, remedy, capsys):
    assert run("fit", blend, *arguments) == 2
    error = capsys.readouterr().err
    assert re.search(remedy, error)
    assert "Traceback" not in error


def test_scene_without_an_active_mesh(tmp_path, capsys):
    path = tmp_path / "empty.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert run("fit", path) == 2
    assert "--object" in capsys.readouterr().err
    assert run("fit", path, "--set", "height_map=Hills") == 2
    assert "it has none" in capsys.readouterr().err


def test_a_save_that_cannot_work_is_told_before_the_work(blend, capsys):
    assert run("fit", blend, "--save", blend / "below" / "a.blend") == 2
    assert "below" in capsys.readouterr().err


def test_help(capsys):
    assert run("--help") == 0
    assert re.search(r"^ +fit ", capsys.readouterr().out, re.MULTILINE)
    assert run("fit", "--help") == 0
    output = capsys.readouterr().out
    assert all(option in output for option in ("SCENE.blend", "--object", "--set", "--save", "--report", "--quiet"))
    assert all(word in output for word in ("height_map", "occluders=SELF", "use_ground_plane", "Exit code"))


def test_what_is_told(blend, capsys):
    assert run("fit", blend, "--quiet") == 0
    output = capsys.readouterr()
    assert (output.out, output.err) == ("", "")
    assert run("fit", blend) == 0
    output = capsys.readouterr()
    assert output.out == ""
    assert re.search(r"Fitted 'Crate': A [\d.e+-]+, B [\d.e+-]+, rms", output.err)
    assert "--save" in output.err


@pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module has no program to call")
def test_as_a_program(blend, tmp_path):
    report = tmp_path / "report.json"
    command = [bpy.app.binary_path, "--command", "multibounce_ao", "fit", str(blend), "--report", str(report)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert json.loads(report.read_text())["objects"][0]["fit"]
    for arguments, code in ((["--object", "Nobody"], 1), (["--set", "samples=0"], 2), (["--help"], 0)):
        assert subprocess.run(command + arguments, capture_output=True, check=False, timeout=120).returncode == code
