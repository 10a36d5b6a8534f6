# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao bake`: which objects are baked, which are left as they are, and what becomes of the
rest where some cannot be baked."""

import bpy
import pytest

from .bakes import operators
from .commands import reported, run, save_several
from .meshes import add, plate


@pytest.fixture
def blend(scene, tmp_path):
    return save_several(tmp_path)


def test_patterns_name_meshes(blend):
    report = reported(blend, "--object", "F*", "--object", "?loor", "--object", "Lamp*", code=1)
    entries = {entry["name"]: entry["error"] for entry in report["objects"]}
    assert set(entries) == {"Far", "Floor", "Folded away", "Lamp*"}
    assert entries["Far"] is entries["Floor"] is None
    assert "is hidden in the viewport" in entries["Folded away"]
    assert "no object 'Lamp*'" in entries["Lamp*"]  # a lamp is no mesh


def test_collections(blend):
    assert [entry["name"] for entry in reported(blend, "--collection", "Attic")["objects"]] == ["Stored"]
    both = reported(blend, "--collection", "A*", "--object", "Floor", "--object", "Stored")
    assert [entry["name"] for entry in both["objects"]] == ["Floor", "Stored"]
    report = reported(blend, "--collection", "Cellar", code=1)
    assert "no collection 'Cellar'" in report["objects"][0]["error"]
    assert "'Attic'" in report["objects"][0]["error"]


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_resume_leaves_what_is_baked_already(blend, target, tmp_path, capsys):
    settings = ["--set", f"target={target}", "--set", "resolution=8", "--set", "samples=16", "--save"]
    settings += ["--set", f"output_directory={tmp_path / 'maps'}"]
    common = [*settings, "--object", "Floor", "--object", "Far", "--resume"]

    def rays(*arguments):
        return {entry["name"]: entry["rays"] for entry in reported(blend, *common, *arguments)["objects"]}

    def change(action):
        bpy.ops.wm.open_mainfile(filepath=str(blend))
        action(bpy.data.objects)
        bpy.ops.wm.save_mainfile()

    def lose(objects):
        if target == "VERTEX":
            objects["Floor"].data.attributes.remove(objects["Floor"].data.attributes["Multibounce AO"])
        else:
            (tmp_path / "maps" / "Floor_multibounce_ao.exr").unlink()

    first = rays()
    assert min(first.values()) > 0
    assert "2 baked, 0 failed, in " in capsys.readouterr().err
    again = reported(blend, *common)["objects"]
    assert [entry["rays"] for entry in again] == [0, 0]
    assert [entry["points"] * 16 for entry in again] == list(first.values())
    assert all(entry["f0"] and entry["outputs"] and entry["left"] for entry in again)
    lines = capsys.readouterr().err.splitlines()
    assert not any(line.startswith("Warning") for line in lines)
    assert [line.split()[-3:] for line in lines[1:3]] == [["as", "it", "was"]] * 2
    assert lines[3].startswith("0 baked, 2 left as they are, 0 failed, in ") and len(lines) == 4
    assert rays("--set", "seed=1") == first  # other settings
    assert set(rays("--set", "seed=1").values()) == {0}
    change(lambda objects: setattr(objects["Far"], "location", (0, 0, 51)))  # disabled in renders: it blocks nothing
    assert rays("--set", "seed=1") == first | {"Floor": 0}
    change(lambda objects: setattr(objects["Crate"], "location", (0, 0, 1)))  # it blocks both
    assert rays("--set", "seed=1") == first
    change(lose)
    assert rays("--set", "seed=1") == first | {"Far": 0}


def test_checkpoints_save_on_the_way(blend, monkeypatch):
    saved = []
    for module in ("command_bake", "command_files"):
        monkeypatch.setattr(operators(module), "save_scene", lambda name: saved.append(name) or True)
    assert run("bake", blend, "--quiet", "--save", "--checkpoint", "1e-9") == 0
    assert saved == ["", ""]  # after the first object, and at the end
    assert run("bake", blend, "--quiet", "--save") == 0
    assert len(saved) == 3


def test_a_fault_of_ours_fails_one_object_alone(blend, monkeypatch, capsys):
    job = operators("bake_job")
    compute = job._bake_object

    def faulty(context, obj, *rest):
        if obj.name == "Crate":
            raise MemoryError("no room")
        return compute(context, obj, *rest)

    monkeypatch.setattr(job, "_bake_object", faulty)
    entries = {entry["name"]: entry["error"] for entry in reported(blend, code=1)["objects"]}
    assert entries["Floor"] is None
    assert entries["Crate"] == "Object 'Crate' could not be baked (MemoryError: no room): report this"
    assert "Traceback" in capsys.readouterr().err


def test_a_hundred_objects_with_seven_that_are_broken(scene, tmp_path, capsys):
    """93 are baked, 7 are named with their reasons, the code is 1 and the report complete."""
    for index in range(93):
        plate(f"Good {index:02}", steps=1, location=(3 * index, 0, 0))
    broken = {
        "Bad empty": "has no faces",
        "Bad vertex": "has 1 vertex whose coordinates are not finite",
        "Bad scale": "has a scale of zero",
        "Bad place": "has a transform that is not finite",
        "Bad modifier": "has no faces left after its modifiers",
        "Bad name": "has a UV map, vertex group or attribute 'Bent Cone' that is no color",
        "Bad layer": "is hidden in the viewport",
    }
    bad = {name: plate(name, steps=1, location=(0, 0, 9)) for name in broken}
    bad["Bad empty"].data = bpy.data.meshes.new("Empty")
    bad["Bad vertex"].data.vertices[0].co.x = float("nan")
    bad["Bad scale"].scale = (1, 0, 1)
    bad["Bad place"].parent = parent = add("Parent", None)
    bad["Bad place"].scale = parent.scale = (1e30, 1e30, 1e30)  # the product is more than a float holds
    mask = bad["Bad modifier"].modifiers.new("Mask", "MASK")
    mask.vertex_group = bad["Bad modifier"].vertex_groups.new(name="None").name
    bad["Bad name"].vertex_groups.new(name="Bent Cone")
    bad["Bad layer"].hide_set(True)
    blend = tmp_path / "hundred.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    settings = ["--set", "samples=4", "--set", "bounces=FITTED", "--set", "use_material_nodes=off"]
    entries = reported(blend, "--object", "*", *settings, "--save", code=1)["objects"]
    assert len(entries) == 100
    failed = {entry["name"]: entry["error"] for entry in entries if entry["error"]}
    assert set(failed) == set(broken)
    for name, reason in broken.items():
        assert failed[name].startswith(f"Object '{name}' {reason}")
    assert all(entry["f0"] for entry in entries if not entry["error"])
    error = capsys.readouterr().err
    assert "93 baked, 7 failed, in " in error
    assert error.count("Error: ") == 7
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    assert sum("multibounce_ao" in obj for obj in bpy.data.objects) == 93


def test_resume_leaves_twins(scene, tmp_path, capsys):
    """Objects that share a mesh; but not one that came to it since."""
    add("Twin", plate("Floor").data, location=(9, 0, 0))
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    common = ["--set", "samples=4", "--resume", "--save"]
    reported(path, *common)
    assert [entry.get("left") for entry in reported(path, *common)["objects"]] == [True, True]
    add("Third", bpy.data.objects["Floor"].data, location=(0, 0, -99)).hide_render = True
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    entries = reported(path, *common, "--object", "Floor", "--object", "Third")["objects"]
    assert [entry.get("left") for entry in entries] == [True, None]
    assert "1 baked, 1 left as they are, 0 failed" in capsys.readouterr().err


def test_a_warning_that_many_have_is_printed_once(scene, tmp_path, capsys):
    for index in range(4):
        plate(f"Floor {index}", steps=1, location=(3 * index, 0, 0))
    for vertex in plate("Broken", steps=1).data.vertices:
        vertex.co.x = float("nan")
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    entries = reported(path, "--set", "samples=4", "--object", "Floor *")["objects"]
    (warning,) = entries[0]["warnings"]
    assert all(entry["warnings"] == [warning] for entry in entries)
    warnings = [line for line in capsys.readouterr().err.splitlines() if line.startswith("Warning: ")]
    assert warnings == [f"Warning: 4 objects ('Floor 0', 'Floor 1', 'Floor 2', ...): {warning}"]
