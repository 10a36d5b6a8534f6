# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that have nowhere to go: linked data and folders that cannot be written. The file stays as it was."""

import bpy
import pytest

from .bakes import bake, change_settings, reports, select
from .meshes import add, plate
from .refusals import assert_one_sentence, error_of
from .snapshot import differences, snapshot

TEXTURE = {"target": "TEXTURE", "resolution": 8}


def library(folder):
    """A .blend with a plate; the scene is empty afterwards."""
    obj = plate("Bad")
    path = folder / "library.blend"
    bpy.data.libraries.write(str(path), {obj})
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return str(path)


@pytest.mark.parametrize("linked", ["objects", "meshes"])
@pytest.mark.parametrize("settings", [{}, TEXTURE], ids=["vertices", "texture"])
def test_linked_mesh(linked, settings, tmp_path):
    path = library(tmp_path)
    with bpy.data.libraries.load(path, link=True) as (there, here):
        setattr(here, linked, getattr(there, linked))
    if linked == "meshes":
        obj = add("Bad", here.meshes[0])
    else:
        obj = here.objects[0]
        bpy.context.scene.collection.objects.link(obj)
    change_settings(samples=8, **settings)
    select(obj)
    before = snapshot()
    message = error_of(bpy.ops.multibounce_ao.bake)
    assert_one_sentence(message)
    assert "linked" in message
    assert "Make Local" in message
    assert differences(before, snapshot()) == []


def test_linked_material_stays_as_it_is(tmp_path):
    source = plate("Source")
    source.data.materials.append(bpy.data.materials.new("Linked"))
    path = str(tmp_path / "library.blend")
    bpy.data.libraries.write(path, {source.data.materials[0]})
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (there, here):
        here.materials = there.materials
    obj = plate()
    obj.data.materials.append(here.materials[0])
    before = {k: v for k, v in snapshot().items() if k.startswith("materials")}
    (report,) = reports(obj)
    after = {k: v for k, v in snapshot().items() if k.startswith("materials")}
    assert differences(before, after) == []
    assert report.error is None
    assert any("'Linked'" in warning and "local" in warning for warning in report.warnings)
    assert not bpy.ops.multibounce_ao.add_nodes.poll()


def a_file(folder):
    (folder / "taken").write_text("not a folder")
    return str(folder / "taken")


def below_a_file(folder):
    return a_file(folder) + "/maps"


def of_the_system(folder):
    return "/proc/maps"


@pytest.mark.parametrize("make", [a_file, below_a_file, of_the_system])
def test_output_folder_that_cannot_be_written(make, tmp_path):
    change_settings(**TEXTURE, samples=8, output_directory=make(tmp_path))
    obj = plate()
    select(obj)
    before = snapshot()
    message = error_of(bpy.ops.multibounce_ao.bake)
    folder = bpy.context.scene.multibounce_ao.output_directory
    assert message.startswith(f"Output '{folder}' ")
    assert ": choose" in message
    assert "\n" not in message
    assert differences(before, snapshot()) == []
    # To vertices nothing is written there, so it is none of our business.
    bake(obj, target="VERTEX")


def test_folder_that_goes_away_while_baking(tmp_path):
    """The file cannot be written at the end: the report says so, and the object is left as it was."""
    obj = plate()
    folder = tmp_path / "maps"
    folder.mkdir()
    (folder / "Plate_multibounce_ao.exr").write_text("old")
    (folder / "Plate_bent_cone.exr").mkdir()
    change_settings(samples=8)
    (report,) = reports(obj, **TEXTURE, output_directory=str(folder))
    assert_one_sentence(report.error.replace(str(folder), "folder"), "Plate")
    assert str(folder) in report.error
    assert "choose another" in report.error
    assert report.outputs == []
    assert (folder / "Plate_multibounce_ao.exr").read_text() == "old"  # not the one without the other
    assert len(list(folder.iterdir())) == 2
    assert "multibounce_ao" not in obj
    assert not bpy.data.images
    assert not obj.material_slots
