# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group in the materials of baked objects."""

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, alpha, attribute, bake, reports, select
from .materials import bsdf, group, material, source, textured_material
from .meshes import box, plate

A, B = 27.576937094210385, 3.3364392003423804


def published_factor(a, rho):
    """E/E0 = F0 + rho F1 / (1 - rho tau), equation (12), where F0 < 1."""
    f0 = a * (1 + (1 - a) ** 0.75 / 2)
    f1 = A * a * (1 - a) ** 1.5 * np.exp(-B * a**0.25)
    assert (f0 < 0.999).all()
    return f0 + rho * f1 / (1 - rho * (1 - f1 / (1 - f0)))


def under_a_box(**where):
    """A floor of which each point has another alpha, none of them near 1."""
    box(low=(-1.5, -1.5, 0.5), high=(1.5, 1.5, 2))
    return plate("Floor", **where)


def diffuse_colour(obj):
    """(corners, 3): what the material shows of its base colour, by Cycles."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    colours = obj.data.color_attributes.new("Cycles", "FLOAT_COLOR", "CORNER")
    obj.data.color_attributes.active_color = colours
    for slot in obj.material_slots:
        bsdf(slot.material).inputs["Specular IOR Level"].default_value = 0
    select(obj)
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"COLOR"}, target="VERTEX_COLORS")
    return attribute(obj, "Cycles")[:, :3]


def corner_values(obj, values):
    return values[[loop.vertex_index for loop in obj.data.loops]]


def test_rendered_colour_is_that_of_all_bounces():
    floor = under_a_box()
    floor.data.materials.append(material(colour=(0.8, 0.4, 0.2, 1)))
    bake(floor, bounces="FITTED")
    a = corner_values(floor, alpha(floor))[:, None]
    assert np.ptp(a) > 0.1
    rho = np.array([0.8, 0.4, 0.2])
    np.testing.assert_allclose(diffuse_colour(floor), rho * published_factor(a, rho), atol=2e-3)


def baked_factor(channels, rho):
    """E/E0 = F0 + rho F1 + rho^2 F2 / (1 - rho T), whatever the guards of T: rho is below 0.9."""
    f0, f1, f2, tail = channels.T[:, :, None]
    return f0 + rho * f1 + rho**2 * f2 / (1 - rho * tail)


def test_rendered_colour_of_baked_bounces():
    floor = under_a_box()
    floor.data.materials.append(material(colour=(0.8, 0.4, 0.2, 1)))
    bake(floor, bounces="BAKED", samples=256)
    channels = corner_values(floor, attribute(floor))
    assert np.ptp(channels, axis=0).min() > 0.02
    rho = np.array([0.8, 0.4, 0.2])
    np.testing.assert_allclose(diffuse_colour(floor), rho * baked_factor(channels, rho), atol=2e-3)


def test_rendered_colour_from_the_texture():
    """The image is read where the mesh's UV map says, also if another map is active."""
    floor = under_a_box()
    other = floor.data.uv_layers.new(name="Other")
    other.uv.foreach_set("vector", np.zeros(2 * len(floor.data.loops), np.float32))
    other.active = other.active_render = True
    floor.data.materials.append(material(colour=(0.8, 0.4, 0.2, 1)))
    bake(floor, samples=1024, bounces="FITTED")
    a = corner_values(floor, alpha(floor))[:, None]
    bake(floor, samples=1024, target="TEXTURE", uv_map="UVMap", resolution=128)
    rho = np.array([0.8, 0.4, 0.2])
    np.testing.assert_allclose(diffuse_colour(floor), rho * published_factor(a, rho), atol=0.02)


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
def test_other_objects_of_the_same_material_keep_their_look(bounces):
    floor, other = under_a_box(), plate("Other", location=(50, 0, 0))
    for obj in (floor, other):
        obj.data.materials.append(material() if obj == floor else floor.data.materials[0])
    before = diffuse_colour(other)
    np.testing.assert_allclose(before, [(0.8, 0.4, 0.2)] * len(before), atol=1e-5)
    bake(floor, bounces=bounces)
    np.testing.assert_allclose(diffuse_colour(other), before, atol=1e-5)
    bake(floor, target="TEXTURE", resolution=8)
    np.testing.assert_allclose(diffuse_colour(other), before, atol=1e-5)


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_wiring(target, bounces):
    floor = plate()
    floor.data.materials.append(textured_material())
    shader = bsdf(floor.data.materials[0])
    texture = source(shader.inputs["Base Color"])
    bake(floor, target=target, bounces=bounces, resolution=8)

    node = group(floor.active_material)
    assert node.node_tree.name == ("Multibounce AO Fit" if bounces == "FITTED" else "Multibounce AO")
    assert source(shader.inputs["Base Color"]) == node.outputs["Color"]
    assert source(node.inputs["Base Color"]) == texture
    assert tuple(node.inputs["Irradiance"].default_value) == (1, 1, 1, 1)
    channel, socket = (BENT_CONE, "AO") if bounces == "FITTED" else (MULTIBOUNCE_AO, "Tail")
    reader = source(node.inputs[socket])
    assert reader.name == "Alpha"
    if target == "VERTEX":
        assert reader.node.attribute_name == channel
        assert reader.node.attribute_type == "GEOMETRY"
    else:
        assert reader.node.image == bpy.data.images[f"Plate {channel}"]
        assert source(reader.node.inputs["Vector"]).node.uv_map == "UVMap"
        if bounces == "BAKED":
            assert source(node.inputs["Bounces"]) == reader.node.outputs["Color"]


def test_plain_colour_moves_into_the_group():
    floor = plate()
    floor.data.materials.append(material(colour=(0.1, 0.2, 0.3, 1)))
    bake(floor)
    np.testing.assert_allclose(group(floor.active_material).inputs["Base Color"].default_value, (0.1, 0.2, 0.3, 1))


def test_every_material_and_every_shader_of_it():
    floor = plate()
    double = material("Double")
    second = double.node_tree.nodes.new("ShaderNodeBsdfPrincipled")
    floor.data.materials.append(material("Single"))
    floor.data.materials.append(None)
    floor.data.materials.append(double)
    bake(floor)
    assert source(bsdf(floor.data.materials[0]).inputs["Base Color"]).node.node_tree.name == "Multibounce AO"
    for shader in (bsdf(double), second):
        assert source(shader.inputs["Base Color"]).node.node_tree.name == "Multibounce AO"
    assert floor.data.materials[1] is None


def test_object_without_a_material_gets_one():
    floor = plate()
    bake(floor)
    assert len(floor.material_slots) == 1
    assert source(bsdf(floor.active_material).inputs["Base Color"]).node.node_tree.name == "Multibounce AO"


def test_nodes_stay_out_where_not_wanted():
    floor = plate()
    bake(floor, use_material_nodes=False)
    assert not floor.material_slots
    assert not bpy.data.node_groups


@pytest.mark.parametrize(
    ("bounces", "trees", "nodes"), [("FITTED", "Multibounce AO Fit", 5), ("BAKED", "Multibounce AO", 7)]
)
def test_nothing_is_duplicated_by_baking_again(bounces, trees, nodes):
    floor, second = plate(), plate("Second", location=(9, 0, 0))
    for obj in (floor, second):
        obj.data.materials.append(textured_material() if obj == floor else floor.data.materials[0])
    for target in ("VERTEX", "VERTEX", "TEXTURE", "TEXTURE", "VERTEX"):
        bake(floor, second, target=target, bounces=bounces, resolution=8)
    for names in (bpy.data.node_groups, bpy.data.images, bpy.data.materials):
        assert not [block.name for block in names if ".0" in block.name]
    assert [tree.name for tree in bpy.data.node_groups] == [trees]
    for obj in (floor, second):
        # Texture, BSDF and output are the artist's; the group, one attribute, and what shows meshes without it as
        # open are ours.
        assert len(obj.active_material.node_tree.nodes) == nodes


def test_material_without_a_shader_of_ours_is_told():
    floor = plate()
    glow = material("Glow")
    tree = glow.node_tree
    tree.nodes.remove(bsdf(glow))
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(emission.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
    floor.data.materials.append(glow)
    (report,) = reports(floor)
    assert any("'Glow'" in warning and "Principled" in warning for warning in report.warnings)
    assert report.error is None
    assert {node.type for node in tree.nodes} == {"EMISSION", "OUTPUT_MATERIAL"}


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="from Blender 5.0 on every material has nodes")
def test_material_whose_nodes_are_off():
    floor = plate()
    old = bpy.data.materials.new("Old")
    old.diffuse_color = (0.1, 0.2, 0.3, 1)
    floor.data.materials.append(old)
    bake(floor)
    assert old.use_nodes
    np.testing.assert_allclose(group(old).inputs["Base Color"].default_value, (0.1, 0.2, 0.3, 1))
    bpy.ops.multibounce_ao.clear()
    assert not old.use_nodes
    assert group(old) is None


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="from Blender 5.0 on every material has nodes")
def test_material_whose_nodes_are_off_and_have_no_shader():
    floor = plate()
    old = material("Old")
    old.node_tree.nodes.remove(bsdf(old))
    old.use_nodes = False
    floor.data.materials.append(old)
    (report,) = reports(floor)
    assert any("'Old'" in warning and "Principled" in warning for warning in report.warnings)
    assert not old.use_nodes
    assert [node.bl_idname for node in old.node_tree.nodes] == ["ShaderNodeOutputMaterial"]


def test_add_nodes():
    floor = plate()
    floor.data.materials.append(textured_material())
    select(floor)
    assert bpy.ops.multibounce_ao.add_nodes() == {"FINISHED"}
    node = group(floor.active_material)
    assert source(bsdf(floor.active_material).inputs["Base Color"]) == node.outputs["Color"]
    assert not node.inputs["Tail"].is_linked  # no bake yet

    bake(floor, use_material_nodes=False)
    assert not node.inputs["Tail"].is_linked
    assert bpy.ops.multibounce_ao.add_nodes() == {"FINISHED"}
    assert source(group(floor.active_material).inputs["Tail"]).node.attribute_name == MULTIBOUNCE_AO


def test_add_nodes_leaves_the_bake_of_another_object_in():
    """Of two objects of one material only the other is baked."""
    floor, other = plate(), plate("Other", location=(9, 0, 0))
    for obj in (floor, other):
        obj.data.materials.append(material() if obj == floor else floor.data.materials[0])
    bake(floor)
    select(other)
    bpy.ops.multibounce_ao.add_nodes()
    assert other.active_material == floor.active_material
    assert source(group(floor.active_material).inputs["Tail"]).node.attribute_name == MULTIBOUNCE_AO


def test_add_nodes_copies_a_shared_material_before_an_image_goes_in():
    floor, other = plate(), plate("Other", location=(9, 0, 0))
    shared = material()
    for obj in (floor, other):
        obj.data.materials.append(shared)
    bake(floor, target="TEXTURE", resolution=8, use_material_nodes=False)
    bpy.ops.multibounce_ao.add_nodes()
    assert other.active_material == shared
    assert group(shared) is None
    reader = source(group(floor.active_material).inputs["Bounces"]).node
    assert reader.image == bpy.data.images["Plate Multibounce AO"]


def test_add_nodes_needs_a_material_with_a_shader():
    floor = plate()
    select(floor)
    assert not bpy.ops.multibounce_ao.add_nodes.poll()
    floor.data.materials.append(material("Empty"))
    floor.active_material.node_tree.nodes.clear()
    with pytest.raises(RuntimeError, match=r"'Empty'.*Principled BSDF"):
        bpy.ops.multibounce_ao.add_nodes()
    assert not floor.active_material.node_tree.nodes
