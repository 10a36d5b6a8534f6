# SPDX-License-Identifier: GPL-3.0-or-later
"""The World's light on baked objects: what Cycles makes of the nodes, in materials that the extension wired."""

import importlib

import bpy
import numpy as np
import pytest
from enable_extension import PACKAGE

from .bakes import BENT_CONE, attribute, bake, clear, f0, rms, select
from .materials import bsdf, group, material, source
from .meshes import box, corner_vertices, plate, positions, read, suzanne
from .refusals import error_of
from .snapshot import differences, snapshot
from .worlds import directions_world, world

GROUP = "Bent Cone Irradiance"


def light_node(owner):
    """The node of the World's light in a material, or None."""
    nodes = [node for node in owner.node_tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    return next((node for node in nodes if node.node_tree.name == GROUP), None)


def add_world_light(obj):
    select(obj)
    assert bpy.ops.multibounce_ao.add_world_light() == {"FINISHED"}


def project():
    assert bpy.ops.multibounce_ao.project_world() == {"FINISHED"}
    stored = bpy.context.scene["multibounce_ao_world"]
    return np.transpose([list(stored[name]) for name in ("red", "green", "blue")])


def emitted(obj, output, domain="POINT"):
    """(vertices or corners, 3): what Cycles makes of an output of the World's light on ``obj``."""
    tree = obj.active_material.node_tree
    emission, end = tree.nodes.new("ShaderNodeEmission"), tree.get_output_node("CYCLES")
    shown = end.inputs["Surface"].links[0].from_socket
    tree.links.new(light_node(obj.active_material).outputs[output], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], end.inputs["Surface"])
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    colours = obj.data.color_attributes.new("Cycles", "FLOAT_COLOR", domain)
    obj.data.color_attributes.active_color = colours
    select(obj)
    bpy.ops.object.bake(type="EMIT", target="VERTEX_COLORS")
    found = attribute(obj, "Cycles")[:, :3]
    obj.data.color_attributes.remove(obj.data.color_attributes["Cycles"])
    tree.links.new(shown, end.inputs["Surface"])
    tree.nodes.remove(emission)
    return found


def turned_suzanne(**settings):
    """Turned and stretched, before a wall, baked, with the World's light."""
    obj = suzanne(levels=1)
    obj.rotation_euler, obj.scale = (0.4, 0.9, -0.6), (1.0, 1.6, 0.7)
    box("Wall", low=(1.3, -3, -3), high=(1.5, 3, 3))
    obj.data.materials.append(material())
    bake(obj, samples=256, **settings)
    add_world_light(obj)
    return obj


def test_white_world_gives_f0():
    obj = turned_suzanne()
    error = np.abs(emitted(obj, "Irradiance") - f0(obj)[:, None])
    print(f"white World: Irradiance is F0 within {error.max():.5f}")
    assert error.max() < 0.005
    sky = emitted(obj, "Sky Light")
    np.testing.assert_allclose(sky[f0(obj) > 0.01], 1.0, atol=0.01)


def test_white_world_gives_f0_where_normals_lean_behind_their_faces():
    """There Cycles turns them round, as it does where a surface is seen from behind; the bake is of the front."""
    obj = plate()
    box("Wall", low=(1.1, -2, -3), high=(1.3, 2, 3))
    obj.data.normals_split_custom_set_from_vertices([(0.3, 0.0, -1.0)] * len(obj.data.vertices))
    obj.data.materials.append(material())
    bake(obj, samples=64)
    add_world_light(obj)
    assert np.ptp(f0(obj)) > 0.1
    corners = f0(obj)[corner_vertices(obj.data)] if len(f0(obj)) == len(obj.data.vertices) else f0(obj)
    np.testing.assert_allclose(emitted(obj, "Irradiance", "CORNER"), np.repeat(corners[:, None], 3, axis=1), atol=0.005)


def test_world_axes():
    """Bent cones lie in object space, the World does not."""
    from core.bent_cone import sky_light

    obj = turned_suzanne()
    directions_world()
    coefficients = project()
    matrix = np.array(obj.matrix_world)[:3, :3]
    cone = attribute(obj, BENT_CONE)
    bent = cone[:, :3] @ matrix.T
    length = np.linalg.norm(bent, axis=1, keepdims=True)
    bent *= np.linalg.norm(cone[:, :3], axis=1, keepdims=True) / np.maximum(length, 1e-9)
    normals = read(obj.data.vertex_normals, "vector", 3) @ np.linalg.inv(matrix)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    expected = sky_light(coefficients, bent, cone[:, 3], normals).irradiance
    error = np.abs(emitted(obj, "Irradiance") - expected)
    print(f"on a turned and stretched object: within {error.max():.5f}, rms {rms(error):.1e}")
    assert error.max() < 0.005


def test_texture_and_vertices_agree():
    """On a floor before a wall."""
    directions_world()
    project()
    floor = plate("Floor", half=2, steps=32)
    box("Wall", low=(2.1, -2, 0), high=(2.3, 2, 1.5))
    floor.data.materials.append(material())
    bake(floor, samples=1024, bounces="FITTED")
    add_world_light(floor)
    inner = np.abs(positions(floor)).max(axis=1) < 1.95
    by_vertex = emitted(floor, "Irradiance")[inner]
    bake(floor, samples=1024, target="TEXTURE", resolution=128)
    assert source(light_node(floor.active_material).inputs["Alpha"]).node.bl_idname == "ShaderNodeTexImage"
    difference = emitted(floor, "Irradiance")[inner] - by_vertex
    print(f"texture and vertices: rms {rms(difference):.4f}")
    assert np.ptp(by_vertex) > 0.3
    assert rms(difference) < 0.01


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED", "RADIOSITY"])
def test_wiring(bounces):
    floor = plate()
    floor.data.materials.append(material())
    bake(floor, bounces=bounces, samples=16)
    add_world_light(floor)
    owner = floor.active_material
    light = light_node(owner)
    last = source(bsdf(owner).inputs["Base Color"]).node
    assert source(last.inputs["Irradiance"]) == light.outputs["Relative Light"]
    assert source(light.inputs["Bent Cone"]).node.attribute_name == BENT_CONE
    before = len(owner.node_tree.nodes)
    add_world_light(floor)
    bake(floor, bounces=bounces, samples=16)
    assert len(owner.node_tree.nodes) == before
    assert source(source(bsdf(owner).inputs["Base Color"]).node.inputs["Irradiance"]).node == light_node(owner)
    assert source(light_node(owner).inputs["Alpha"]).node.attribute_name == BENT_CONE


def test_relative_light_is_over_that_of_an_open_surface():
    """So that a renderer that brings the open surface's light shows base colour * E/E0 * Sky Light, the whole chain."""
    from core.spherical_harmonics import irradiance

    directions_world()
    coefficients = project()
    floor = plate("Floor", steps=8)
    box("Wall", low=(1.1, -2, 0), high=(1.3, 2, 1.5))
    floor.data.materials.append(material(colour=(0.8, 0.4, 0.2, 1)))
    bake(floor, bounces="BAKED")
    add_world_light(floor)
    relative = emitted(floor, "Relative Light")
    opened = irradiance(coefficients, np.array((0.0, 0.0, 1.0)))
    np.testing.assert_allclose(relative * opened, emitted(floor, "Sky Light"), rtol=1e-3)
    assert np.ptp(relative) > 0.1


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_clear_takes_it_out(target):
    floor = plate()
    floor.data.materials.append(material())
    importlib.import_module(f"{PACKAGE}.shader_nodes.bent_cone").ensure()
    importlib.import_module(f"{PACKAGE}.shader_nodes.multibounce_ao").ensure()
    select(floor)
    before = snapshot()
    bake(floor, target=target, resolution=16, samples=16)
    add_world_light(floor)
    assert light_node(floor.active_material)
    clear(floor)
    changed = [line for line in differences(before, snapshot()) if "multibounce_ao" not in line]
    assert not [line for line in changed if line.startswith(("materials", "images", "objects", "meshes"))]
    assert group(floor.active_material) is None


def test_add_nodes_brings_a_projected_world():
    floor = plate()
    floor.data.materials.append(material())
    bake(floor, use_material_nodes=False, samples=4)
    assert bpy.ops.multibounce_ao.add_nodes() == {"FINISHED"}
    assert light_node(floor.active_material) is None
    world((0.5, 1.0, 2.0))
    project()
    assert bpy.ops.multibounce_ao.add_nodes() == {"FINISHED"}
    last = source(bsdf(floor.active_material).inputs["Base Color"]).node
    assert source(last.inputs["Irradiance"]).node == light_node(floor.active_material)


def test_refusals():
    select()
    assert not bpy.ops.multibounce_ao.add_world_light.poll()
    floor = plate()
    floor.data.materials.append(material())
    select(floor)
    assert "'Plate' has no bake: bake it first" in error_of(bpy.ops.multibounce_ao.add_world_light)
    bake(floor, use_material_nodes=False, samples=4)
    assert "no multibounce nodes: add them first" in error_of(bpy.ops.multibounce_ao.add_world_light)


def test_world_of_the_scene_is_shown_at_once():
    world((0.5, 1.0, 2.0))
    floor = plate()
    floor.data.materials.append(material())
    bake(floor, samples=256)
    add_world_light(floor)
    np.testing.assert_allclose(emitted(floor, "Irradiance"), 1.0, atol=1e-3)
    project()
    np.testing.assert_allclose(emitted(floor, "Irradiance"), [(0.5, 1.0, 2.0)] * 25, rtol=1e-3)
