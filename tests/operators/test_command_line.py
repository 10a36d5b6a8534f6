# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao bake`: exit codes, the report, and what is saved."""

import json
import re
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from .bakes import f0, operators
from .commands import reported, run, save_several

OBJECT_KEYS = {"name", "target", "points", "samples", "rays", "seconds", "f0", "outputs", "warnings", "error"}


@pytest.fixture
def blend(scene, tmp_path):
    return save_several(tmp_path)


def test_report(blend):
    report = reported(blend, "--set", "samples=16")
    assert set(report) == {"version", "scene", "seconds", "objects"}
    assert re.fullmatch(r"\d+\.\d+\.\d+", report["version"])
    assert report["scene"] == str(blend)
    crate, floor = sorted(report["objects"], key=lambda entry: entry["name"])
    for entry in (crate, floor):
        assert set(entry) == OBJECT_KEYS
        assert set(entry["f0"]) == {"min", "mean", "max"}
        assert entry["target"] == "VERTEX"
        assert entry["outputs"] == ["Multibounce AO", "Bent Cone"]
        assert entry["warnings"] == []
        assert entry["error"] is None
        assert 0 < entry["seconds"] <= report["seconds"]
    assert (floor["name"], floor["points"], floor["samples"], floor["rays"]) == ("Floor", 25, 16, 400)
    # A flat box has three normals at each of its eight corners.
    assert (crate["name"], crate["points"], crate["rays"]) == ("Crate", 24, 384)
    for entry in (crate, floor):
        values = f0(bpy.data.objects[entry["name"]])
        assert entry["f0"]["min"] == values.min()
        assert entry["f0"]["max"] == values.max()
        assert entry["f0"]["mean"] == pytest.approx(values.mean(), abs=1e-7)


def test_meshes_that_renders_show_are_the_default(blend):
    assert {entry["name"] for entry in reported(blend)["objects"]} == {"Floor", "Crate"}


def test_named_objects(blend):
    report = reported(blend, "--object", "Far", "--object", "Floor", "--object", "Far")
    assert [entry["name"] for entry in report["objects"]] == ["Far", "Floor"]
    assert any("renders" in warning for warning in report["objects"][0]["warnings"])
    assert "multibounce_ao" not in bpy.data.objects["Crate"]


def test_what_cannot_be_baked_is_code_1_and_the_rest_is_done(blend, capsys):
    report = reported(blend, "--object", "Nobody", "--object", "Floor", "--object", "Lamp", "--save", code=1)
    entries = {entry["name"]: entry for entry in report["objects"]}
    assert set(entries) == {"Nobody", "Floor", "Lamp"}
    assert all(set(entry) == OBJECT_KEYS for entry in entries.values())
    assert "'Nobody'" in entries["Nobody"]["error"]
    assert "'Floor'" in entries["Nobody"]["error"]  # what one could have meant
    assert "'Lamp' is not a mesh" in entries["Lamp"]["error"]
    assert entries["Floor"]["error"] is None
    errors = [line for line in capsys.readouterr().err.splitlines() if line.startswith("Error: ")]
    assert len(errors) == 2
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert "multibounce_ao" in bpy.data.objects["Floor"]


def test_texture_without_uvs(blend, tmp_path):
    """The crate has no UV map."""
    report = reported(blend, "--set", "target=TEXTURE", "--set", "resolution=8", "--set", "margin=0", code=1)
    entries = {entry["name"]: entry for entry in report["objects"]}
    assert "no UV map" in entries["Crate"]["error"]
    assert (entries["Crate"]["points"], entries["Crate"]["f0"], entries["Crate"]["outputs"]) == (0, None, [])
    assert entries["Floor"]["outputs"] == ["Floor Multibounce AO", "Floor Bent Cone"]
    assert entries["Floor"]["points"] == 64

    maps = tmp_path / "maps"
    settings = ["--set", "target=texture", "--set", "resolution=8", "--set", f"output_directory={maps}"]
    report = reported(blend, "--object", "Floor", *settings)
    (entry,) = report["objects"]
    assert [Path(path) for path in entry["outputs"]] == [
        maps / "Floor_multibounce_ao.exr",
        maps / "Floor_bent_cone.exr",
    ]
    assert all(Path(path).is_file() for path in entry["outputs"])


def test_output_folder_relative_to_the_blend(blend):
    reported(
        blend,
        "--object",
        "Floor",
        "--set",
        "target=TEXTURE",
        "--set",
        "resolution=4",
        "--set",
        "output_directory=//maps",
    )
    assert (blend.parent / "maps" / "Floor_bent_cone.exr").is_file()


def test_output_folder_that_cannot_be_written(blend, capsys):
    report = reported(blend, "--set", "target=TEXTURE", "--set", f"output_directory={blend}/maps", code=1)
    assert {entry["name"] for entry in report["objects"]} == {"Floor", "Crate"}
    assert all("choose another folder" in entry["error"] for entry in report["objects"])
    assert "choose another folder" in capsys.readouterr().err


@pytest.mark.parametrize("to", ["", "new.blend", "made/for/it.blend"])
def test_save(blend, to, tmp_path):
    before = blend.read_bytes()
    target = tmp_path / to if to else blend
    assert run("bake", blend, "--quiet", "--save", *([target] if to else [])) == 0
    assert (blend.read_bytes() == before) == bool(to)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(target))
    np.testing.assert_array_equal(f0(bpy.data.objects["Floor"]), 1)
    assert bpy.data.objects["Floor"]["multibounce_ao"]["points"] == 25


def test_without_save_the_file_is_left_alone(blend, capsys):
    before = blend.read_bytes()
    assert run("bake", blend) == 0
    assert blend.read_bytes() == before
    assert "--save" in capsys.readouterr().err


def test_packed_images_are_saved(blend):
    settings = ["--set", "target=TEXTURE", "--set", "resolution=4", "--set", "use_material_nodes=off"]
    assert run("bake", blend, "--quiet", "--object", "Floor", *settings, "--save") == 0
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert {image.name for image in bpy.data.images} >= {"Floor Multibounce AO", "Floor Bent Cone"}


def test_settings_of_the_file_hold_where_none_is_given(blend, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    bpy.context.scene.multibounce_ao.samples = 8
    bpy.ops.wm.save_mainfile()
    assert {entry["samples"] for entry in reported(blend)["objects"]} == {8}
    assert {entry["samples"] for entry in reported(blend, "--set", "samples=4")["objects"]} == {4}


@pytest.mark.parametrize(
    ("text", "name", "value"),
    [
        ("samples=7", "samples", 7),
        ("max_distance=2.5", "max_distance", 2.5),
        ("falloff=linear", "falloff", "LINEAR"),
        ("occluders=SELF", "occluders", "SELF"),
        ("use_ground_plane=on", "use_ground_plane", True),
        ("use_ground_plane=0", "use_ground_plane", False),
        ("use_material_nodes=False", "use_material_nodes", False),
        ("uv_map=a=b", "uv_map", "a=b"),
        ("uv_map=", "uv_map", ""),
    ],
)
def test_set(blend, text, name, value):
    assert run("bake", blend, "--quiet", "--set", text) == 0
    assert bpy.data.objects["Floor"]["multibounce_ao"][name] == value
    assert not bpy.context.scene.multibounce_ao.is_property_set(name)


@pytest.mark.parametrize("command", ["bake", "field", "fit", "world"])
def test_set_holds_for_one_run(blend, command, monkeypatch):
    """What is saved has the scene's own settings, at a checkpoint too."""
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    own = bpy.context.scene.multibounce_ao
    own.samples, own.occluders, own.height_map = 8, "SELF", bpy.data.images.new("Hills", 4, 4)
    bpy.context.view_layer.objects.active = bpy.data.objects["Floor"]
    for vertex in bpy.data.objects["Floor"].data.vertices:
        vertex.co.z = 0.5 * (vertex.index % 2)  # a relief that can be fitted
    bpy.context.scene.world = bpy.data.worlds.new("Sky")
    bpy.ops.wm.save_mainfile()
    saves = []

    def seen(scene):
        found = scene.multibounce_ao
        return found.samples, found.occluders, found.height_map, found.is_property_set("seed")

    def save(name):
        saves.append(seen(bpy.context.scene))
        return True

    for module in ("command_bake", "command_files"):
        monkeypatch.setattr(operators(module), "save_scene", save)
    given = [part for text in ("samples=4", "occluders=VISIBLE", "height_map=", "seed=2") for part in ("--set", text)]
    more = ["--checkpoint", "1e-9"] if command == "bake" else []
    assert run(command, blend, "--quiet", *given, "--save", *more) == 0
    assert saves == [(8, "SELF", bpy.data.images["Hills"], False)] * (2 if command == "bake" else 1)
    if command == "bake":
        assert bpy.data.objects["Floor"]["multibounce_ao"]["samples"] == 4


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("sample=7", "'sample'.*choose among .*samples"),
        ("name=x", "'name'.*choose among"),
        ("samples", "PROPERTY=VALUE"),
        ("samples=many", "whole number"),
        ("samples=2.5", "whole number"),
        ("samples=0", "from 1 to"),
        ("samples=99999999999", "from 1 to"),
        ("max_distance=-1", "number from 0"),
        ("max_distance=nan", "number"),
        ("target=PIXELS", "VERTEX, TEXTURE"),
        ("use_ground_plane=maybe", "on or off"),
        ("seed=-1", "from 0"),
    ],
)
def test_set_that_is_wrong(blend, text, remedy, capsys):
    before = blend.read_bytes()
    assert run("bake", blend, "--set", text, "--save") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("multibounce_ao: ")
    assert text in line
    assert re.search(remedy, line)
    assert blend.read_bytes() == before
    assert "multibounce_ao" not in bpy.data.objects["Floor"]


def test_wrong_usage(blend, tmp_path, capsys):
    (tmp_path / "broken.blend").write_bytes(b"not a .blend")
    for arguments in (
        (),
        ("boil",),
        ("bake",),
        ("bake", blend, "--colour"),
        ("bake", blend, "--object"),
        ("bake", tmp_path / "missing.blend"),
        ("bake", tmp_path),
        ("bake", tmp_path / "broken.blend"),
    ):
        assert run(*arguments) == 2
        error = capsys.readouterr().err
        assert error.strip()
        assert "Traceback" not in error


@pytest.mark.parametrize(
    "arguments",
    [["bake", "--save", "a.blend"], ["fit", "--save", "a.blend"], ["merge", "--save", "a.blend", "b.blend"]],
)
def test_a_file_that_save_took(extension, arguments, capsys):
    assert run(*arguments) == 2
    told = "--save took a.blend as the name to save as: write the .blend first, or --save=NAME"
    assert capsys.readouterr().err == f"multibounce_ao: {told}\n"
    for others in (["--save=a.blend"], ["--save"], ["--save", "a.blend", "--jobs", "none", "b.blend"]):
        assert run("bake", *others) == 2
        assert "--save took" not in capsys.readouterr().err


def test_scene_without_a_mesh(tmp_path, capsys):
    path = tmp_path / "empty.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert run("bake", path) == 2
    assert "no mesh" in capsys.readouterr().err


def test_report_that_cannot_be_written(blend, capsys):
    assert run("bake", blend, "--report", blend / "below" / "a.json") == 2
    error = capsys.readouterr().err
    assert "below" in error
    assert "Traceback" not in error


def test_a_save_that_cannot_work_is_told_before_the_work(blend, capsys):
    assert run("bake", blend, "--save", blend / "below" / "a.blend") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--save" in line and "below" in line and "cannot be written" in line
    assert "multibounce_ao" not in bpy.data.objects.get("Floor", {})


@pytest.mark.parametrize("arguments", [["--help"], ["bake", "--help"]])
def test_help(arguments, capsys):
    assert run(*arguments) == 0
    output = capsys.readouterr().out
    assert "bake" in output
    if "bake" in arguments:
        assert all(option in output for option in ("SCENE.blend", "--object", "--set", "--save", "--report", "--quiet"))


def test_quiet(blend, capsys):
    assert run("bake", blend, "--quiet") == 0
    output = capsys.readouterr()
    assert (output.out, output.err) == ("", "")
    assert run("bake", blend, "--quiet", "--object", "Nobody") == 1
    output = capsys.readouterr()
    assert output.out == ""
    assert len(output.err.splitlines()) == 1


def test_progress_goes_to_a_terminal_and_not_into_a_pipe(blend, capsys, monkeypatch):
    for terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        assert run("bake", blend) == 0
        output = capsys.readouterr()
        assert output.out == ""  # free for what the caller pipes
        assert ("0 %" in output.err) == terminal
        assert re.search(r"^Floor +25 +6,400 +\d+\.\d\d +1\.0000$", output.err, re.MULTILINE)
        assert "2 baked, 0 failed, in " in output.err


def test_relative_paths(blend, monkeypatch):
    monkeypatch.chdir(blend.parent)
    assert run("bake", blend.name, "--quiet", "--save", "other.blend", "--report", "report.json") == 0
    assert (blend.parent / "other.blend").is_file()
    assert json.loads((blend.parent / "report.json").read_text())["scene"] == "scene.blend"


@pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module has no program to call")
def test_as_a_program(blend, tmp_path):
    report = tmp_path / "report.json"
    command = [bpy.app.binary_path, "--command", "multibounce_ao", "bake", str(blend), "--report", str(report)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert len(json.loads(report.read_text())["objects"]) == 2
    for arguments, code in ((["--object", "Nobody"], 1), (["--set", "samples=0"], 2), (["--help"], 0)):
        assert subprocess.run(command + arguments, capture_output=True, check=False, timeout=120).returncode == code
