# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao world`: what it keeps, exit codes and the report."""

import json

import bpy
import pytest

from .bakes import operators
from .worlds import world

STORED = "multibounce_ao_world"


def run(*arguments):
    return operators("command_line").run([str(argument) for argument in arguments])


@pytest.fixture
def blend(scene, tmp_path):
    world((0.25, 0.5, 1.0))
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def test_saved_and_reported(blend, capsys):
    report = blend.parent / "report.json"
    assert run("world", blend, "--save", "--report", report) == 0
    assert "Projected World 'World', mean 0.25, 0.5, 1" in capsys.readouterr().err
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert bpy.context.scene[STORED]["world"] == "World"
    written = json.loads(report.read_text(encoding="utf-8"))
    assert set(written) == {"version", "scene", "seconds", "objects"}
    (entry,) = written["objects"]
    assert (entry["name"], entry["error"]) == ("World", None)


def test_not_saved(blend, capsys):
    before = blend.read_bytes()
    assert run("world", blend) == 0
    assert "--save" in capsys.readouterr().err
    assert run("world", blend, "--quiet") == 0
    assert capsys.readouterr().err == ""
    assert blend.read_bytes() == before


def test_scene_without_a_world(scene, tmp_path, capsys):
    path, report = tmp_path / "dark.blend", tmp_path / "report.json"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    before = path.read_bytes()
    assert run("world", path, "--quiet", "--save", "--report", report) == 1
    assert "has no World: add one" in capsys.readouterr().err
    assert "has no World" in json.loads(report.read_text(encoding="utf-8"))["objects"][0]["error"]
    assert path.read_bytes() == before


def test_wrong_usage(blend, capsys):
    assert run("world", blend, "--object", "Wall") == 2
    assert "leave --object out" in capsys.readouterr().err
