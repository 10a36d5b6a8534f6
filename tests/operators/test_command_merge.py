# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao bake --share` and `merge`: the shares of a scene, brought together, are the bake of
the whole scene."""

import json

import bpy
import pytest

from .bakes import change_settings
from .commands import reported, run
from .meshes import add, box, plate
from .snapshot import differences, snapshot


@pytest.fixture
def blend(scene, tmp_path):
    """A crate between a floor and a roof of one material, another floor of the same mesh, and a pit far below, which
    is where the ground plane lies for all of them."""
    change_settings(samples=8, resolution=8, use_ground_plane=True)
    floor, roof = plate("Floor"), plate("Roof", location=(0, 0, 1))
    plaster = bpy.data.materials.new("Plaster")
    floor.data.materials.append(plaster)
    roof.data.materials.append(plaster)
    add("Twin", floor.data, location=(4, 0, 0))
    box("Crate", low=(-0.5, -0.5, 0.1), high=(0.5, 0.5, 0.5))
    plate("Pit", location=(0, 0, -1))
    return save(tmp_path / "scene.blend")


def save(path):
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def change(path, action):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    action(bpy.data.objects)
    save(path)


def bake_shares(blend, count=3, code=0):
    """The pattern of the files."""
    for index in range(1, count + 1):
        share = ["--share", f"{index}/{count}", "--save", blend.parent / f"part_{index}.blend"]
        assert run("bake", blend, "--quiet", *share) == code
    return blend.parent / "part_*.blend"


def merge(blend, *arguments, code=0):
    """By object, the errors of a merge that ends with ``code``."""
    report = blend.parent / "merge.json"
    assert run("merge", blend, *arguments, "--save", "--report", report) == code
    return {entry["name"]: entry["error"] for entry in json.loads(report.read_text(encoding="utf-8"))["objects"]}


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*")}


def left_in(path):
    """Every property of what the .blend ``path`` holds, with all values and texels; but how long it took."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    for obj in bpy.data.objects:
        obj["multibounce_ao"]["seconds"] = 0.0
    assert not bpy.data.libraries
    # A map that is packed remembers the temporary folder that it was packed from.
    return {name: value for name, value in snapshot().items() if not name.endswith("packed_files[0].filepath")}


@pytest.mark.parametrize("kind", ["vertices", "packed", "files"])
def test_merged_shares_are_the_bake_of_all(blend, kind, tmp_path, capsys):
    def prepare(objects):
        if kind == "vertices":
            return
        objects.remove(objects["Crate"])  # it has no UV map
        change_settings(target="TEXTURE", use_gltf_occlusion=True)
        if kind == "files":
            change_settings(output_directory="//maps")

    change(blend, prepare)
    whole = tmp_path / "whole.blend"
    assert run("bake", blend, "--quiet", "--save", whole) == 0
    files = contents(tmp_path / "maps")
    parts = bake_shares(blend)
    assert contents(tmp_path / "maps") == files and len(files) == (12 if kind == "files" else 0)
    assert set(merge(blend, parts)) == {"Floor", "Twin", "Roof", "Pit"} | ({"Crate"} if kind == "vertices" else set())
    assert differences(left_in(whole), left_in(blend)) == []
    capsys.readouterr()
    assert merge(blend, parts) == {}
    there = 5 if kind == "vertices" else 4
    assert capsys.readouterr().err == f"0 taken over, {there} are there already, 0 failed\n"
    assert {entry["rays"] for entry in reported(blend, "--resume")["objects"]} == {0}


def test_old_bakes_in_the_parts_do_not_replace_new_ones(blend):
    assert run("bake", blend, "--quiet", "--save") == 0
    change(blend, lambda objects: change_settings(samples=4))
    merge(blend, bake_shares(blend))
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert {obj["multibounce_ao"]["samples"] for obj in bpy.data.objects} == {4}


def test_what_cannot_be_taken_is_named_and_the_rest_is_taken(blend, tmp_path, capsys):
    parts = bake_shares(blend)
    (tmp_path / "part_broken.blend").write_bytes(b"BLENDER")

    def spoil(objects):
        objects["Floor"].data.vertices[0].co.z = 0.5  # the mesh of the twin, too
        objects["Roof"].location.x = 1.0
        objects["Crate"].name = "Box"

    change(blend, spoil)
    errors = merge(blend, parts, code=1)
    assert errors.pop("Pit") is None
    assert "cannot be read" in errors.pop("")
    assert "has another mesh, UV map or place than in 'part_1.blend'" in errors["Floor"]
    assert errors.keys() == {"Floor", "Twin", "Roof", "Crate"}
    assert "There is no object 'Crate'" in errors["Crate"]
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert [obj.name for obj in bpy.data.objects if "multibounce_ao" in obj] == ["Pit"]
    assert "Error: Object 'Roof' has another mesh" in capsys.readouterr().err


def test_wrong_usage(blend, tmp_path, capsys):
    assert run("merge", blend, tmp_path / "nothing_*.blend") == 2
    assert "there is no file" in capsys.readouterr().err
    assert run("merge", tmp_path, blend) == 2
    assert f"'{tmp_path}' is a folder: name a .blend in it" in capsys.readouterr().err
    for share in ("0/2", "3/2", "half", "1/2/3", "-1/2"):
        assert run("bake", blend, f"--share={share}") == 2
        assert "write it as I/N" in capsys.readouterr().err


def test_one_object_in_two_parts(blend, tmp_path):
    for name, seed in (("part_a", 1), ("part_b", 2)):
        arguments = ["--object", "Pit", "--set", f"seed={seed}", "--save", tmp_path / f"{name}.blend"]
        assert run("bake", blend, "--quiet", *arguments) == 0
    assert "in both 'part_a.blend' and 'part_b.blend'" in merge(blend, tmp_path / "part_*.blend", code=1)["Pit"]
    assert merge(blend, tmp_path / "part_b.blend", "--object", "P*") == {"Pit": None}
    assert run("bake", blend, "--quiet", "--share", "9/9", "--save") == 0  # nothing to do
