# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake belongs to its object: whatever that is named by now, and whatever was made from it."""

import itertools
from pathlib import Path

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, bake, clear, f0, pixels, reports, select
from .materials import group, material, source
from .meshes import box, plate

TEXTURE = {"bounces": "FITTED", "target": "TEXTURE", "resolution": 8}


def linked(obj, x):
    bpy.context.scene.collection.objects.link(obj)
    obj.location.x = x
    return obj


def duplicate(obj, name="Duplicate"):
    """Shift+D."""
    copy = obj.copy()
    copy.name, copy.data = name, obj.data.copy()
    return linked(copy, x=9)


def second_user(obj, name="Second"):
    """Of the same mesh, without a bake."""
    return linked(bpy.data.objects.new(name, obj.data), x=9)


def painted(name="Plate", **where):
    obj = plate(name, **where)
    obj.data.materials.append(material())
    return obj


def image_of(obj):
    """That the node group of ``obj`` is fed from."""
    return source(group(obj.active_material).inputs["AO"]).node.image


def image_names():
    return sorted(image.name for image in bpy.data.images)


def names_of(*objects):
    return sorted(f"{name} {channel}" for name in objects for channel in (MULTIBOUNCE_AO, BENT_CONE))


def nothing_is_left():
    nodes = [node for each in bpy.data.materials for node in each.node_tree.nodes]
    return not bpy.data.images and not [node for node in nodes if node.bl_idname.endswith(("TexImage", "Group"))]


def test_renamed_then_cleared():
    obj = painted()
    bake(obj, **TEXTURE)
    obj.name = "New"
    clear(obj)
    assert nothing_is_left()


def test_renamed_then_baked_again():
    obj = painted()
    bake(obj, **TEXTURE)
    obj.name = "New"
    bake(obj, **TEXTURE)
    assert image_names() == names_of("New")
    assert image_of(obj).name == "New Bent Cone"


def test_renamed_then_nodes_added():
    obj = painted()
    bake(obj, **TEXTURE)
    obj.name = "New"
    select(obj)
    bpy.ops.multibounce_ao.add_nodes()
    assert image_of(obj).name == "Plate Bent Cone"


@pytest.mark.parametrize("to_files", [False, True])
def test_another_object_takes_the_name(to_files, tmp_path):
    """The renamed one keeps its map, and its file, under a box that the new one does not have."""
    settings = TEXTURE | {"output_directory": str(tmp_path) if to_files else ""}
    old = painted("Floor")
    box(low=(-1.5, -1.5, 0.5), high=(1.5, 1.5, 2))
    bake(old, **settings)
    before = pixels(image_of(old))
    assert before[..., 3].min() < 0.9
    old.name = "Old"
    new = painted("Floor", location=(50, 0, 0))
    bake(new, **settings)
    assert image_names() == names_of("Floor", "Old")
    for obj in (old, new):
        assert image_of(obj).name == f"{obj.name} Bent Cone"
        image_of(obj).reload()
    np.testing.assert_array_equal(pixels(image_of(old)), before)
    np.testing.assert_allclose(pixels(image_of(new))[..., 3], 1, atol=0.01)
    assert len(list(tmp_path.iterdir())) == (4 if to_files else 0)
    clear(old)
    assert image_names() == names_of("Floor")


def test_names_are_swapped():
    one, two = painted("One"), painted("Two", location=(9, 0, 0))
    bake(one, two, **TEXTURE)
    one.name, two.name, one.name = "Three", "One", "Two"
    bake(one, **TEXTURE)
    assert image_names() == names_of("One", "Two")
    assert image_of(one).name == "Two Bent Cone"
    assert image_of(two).name == "One Bent Cone"


def test_every_object_that_had_the_name_keeps_its_file(tmp_path):
    objects = []
    for name in ("First", "Second", "Third"):
        objects.append(painted("Floor", location=(9 * len(objects), 0, 0)))
        bake(objects[-1], **TEXTURE, output_directory=str(tmp_path))
        objects[-1].name = name
    assert len({Path(bpy.path.abspath(image_of(obj).filepath)) for obj in objects}) == 3


def test_the_artist_s_image_of_that_name_stays():
    obj = plate()
    bpy.data.images.new("Plate Bent Cone", 4, 4)
    (report,) = reports(obj, **TEXTURE)
    assert "'Plate Bent Cone'" in report.error
    assert image_names() == ["Plate Bent Cone"]


@pytest.mark.parametrize("rebaked", ["the original", "the duplicate", "both", "neither"])
@pytest.mark.parametrize("with_material", [True, False])
def test_a_duplicate_and_its_original(rebaked, with_material):
    """Each keeps what it shows until it is baked itself; in whatever order they are cleared, nothing is left."""
    for order in itertools.permutations(("Plate", "Duplicate")):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        original = painted() if with_material else plate()
        bake(original, **TEXTURE)
        shown = image_of(original)
        copy = duplicate(original)
        baked = {"the original": [original], "the duplicate": [copy], "both": [original, copy], "neither": []}[rebaked]
        if baked:
            bake(*baked, **TEXTURE)
        for obj in (original, copy):
            if obj in baked:
                assert image_of(obj).name == f"{obj.name} Bent Cone"
            else:
                assert image_of(obj) == shown
        for name in order:
            assert None not in {image_of(obj) for obj in (original, copy) if "multibounce_ao" in obj}
            clear(bpy.data.objects[name])
        assert nothing_is_left()


def test_a_deleted_duplicate_keeps_nothing():
    original = painted()
    bake(original, **TEXTURE)
    copy = duplicate(original)
    bake(copy, **TEXTURE)
    bpy.data.objects.remove(copy)
    clear(original)
    assert group(original.active_material) is None


def test_a_duplicate_baked_to_vertices_leaves_the_original_its_image():
    original = painted()
    bake(original, **TEXTURE)
    shown = image_of(original)
    copy = duplicate(original)
    bake(copy, target="VERTEX")
    assert image_of(original) == shown
    assert source(group(copy.active_material).inputs["AO"]).node.attribute_name == BENT_CONE


def test_an_unbaked_user_of_a_baked_mesh_is_cleared():
    one = painted()
    two = second_user(one)
    bake(one)
    before = f0(one)
    clear(two)
    np.testing.assert_array_equal(f0(one), before)
    assert source(group(one.active_material).inputs["Tail"]).node.attribute_name == MULTIBOUNCE_AO
    clear(one)
    assert MULTIBOUNCE_AO not in one.data.attributes


@pytest.mark.parametrize("settings", [{"target": "VERTEX"}, TEXTURE], ids=["vertices", "texture"])
@pytest.mark.parametrize("first", [0, 1])
def test_users_of_one_mesh_are_cleared_one_by_one(settings, first):
    """A linked duplicate, Alt+D, has the record of its original."""
    one = plate()
    bake(one, **settings)
    two = linked(one.copy(), x=9)
    before = [attribute.name for attribute in one.data.attributes]
    order = (one, two) if first == 0 else (two, one)
    clear(order[0])
    assert [attribute.name for attribute in one.data.attributes] == before
    assert group(order[1].active_material) is not None
    clear(order[1])
    assert BENT_CONE not in one.data.attributes
    assert nothing_is_left()
    assert not bpy.data.materials
    assert not one.material_slots


def test_an_attribute_of_that_name_without_a_bake_is_the_artist_s():
    obj = plate()
    obj.data.color_attributes.new(BENT_CONE, "FLOAT_COLOR", "POINT")
    clear(obj)
    assert BENT_CONE in obj.data.attributes
