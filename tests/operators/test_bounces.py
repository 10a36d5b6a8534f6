# SPDX-License-Identifier: GPL-3.0-or-later
"""Measured bounces through the whole bake, where they are known."""

import bpy
import numpy as np
import pytest

from ..core import path_tracing
from .bakes import MULTIBOUNCE_AO, attribute, bake, clear, generator, pixels, reports, rms, select
from .materials import bsdf, group, material, source, textured_material
from .meshes import add_mesh, box, plate, positions

RADIOSITY = "Multibounce Radiosity"


def pit(open_fraction):
    """A smooth icosphere seen from within, the top cut off, and the part of its area that is missing."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5)
    ball = bpy.context.active_object
    vertices = positions(ball)
    faces = np.array([polygon.vertices[:] for polygon in ball.data.polygons])
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    kept = vertices[faces].mean(axis=1)[:, 2] < 1.0 - 2.0 * open_fraction
    bpy.data.objects.remove(ball)
    used, index = np.unique(faces[kept][:, ::-1], return_inverse=True)
    obj = add_mesh("Pit", vertices[used], index.reshape(-1, 3))
    return obj, 1.0 - area[kept].sum() / area.sum()


def assert_bounces_of_the_pit(channels, f, where):
    """F_n = f (1 - f)^n at every point."""
    for order, values in enumerate(channels.T[:3]):
        error = values - f * (1.0 - f) ** order
        print(f"pit of f = {f:.3f}, {where}: F{order} rms {rms(error):.4f}, bias {error.mean():+.5f}")
        assert rms(error) < 0.02 and abs(error.mean()) < 0.006


@pytest.mark.parametrize("open_fraction", [0.5, 0.25])
def test_spherical_pit(open_fraction):
    obj, f = pit(open_fraction)
    bake(obj, samples=512)
    assert_bounces_of_the_pit(attribute(obj), f, "vertices")
    select(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project()
    bpy.ops.object.mode_set(mode="OBJECT")
    bake(obj, samples=512, target="TEXTURE", resolution=128, margin=0)
    image = pixels(bpy.data.images[f"Pit {MULTIBOUNCE_AO}"]).reshape(-1, 4).astype(float)
    covered = image[:, 0] > 0.0
    assert covered.sum() > 5000
    assert_bounces_of_the_pit(image[covered], f, "texture")


def open_room():
    """A box of six quads less one, the side towards +x, seen from within; each quad has a strip of the UV tile.

    Also the corners (5, 4, 3) of the quads, and of their strips (5, 4, 2).
    """
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    faces = np.array([(0, 1, 3, 2), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])[:, ::-1]
    obj = add_mesh("Room", corners, faces, smooth=False)
    low = np.arange(5)[:, None] / 5 + 0.01
    strips = np.stack([np.column_stack((low + 0.18 * x, np.full((5, 1), 0.02 + 0.96 * y)))
                       for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], axis=1)  # fmt: skip
    obj.data.uv_layers.new().uv.foreach_set("vector", strips.astype(np.float32).ravel())
    return obj, corners[faces], strips


def test_room_of_few_quads_in_a_texture():
    """F1 of texels against the first bounce of paths."""
    obj, quads, strips = open_room()
    size = 120
    bake(obj, samples=512, target="TEXTURE", resolution=size, margin=0)
    image = pixels(bpy.data.images[f"Room {MULTIBOUNCE_AO}"]).astype(float)
    mesh = quads.reshape(-1, 3), np.concatenate([np.arange(20).reshape(5, 4)[:, list(each)] for each in
                                                 ((0, 1, 2), (0, 2, 3))])  # fmt: skip
    random, points, normals, values = np.random.default_rng(0), [], [], []
    for (a, b, _, d), strip in zip(quads, strips, strict=True):
        # Texels well within the strip, whose area means are their centres' values.
        first, last = np.ceil(strip[0] * size + 0.5).astype(int), np.floor(strip[2] * size - 1.5).astype(int)
        column, row = random.integers(first, last + 1, (60, 2)).T
        x, y = ((np.stack((column, row), axis=1) + 0.5) / size - strip[0]).T / (strip[2] - strip[0])[:, None]
        points.append(a + x[:, None] * (b - a) + y[:, None] * (d - a))
        normals.append(np.tile(np.cross(b - a, d - a) / 4.0, (60, 1)))
        values.append(image[row, column, 1])
    points, normals, values = (np.concatenate(each) for each in (points, normals, values))
    truth = path_tracing.bounces(mesh, points, normals, 4096, extent=2.0, last=1)
    print(f"room of five quads: F1 rms {path_tracing.rms(values, truth[:, 1]):.4f}, mean {values.mean():.3f}")
    assert values.mean() > 0.1
    assert path_tracing.rms(values, truth[:, 1]) < 0.01


def test_light_comes_off_other_objects_and_the_ground():
    """A plate that faces down over the ground plane, and over another object's white floor."""
    roof = plate("Roof", steps=1)
    roof.data.flip_normals()
    roof.location.z = 0.5
    bake(roof, samples=256, occluders="SELF")
    assert (attribute(roof)[:, 1] == 0.0).all()
    floor = plate("Floor", half=50.0, steps=1)
    bake(roof, samples=256, occluders="VISIBLE")
    off_floor = attribute(roof)
    assert (off_floor[:, 1] > 0.3).all()
    bpy.data.objects.remove(floor)
    ground = plate("Ground", half=0.01, steps=1, location=(30, 0, 0))
    bake(roof, ground, samples=256, occluders="SELF", use_ground_plane=True)
    np.testing.assert_allclose(attribute(roof)[:, 1], off_floor[:, 1], atol=0.02)


def red_wall_beside(name="Wall"):
    wall = add_mesh(name, [(1, 2, 0), (1, -2, 0), (1, -2, 2), (1, 2, 2)], [(0, 1, 2, 3)], smooth=False)
    wall.data.materials.append(material("Red", (1.0, 0.0, 0.0, 1.0)))
    return wall


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_radiosity_takes_the_neighbours_colour(target):
    """A black floor beside a red wall: the red that it gets is the first bounce, which BAKED measures off white."""
    floor, _ = plate("Floor", steps=8), red_wall_beside()
    floor.data.materials.append(material("Black", (0.0, 0.0, 0.0, 1.0)))
    settings = {"samples": 1024, "target": target, "resolution": 32, "margin": 0}

    def channels(name):
        if target == "VERTEX":
            return attribute(floor, name)
        return pixels(bpy.data.images[f"Floor {name}"]).reshape(-1, 4).astype(float)

    bake(floor, bounces="BAKED", **settings)
    f0, f1 = channels(MULTIBOUNCE_AO)[:, 0], channels(MULTIBOUNCE_AO)[:, 1]
    (report,) = reports(floor, bounces="RADIOSITY", **settings)
    assert report.error is None and not report.warnings
    assert any(RADIOSITY.lower().replace(" ", "_") in output.lower().replace(" ", "_") for output in report.outputs)
    lit = channels(RADIOSITY)
    np.testing.assert_array_equal(lit[:, 1:3], lit[:, [3, 3]])
    np.testing.assert_allclose(lit[:, 3], f0, atol=1e-6)
    red = lit[:, 0] - lit[:, 3]
    print(f"red beside a wall, {target}: most {red.max():.3f}, rms off the first bounce {rms(red - f1):.4f}")
    assert red.max() > 0.05 and rms(red - f1) < 0.004


def test_radiosity_in_materials_and_cleared():
    floor, wall = plate("Floor"), red_wall_beside()
    other = plate("Other", location=(50, 0, 0))
    floor.data.materials.append(textured_material())
    other.data.materials.append(floor.data.materials[0])
    before = [node.name for node in floor.active_material.node_tree.nodes]
    bake(floor, bounces="RADIOSITY", samples=64)
    node = group(floor.active_material)
    assert node.node_tree.name == RADIOSITY
    assert source(bsdf(floor.active_material).inputs["Base Color"]) == node.outputs["Color"]
    mix = source(node.inputs["Radiosity"]).node
    assert mix.bl_idname == "ShaderNodeMix"
    readers = [each for each in floor.active_material.node_tree.nodes if each.bl_idname == "ShaderNodeAttribute"]
    assert [each.attribute_name for each in readers] == [RADIOSITY]
    clear(floor)
    assert [node.name for node in floor.active_material.node_tree.nodes] == before
    assert RADIOSITY not in floor.data.attributes
    assert wall.data.attributes.get(RADIOSITY) is None


def test_a_colour_that_cannot_be_read_is_told():
    floor, wall = plate("Floor"), red_wall_beside()
    tree = wall.active_material.node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs["Color"], bsdf(wall.active_material).inputs["Base Color"])
    (report,) = reports(floor, bounces="RADIOSITY", samples=16)
    assert report.error is None
    assert any("'Wall'" in warning and "'Red'" in warning for warning in report.warnings)
    (report,) = reports(floor, bounces="BAKED", samples=16)
    assert not report.warnings


def test_progress_rises_through_light_and_rays():
    box(low=(-0.5, -0.5, 0.3), high=(0.5, 0.5, 1))
    fractions = [step.fraction for step in generator(plate(steps=60), samples=256)]
    assert fractions == sorted(fractions) and fractions[0] == 0.0 and 0.9 < fractions[-1] <= 1.0
