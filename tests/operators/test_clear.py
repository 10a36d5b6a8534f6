# SPDX-License-Identifier: GPL-3.0-or-later
"""`clear` puts back exactly what was there before the bake: the whole file is compared."""

import bpy
import numpy as np
import pytest

from .bakes import MULTIBOUNCE_AO, bake, change_settings, clear, select
from .materials import bsdf, group, material, source, textured_material
from .meshes import plate
from .snapshot import differences, snapshot

VERTEX = {"target": "VERTEX"}
TEXTURE = {"target": "TEXTURE"}
BAKES = {
    "vertices": [VERTEX],
    "texture": [TEXTURE],
    "vertices twice": [VERTEX, VERTEX],
    "texture twice": [TEXTURE, TEXTURE | {"resolution": 16}],
    "vertices, then texture": [VERTEX, TEXTURE],
    "texture, then vertices": [TEXTURE, VERTEX],
    "nodes, then none": [TEXTURE, VERTEX | {"use_material_nodes": False}],
}


pytestmark = pytest.mark.usefixtures("fitted")


def no_material():
    return [plate()]


def plain():
    obj = plate()
    obj.data.materials.append(material())
    return [obj]


def textured():
    obj = plate()
    obj.data.materials.append(textured_material())
    return [obj]


def empty_slot():
    obj = plate()
    obj.data.materials.append(None)
    return [obj]


def several_slots():
    """Two materials and an empty slot between, each with faces; one material has two shaders and a muted link."""
    obj = plate()
    double = textured_material("Double")
    second = double.node_tree.nodes.new("ShaderNodeBsdfPrincipled")
    second.inputs["Base Color"].default_value = (0.3, 0.2, 0.1, 1)
    mix = double.node_tree.nodes.new("ShaderNodeMixShader")
    double.node_tree.links.new(second.outputs[0], mix.inputs[1])
    source(bsdf(double).inputs["Base Color"]).links[0].is_muted = True
    for each in (material("Single"), None, double):
        obj.data.materials.append(each)
    obj.data.polygons.foreach_set("material_index", np.arange(16) % 3)
    obj.active_material_index = 2
    return [obj]


def shared_material():
    objects = [plate(name, location=(9 * i, 0, 0)) for i, name in enumerate(("One", "Two", "Three"))]
    paint = textured_material()
    for obj in objects:
        obj.data.materials.append(paint)
    return objects[:2]  # the third is not baked


def material_of_the_object():
    obj = plate()
    obj.data.materials.append(material("Of the mesh"))
    obj.material_slots[0].link = "OBJECT"
    obj.material_slots[0].material = material("Of the object")
    return [obj]


def shared_mesh():
    one, two = plate("One"), plate("Two", location=(9, 0, 0))
    unused, two.data = two.data, one.data
    bpy.data.meshes.remove(unused)
    one.data.materials.append(material())
    return [one, two]


def shared_mesh_without_material():
    one, two = shared_mesh()
    one.data.materials.clear()
    return [one, two]


def no_shader():
    obj = plate()
    obj.data.materials.append(material())
    obj.data.materials[0].node_tree.nodes.clear()
    return [obj]


def painted():
    obj = plate()
    obj.data.color_attributes.new("First", "BYTE_COLOR", "CORNER")
    obj.data.color_attributes.new("Second", "FLOAT_COLOR", "POINT")
    obj.data.attributes.active_color_name, obj.data.attributes.default_color_name = "Second", "First"
    obj["note"] = "the artist's own property"
    return [obj]


@pytest.mark.parametrize(
    "make",
    [
        no_material,
        plain,
        textured,
        empty_slot,
        several_slots,
        shared_material,
        material_of_the_object,
        shared_mesh,
        shared_mesh_without_material,
        no_shader,
        painted,
    ],
)
@pytest.mark.parametrize("bakes", BAKES.values(), ids=BAKES)
def test_everything_is_put_back(make, bakes):
    objects = make()
    change_settings(samples=1, margin=0)
    select(*objects)
    before = snapshot()
    for settings in bakes:
        bake(*objects, samples=1, **{"resolution": 8, **settings})
    assert differences(before, snapshot())
    clear(*objects)
    forget_settings_and_unused_groups(before)
    assert differences(before, snapshot()) == []


def forget_settings_and_unused_groups(before):
    """A node group that nothing uses any more is not saved; the settings are the user's."""
    for tree, users in bpy.data.user_map(subset=list(bpy.data.node_groups)).items():
        if not users:
            bpy.data.node_groups.remove(tree)
    change_settings(target="VERTEX", resolution=1024, use_material_nodes=True)


def test_before_any_bake_there_is_nothing_to_clear():
    (obj,) = textured()
    select(obj)
    before = snapshot()
    clear(obj)
    assert differences(before, snapshot()) == []


def test_nodes_added_by_hand_are_cleared():
    (obj,) = textured()
    select(obj)
    before = snapshot()
    bpy.ops.multibounce_ao.add_nodes()
    clear(obj)
    forget_settings_and_unused_groups(before)
    assert differences(before, snapshot()) == []


def test_what_the_artist_changed_in_the_meantime_is_kept():
    (obj,) = plain()
    shader = bsdf(obj.active_material)
    bake(obj)
    group(obj.active_material).inputs["Base Color"].default_value = (1, 0, 0, 1)
    clear(obj)
    assert tuple(shader.inputs["Base Color"].default_value) == (1, 0, 0, 1)

    bake(obj)
    tree = obj.active_material.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], group(obj.active_material).inputs["Base Color"])
    clear(obj)
    assert source(shader.inputs["Base Color"]) == noise.outputs["Color"]
    assert group(obj.active_material) is None


@pytest.mark.parametrize("kind", ["NodeReroute", "ShaderNodeHueSaturation", "ShaderNodeMixRGB"])
@pytest.mark.parametrize("make", [plain, textured])
def test_nodes_that_the_artist_put_behind_the_group(kind, make):
    """Baking again finds the group through them; cleared, they get what the group got."""
    (obj,) = make()
    shader = bsdf(obj.active_material)
    before = source(shader.inputs["Base Color"])
    bake(obj)
    node = group(obj.active_material)
    tree = obj.active_material.node_tree
    between = tree.nodes.new(kind)
    socket = next(socket for socket in between.inputs if socket.type == "RGBA")
    tree.links.new(node.outputs["Color"], socket)
    tree.links.new(between.outputs[0], shader.inputs["Base Color"])
    bake(obj)
    assert group(obj.active_material) == node
    assert source(socket) == node.outputs["Color"]

    clear(obj)
    assert group(obj.active_material) is None
    assert source(socket) == before
    end = shader.inputs["Base Color"] if kind == "NodeReroute" else socket
    if make is plain:
        np.testing.assert_allclose(end.default_value, (0.8, 0.4, 0.2, 1))
        assert source(shader.inputs["Base Color"]) == (None if kind == "NodeReroute" else between.outputs[0])


def test_the_group_s_colour_may_feed_any_socket():
    (obj,) = plain()
    bake(obj)
    shader = bsdf(obj.active_material)
    obj.active_material.node_tree.links.new(group(obj.active_material).outputs["Color"], shader.inputs["Roughness"])
    clear(obj)
    assert shader.inputs["Roughness"].default_value == 0.5


def test_the_artist_may_have_removed_anything():
    (obj,) = textured()
    bake(obj, target="TEXTURE", resolution=8)
    bpy.data.images.remove(bpy.data.images["Plate Bent Cone"])
    obj.active_material.node_tree.nodes.clear()
    bake(obj, target="VERTEX")
    obj.data.attributes.remove(obj.data.attributes[MULTIBOUNCE_AO])
    obj.data.materials.clear()
    clear(obj)
    assert "multibounce_ao" not in obj


@pytest.mark.parametrize("third", [True, False], ids=["an unbaked one", "no other"])
@pytest.mark.parametrize("settings", [VERTEX, TEXTURE], ids=["vertices", "texture"])
def test_objects_that_stay_baked_stay_so(settings, third):
    """One of two objects of one material is cleared: the other keeps its bake, the one does not show the other's."""
    one, two = shared_material()
    shared = one.active_material
    if not third:
        bpy.data.objects.remove(bpy.data.objects["Three"])
    bake(one, two, resolution=8, **settings)
    clear(one)
    assert "multibounce_ao" not in one
    assert "multibounce_ao" in two
    reader = source(group(two.active_material).inputs["AO"]).node
    if settings is TEXTURE:
        assert reader.image == bpy.data.images["Two Bent Cone"]
        assert group(one.active_material) is None
        assert one.active_material == shared
    else:
        assert reader.attribute_name in two.data.attributes
        assert reader.attribute_name not in one.data.attributes


def test_files_stay(tmp_path):
    obj = plate()
    bake(obj, target="TEXTURE", resolution=8, output_directory=str(tmp_path))
    files = sorted(tmp_path.iterdir())
    assert len(files) == 2
    clear(obj)
    assert sorted(tmp_path.iterdir()) == files
    assert not bpy.data.images


def test_a_library_override_with_a_mesh_of_its_own(scene, tmp_path):
    """Blender's operator removes no slots of library overrides."""
    plate("Prop")
    path = tmp_path / "library.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(path), link=True) as (_, here):
        here.objects = ["Prop"]
    bpy.context.scene.collection.objects.link(here.objects[0])
    obj = here.objects[0].override_create(remap_local_usages=True)
    obj.data = obj.data.copy()
    bake(obj, samples=4)
    assert obj.data.materials
    clear(obj)
    assert not obj.data.materials and not bpy.data.materials
    assert "multibounce_ao" not in obj and not obj.data.color_attributes
