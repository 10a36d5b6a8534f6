# SPDX-License-Identifier: GPL-3.0-or-later
"""Selections as artists make them: several objects, shared meshes, things that are no meshes, scales that are not 1."""

import math

import bpy
import numpy as np
import pytest

from .bakes import alpha, attribute, bake, f0, pixels, reports, select
from .meshes import add, add_mesh, box, plate, positions


def test_only_meshes_of_a_mixed_selection_are_baked():
    floor, cube = plate(), box(low=(2, 2, 2), high=(3, 3, 3))
    others = [
        add("Lamp", bpy.data.lights.new("Lamp", "POINT")),
        add("Camera", bpy.data.cameras.new("Camera")),
        add("Empty", None),
        add("Curve", bpy.data.curves.new("Curve", "CURVE")),
    ]
    bake(others[0], floor, cube, *others[1:])
    assert [obj.name for obj in bpy.data.objects if "multibounce_ao" in obj] == ["Box", "Plate"]
    assert len(attribute(floor)) == 25
    assert len(attribute(cube)) == 24
    assert {obj.name for obj in bpy.context.selected_objects} == {"Lamp", "Camera", "Empty", "Curve", "Plate", "Box"}
    assert bpy.context.view_layer.objects.active == others[0]


def test_shared_mesh_to_vertices():
    """A mesh has one set of attributes: the first object's, and the report of the other says so."""
    first, second = plate(), plate("Second", location=(0, 0, -10))
    second.data = first.data
    box("Closet", low=(-3, -3, -11), high=(3, 3, -9), inward=True)
    one, two = reports(first, second)
    assert (one.error, one.warnings, one.points) == (None, [], 25)
    assert two.error is None
    assert any("'Plate'" in warning and "mesh" in warning for warning in two.warnings)
    np.testing.assert_array_equal(f0(first), 1)  # not the second's, which is in the closet
    assert (two.points, two.rays, two.f0, two.outputs) == (one.points, 0, one.f0, one.outputs)
    assert second["multibounce_ao"]["points"] == 25


def test_shared_mesh_to_textures():
    """Each object has its own images, so each is baked."""
    first, second = plate(), plate("Second", location=(0, 0, -10))
    second.data = first.data
    box("Closet", low=(-3, -3, -11), high=(3, 3, -9), inward=True)
    bake(first, second, target="TEXTURE", resolution=8)
    assert (pixels(bpy.data.images["Plate Multibounce AO"])[..., 0] == 1).all()
    assert (pixels(bpy.data.images["Second Multibounce AO"])[..., 0] == 0).all()


@pytest.mark.parametrize("scale", [(1, 1, 5), (1, 5, -1), (-2, 1, 1)])
def test_slope_of_a_stretched_object(scale):
    """Over an infinite floor F0 = (1 + cos t)/2 and alpha = 1 - t/pi, with t the angle of the normal in the world."""
    slope = add_mesh("Slope", [(0, 0, 0), (2, 0, 0), (2, 1, 1), (0, 1, 1)], [(0, 1, 2, 3)])
    slope.scale = scale
    slope.location.z = 10
    bake(slope, samples=1024, use_ground_plane=True, ignore_backfaces=True)
    world = positions(slope) * scale
    normal = np.cross(world[1] - world[0], world[2] - world[0])
    # A mirroring scale turns the winding over; the front stays with the mesh.
    cosine = np.sign(np.prod(scale)) * normal[2] / np.linalg.norm(normal)
    np.testing.assert_allclose(f0(slope), (1 + cosine) / 2, atol=0.004)
    np.testing.assert_allclose(alpha(slope), 1 - math.acos(cosine) / math.pi, atol=0.006)


def test_parented_object_is_where_it_is_seen():
    floor = plate()
    parent = add("Parent", None, (0, 0, -10))
    parent.rotation_euler = (0.3, 0.4, 0.5)
    floor.parent = parent
    box("Closet", low=(-3, -3, -13), high=(3, 3, -7), inward=True)
    bake(floor)
    np.testing.assert_array_equal(f0(floor), 0)


def test_active_object_need_not_be_selected_or_there():
    floor = plate()
    bake(floor)
    select(floor)
    bpy.context.view_layer.objects.active = None
    assert bpy.ops.multibounce_ao.bake() == {"FINISHED"}


def test_stays_in_the_frame_it_is_baked_at():
    floor = plate()
    box("Closet", low=(-3, -3, -11), high=(3, 3, -9), inward=True)
    floor.keyframe_insert("location", frame=1)
    floor.location.z = -10
    floor.keyframe_insert("location", frame=20)
    bpy.context.scene.frame_set(20)
    bake(floor)
    np.testing.assert_array_equal(f0(floor), 0)
    bpy.context.scene.frame_set(1)
    bake(floor)
    np.testing.assert_array_equal(f0(floor), 1)
