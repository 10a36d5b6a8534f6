# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao field`: what it bakes, exit codes, the report, and what is saved."""

import json
import re
from pathlib import Path

import bpy
import pytest

from .bakes import operators, select
from .meshes import add, box
from .props import DRAFT, FIELD, ball

REPORT_KEYS = {
    *("name", "target", "resolution", "points", "samples", "rays", "seconds", "a0", "p"),
    *("outputs", "warnings", "error"),
}


def run(*arguments):
    return operators("command_line").run([str(argument) for argument in arguments])


@pytest.fixture
def blend(scene, tmp_path):
    """A ball that is active, a box and a lamp."""
    crate, sphere = box("Crate", location=(4, 0, 0)), ball()
    add("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    for name, value in DRAFT.items():
        setattr(scene.multibounce_ao, name, value)
    select(sphere, crate)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def reported(blend, *arguments, code=0):
    report = blend.parent / "reports" / "report.json"
    assert run("field", blend, "--report", report, *arguments) == code
    report = json.loads(report.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert set(report) == {"version", "scene", "seconds", "objects"}
    assert report["scene"] == str(blend)
    assert all(set(entry) == REPORT_KEYS for entry in report["objects"])
    return report["objects"]


def test_active_object_is_the_default(blend):
    (entry,) = reported(blend)
    assert (entry["name"], entry["target"], entry["error"]) == ("Ball", "FIELD", None)
    points = (6 * 7**2 + 2) * 8
    assert (entry["resolution"], entry["points"], entry["samples"], entry["rays"]) == (8, points, 4, 4 * points)
    assert 0 <= entry["a0"] <= 1 and entry["p"] > 0
    assert entry["outputs"] == ["Ball AO Field"]


def test_named_objects_once_each(blend):
    entries = reported(blend, "--object", "Crate", "--object", "Ball", "--object", "Crate")
    assert [entry["name"] for entry in entries] == ["Crate", "Ball"]
    assert all(FIELD in bpy.data.objects[name] for name in ("Crate", "Ball"))


def test_settings(blend):
    (entry,) = reported(blend, "--set", "field_resolution=9", "--set", "samples=8")
    assert (entry["resolution"], entry["samples"]) == (9, 8)


def test_files(blend):
    (entry,) = reported(blend, "--set", "output_directory=//fields")
    files = [Path(path) for path in entry["outputs"][1:]]
    assert blend.parent / "fields" / "Ball_ao_field.json" in files
    assert all(path.is_file() for path in files)


@pytest.mark.parametrize("to", ["", "new.blend"])
def test_save(blend, to, tmp_path):
    before = blend.read_bytes()
    target = tmp_path / to if to else blend
    assert run("field", blend, "--quiet", "--save", *([target] if to else [])) == 0
    assert (blend.read_bytes() == before) == bool(to)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(target))
    assert bpy.data.objects["Ball"][FIELD]["image"] == bpy.data.images["Ball AO Field"]
    assert "AO Field Ball" in bpy.data.node_groups


def test_what_cannot_be_baked_is_code_1_and_the_rest_is_done(blend, capsys):
    entries = reported(blend, "--quiet", "--object", "Nobody", "--object", "Lamp", "--object", "Crate", code=1)
    errors = {entry["name"]: entry["error"] for entry in entries}
    assert re.search("'Nobody'.*'Crate', 'Ball'", errors["Nobody"])
    assert "'Lamp' is not a mesh" in errors["Lamp"]
    assert errors["Crate"] is None and FIELD in bpy.data.objects["Crate"]
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.splitlines() == [f"Error: {errors[name]}" for name in ("Lamp", "Nobody")]


@pytest.mark.parametrize(
    ("arguments", "remedy"),
    [
        (["--set", "field_resolution=7"], "whole number from 8 to 64"),
        (["--set", "field=1"], "there is no setting 'field'"),
        (["--colour"], "unrecognized"),
    ],
)
def test_wrong_usage(blend, arguments, remedy, capsys):
    assert run("field", blend, *arguments) == 2
    error = capsys.readouterr().err
    assert re.search(remedy, error) and "Traceback" not in error


def test_scene_without_an_active_mesh(tmp_path, capsys):
    path = tmp_path / "empty.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert run("field", path) == 2
    assert "--object" in capsys.readouterr().err
    assert run("field", tmp_path / "missing.blend") == 2


def test_tells_what_it_did(blend, capsys):
    assert run("field", blend) == 0
    error = capsys.readouterr().err
    assert "Baked the AO field of 'Ball': 8 x 8" in error
    assert "add --save" in error


def test_help(capsys):
    assert run("field", "--help") == 0
    assert "--object" in capsys.readouterr().out
