# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao info`: what is baked in a file."""

import json

import bpy
import pytest

from .bakes import bake
from .commands import run
from .meshes import box, plate
from .props import bake_field


@pytest.fixture
def blend(scene, tmp_path):
    """A floor that is baked to vertices, a wall to images, a crate with a field, and a box with nothing."""
    floor, wall = plate("Floor"), plate("Wall", location=(9, 0, 0))
    bake_field(box("Crate", location=(20, 0, 0)))
    box("Bare", location=(30, 0, 0))
    bake(floor, samples=16, bounces="FITTED")
    bake(wall, samples=4, target="TEXTURE", resolution=8)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def test_what_is_told(blend, capsys, tmp_path):
    before = blend.read_bytes()
    capsys.readouterr()
    assert run("info", blend, "--report", tmp_path / "info.json") == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines() if "blend" not in line]
    assert lines[0][:3] == ["object", "target", "bounces"]
    told = {words[0]: words[1:] for words in lines[1:]}
    assert told == {
        "Floor": ["VERTEX", "FITTED", "16", "25", "1.0000", "-"],
        "Wall": ["TEXTURE", "FITTED", "4", "64", "1.0000", "-"],
        "Crate": ["-", "-", "-", "-", "-", "8", "x", "8"],
    }
    report = json.loads((tmp_path / "info.json").read_text(encoding="utf-8"))
    entries = {entry["name"]: entry for entry in report["objects"]}
    assert entries["Floor"]["bake"]["samples"] == 16
    assert entries["Floor"]["bake"]["outputs"] == ["Multibounce AO", "Bent Cone"]
    assert entries["Wall"]["bake"]["images"]["Bent Cone"] == "Wall Bent Cone"
    assert entries["Crate"]["bake"] is None and entries["Crate"]["field"]["resolution"] == 8
    assert blend.read_bytes() == before


def test_objects_that_are_asked_for(blend, capsys):
    assert run("info", blend, "--object", "B*", "--object", "Nobody") == 1
    output = capsys.readouterr()
    assert "no object 'Nobody'" in output.err
    assert output.out.splitlines()[-1].split() == ["Bare", *"------"]
    assert run("info", blend, "--set", "samples=4") == 2


def test_a_bake_that_is_lost(blend, capsys):
    bpy.data.objects["Floor"].data.attributes.remove(bpy.data.objects["Floor"].data.attributes["Bent Cone"])
    bpy.data.objects["Floor"].data.attributes.remove(bpy.data.objects["Floor"].data.attributes["Multibounce AO"])
    bpy.ops.wm.save_mainfile()
    assert run("info", blend) == 1
    assert "Error: Object 'Floor' has lost what its bake left: bake it again" in capsys.readouterr().err
