# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao bake --scene NAME`: several scenes of one .blend, each as if it were alone."""

import json

import bpy
import numpy as np
import pytest

from .bakes import attribute
from .commands import reported, run
from .meshes import plate


def add_scene(name, *objects, **settings):
    made = bpy.data.scenes.new(name)
    for obj in objects:
        made.collection.objects.link(obj)
    for setting, value in settings.items():
        setattr(made.multibounce_ao, setting, value)
    return made


def moved_to(scene, obj):
    scene.collection.objects.link(obj)
    bpy.context.scene.collection.objects.unlink(obj)
    return obj


@pytest.fixture
def blend(scene, tmp_path):
    """Three scenes: a floor under a roof, which is not in the second; the second has settings of its own; and one that
    has nothing to bake."""
    scene.multibounce_ao.samples = 8
    scene.name = "Day"
    plate("Floor")
    night = add_scene("Night", samples=16, max_distance=0.5)
    moved_to(night, plate("Street"))
    moved_to(night, plate("Roof", location=(0, 0, 0.4)))
    add_scene("Empty")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def baked(path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return {obj.name: attribute(obj) for obj in bpy.data.objects if "multibounce_ao" in obj}


def test_each_scene_is_baked_with_its_own_settings_and_occluders(blend, tmp_path, capsys):
    report = reported(blend, "--all-scenes", "--save")
    entries = {entry["name"]: entry for entry in report["objects"]}
    assert {name: entry["scene"] for name, entry in entries.items()} == {
        "Floor": "Day",
        "Street": "Night",
        "Roof": "Night",
    }
    assert {name: entry["samples"] for name, entry in entries.items()} == {"Floor": 8, "Street": 16, "Roof": 16}
    assert entries["Floor"]["f0"]["min"] == 1.0  # nothing of the other scene stands over it
    # Below the roof's middle it blocks what is within .5, where the cosine is over .4 / .5: sin^2 = .36 of the light.
    assert entries["Street"]["f0"]["min"] == pytest.approx(1 - 0.36, abs=0.05)
    assert entries["Street"]["warnings"] == []
    error = capsys.readouterr().err
    assert error.splitlines()[0].split() == ["scene", "object", "points", "rays", "seconds", "mean", "AO"]
    assert [line.split()[:2] for line in error.splitlines()[1:4]] == [
        ["Day", "Floor"],
        ["Night", "Street"],
        ["Night", "Roof"],
    ]
    together = baked(blend)
    # The same bits as when that scene is the file's active one.
    bpy.context.window_manager.windows[0].scene = bpy.data.scenes["Night"]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "night.blend"))
    report = reported(tmp_path / "night.blend", "--save")
    assert all("scene" not in entry for entry in report["objects"])
    alone = baked(tmp_path / "night.blend")
    for name in ("Street", "Roof"):
        np.testing.assert_array_equal(together[name], alone[name])


def test_names_patterns_and_settings_that_are_given(blend):
    report = reported(blend, "--scene", "N*", "--scene", "Day", "--scene", "Night", "--set", "samples=4")
    assert [entry["scene"] for entry in report["objects"]] == ["Night", "Night", "Day"]
    assert {entry["samples"] for entry in report["objects"]} == {4}
    # An object is missing where none of the scenes has it.
    found, missing = reported(blend, "--all-scenes", "--object", "Floor", "--object", "Nobody", code=1)["objects"]
    assert (found["name"], found["error"], missing["name"]) == ("Floor", None, "Nobody")
    assert "There is no object 'Nobody'" in missing["error"]
    report = reported(blend, "--all-scenes", "--resume", "--object", "Str*", "--save")
    assert report["objects"][0]["rays"]
    report = reported(blend, "--all-scenes", "--resume", "--object", "Str*")
    assert not report["objects"][0]["rays"]


def test_info_and_merge_know_all_scenes(blend, capsys, tmp_path):
    for share in ("1/2", "2/2"):
        part = tmp_path / f"part {share[0]}.blend"
        assert run("bake", blend, "--all-scenes", "--quiet", "--share", share, "--save", part) == 0
    assert run("merge", blend, tmp_path / "part *.blend", "--object", "Roof", "--save") == 0
    assert run("merge", blend, tmp_path / "part *.blend", "--save") == 0
    capsys.readouterr()
    assert run("info", blend, "--report", tmp_path / "info.json") == 0
    lines = [line.split()[:3] for line in capsys.readouterr().out.splitlines() if "blend" not in line]
    expected = [["Day", "Floor"], ["Night", "Street"], ["Night", "Roof"]]
    assert lines == [["scene", "object", "target"], *([*each, "VERTEX"] for each in expected)]
    entries = json.loads((tmp_path / "info.json").read_text(encoding="utf-8"))["objects"]
    assert [[entry["scene"], entry["name"]] for entry in entries] == expected
    assert run("info", blend, "--object", "Nobody") == 1
    told = capsys.readouterr().err
    assert "Error: There is no object 'Nobody' in the .blend: choose among 'Floor', 'Street', 'Roof'" in told


def test_what_two_scenes_share_shows_the_last_bake(scene, tmp_path, capsys):
    add_scene("Other", plate("Shared"))
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    first, second = reported(path, "--all-scenes", "--set", "samples=4")["objects"]
    assert first["warnings"] == []
    (warning,) = second["warnings"]
    assert warning.startswith(f"Is in scene '{first['scene']}' too, whose bake this one replaced")


def test_wrong_usage(blend, capsys):
    before = blend.read_bytes()
    assert run("bake", blend, "--scene", "Dusk", "--scene", "Day", "--save") == 2
    assert "there is no scene 'Dusk' in the .blend: choose among 'Day', 'Empty', 'Night'" in capsys.readouterr().err
    assert run("bake", blend, "--scene", "Empty") == 2
    assert "scene 'Empty': no mesh" in capsys.readouterr().err
    assert blend.read_bytes() == before
