# SPDX-License-Identifier: GPL-3.0-or-later
"""What the channels of a vertex bake mean: closed forms, at 1024 samples."""

import math

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, alpha, attribute, bake, f0, rms
from .closed_forms import faces_towards, form_factor, solid_angle
from .meshes import add_mesh, apply_modifiers, box, corner_vertices, plate, positions, read, suzanne

A, B = 27.576937094210385, 3.3364392003423804


def test_floor_under_a_floating_box():
    floor = plate(half=2.0, steps=12)
    occluder = box(low=(-0.5, -0.5, 0.25), high=(0.5, 0.5, 1.25))
    bake(floor, samples=1024)

    faces = [tuple(face.vertices) for face in occluder.data.polygons]
    expected = []
    for point in positions(floor):
        seen = faces_towards(point, positions(occluder), faces)
        expected.append(
            (
                1 - sum(form_factor(point, (0, 0, 1), face) for face in seen),
                1 - sum(solid_angle(point, face) for face in seen) / (2 * math.pi),
            )
        )
    expected = np.array(expected)
    assert np.ptp(expected[:, 0]) > 0.5  # from open to nearly closed
    assert rms(f0(floor) - expected[:, 0]) < 0.004
    assert rms(alpha(floor) - expected[:, 1]) < 0.006


def test_box_on_the_ground():
    """On an infinite floor the sides see half of the sky, the top all of it, the underside nothing, at every corner."""
    obj = box()
    bake(obj, samples=1024, use_ground_plane=True)
    normal_z = read(obj.data.corner_normals, "vector", 3)[:, 2]
    np.testing.assert_allclose(f0(obj), (1 + normal_z) / 2, atol=0.004)
    np.testing.assert_allclose(alpha(obj), (1 + normal_z) / 2, atol=0.006)


def test_inside_of_a_closed_box_is_black():
    obj = box(inward=True)
    bake(obj)
    np.testing.assert_array_equal(f0(obj), 0)
    np.testing.assert_array_equal(attribute(obj)[:, :3], 0)
    np.testing.assert_array_equal(attribute(obj, BENT_CONE), 0)


def test_no_light_leaks_between_loose_triangles():
    """A ball from inside, of which no two faces share a vertex, at an angle to all axes."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, rotation=(0.3, 0.5, 0.7))
    obj = bpy.context.active_object
    obj.data.flip_normals()
    obj.modifiers.new("Loosen", "EDGE_SPLIT").split_angle = 0
    apply_modifiers(obj)
    assert len(obj.data.vertices) == 3 * len(obj.data.polygons)
    obj.data.shade_smooth()
    bake(obj, samples=1024)
    np.testing.assert_array_equal(f0(obj), 0)


def test_flat_corner():
    """Where a floor meets an endless wall, at the very edge they share, each sees half of the light and of the sky."""
    h = 1e4
    vertices = [(x, y, z) for x, z in ((h, 0), (0, 0), (0, h)) for y in (-h, 0, h)]
    obj = add_mesh("Corner", vertices, [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)], smooth=False)
    bake(obj, samples=1024)
    corners = corner_vertices(obj.data) == 4  # in the middle of the edge: two of the floor, two of the wall
    assert corners.sum() == 4
    np.testing.assert_allclose(f0(obj)[corners], 0.5, atol=0.004)
    np.testing.assert_allclose(alpha(obj)[corners], 0.5, atol=0.006)


@pytest.mark.parametrize("rotation", [(0, 0, 0), (2.0, -0.7, 1.1)])
@pytest.mark.parametrize("scale", [(1, 1, 1), (1, 2, 3)])
def test_bent_cone_of_an_open_plate(rotation, scale):
    """The mean direction of a whole hemisphere is half its axis: in object space that is z, however it turns."""
    obj = plate()
    obj.rotation_euler, obj.scale = rotation, scale
    bake(obj, samples=1024)
    np.testing.assert_allclose(attribute(obj, BENT_CONE), np.tile((0, 0, 0.5, 1), (25, 1)), atol=0.006)
    np.testing.assert_array_equal(alpha(obj), 1)
    np.testing.assert_array_equal(attribute(obj)[:, :3], np.tile((1, 0, 0), (25, 1)))


@pytest.mark.parametrize("rotation", [(0, 0, 0), (0.4, 2.0, -1.0)])
def test_bent_cone_before_a_wall(rotation):
    """The wall hides the quarter sphere x < 0: the mean of what is left is (1/2, 0, 1/2), in object space."""
    h = 1e4
    vertices = [(0, y, z) for y in (-h, h) for z in (-h, h)] + [(1, 0, 0), (2, 0, 0), (1.5, 1, 0)]
    obj = add_mesh("Corner", vertices, [(0, 2, 3, 1), (4, 5, 6)])
    obj.rotation_euler = rotation
    bake(obj, samples=1024)
    floor = attribute(obj, BENT_CONE)[4:]
    np.testing.assert_allclose(floor, np.tile((0.5, 0, 0.5, 0.5), (3, 1)), atol=0.006)
    np.testing.assert_allclose(f0(obj)[4:], 0.5, atol=0.004)


def test_bounce_channels_are_the_published_fit():
    """F1 and tau of alpha by equations (11) and (9), with F0 <= 1 and F1 <= 1 - F0; F2 = T F1; energy limits both."""
    obj = suzanne()
    bake(obj, samples=256, bounces="FITTED")
    a = alpha(obj)
    fit_f0 = np.minimum(a * (1 + (1 - a) ** 0.75 / 2), 1)
    fit_f1 = np.minimum(A * a * (1 - a) ** 1.5 * np.exp(-B * a**0.25), 1 - fit_f0)
    left = 1 - fit_f0
    # Where F1 takes all that is left, tau is 0; so it stays where nothing is left.
    tau = np.divide(left - fit_f1, left, out=np.zeros_like(left), where=left > 0)

    direct, first, second, tail = attribute(obj, MULTIBOUNCE_AO).T
    assert a.min() < 0.5 < a.max()
    # alpha is stored as float32, and tau near an open sky is a ratio of two small numbers.
    np.testing.assert_allclose(tail, tau, atol=1e-4)
    np.testing.assert_allclose(first, np.minimum(fit_f1, 1 - direct), atol=1e-5)
    np.testing.assert_allclose(second, np.minimum(tail * first, 1 - direct - first), atol=1e-5)
    assert (direct + first < 1).any()  # not all of it is the limit
    assert (direct + first + second).max() <= 1 + 1e-6
    assert min(direct.min(), first.min(), second.min(), tail.min()) >= 0


def test_face_corners_of_one_smooth_vertex_share_their_value():
    obj = suzanne()
    obj.data.edges[100].use_edge_sharp = True
    bake(obj)
    corner, sharp = corner_vertices(obj.data), set(obj.data.edges[100].vertices)
    values = attribute(obj)
    for vertex in range(0, len(obj.data.vertices), 7):
        if vertex not in sharp:
            assert len(np.unique(values[corner == vertex], axis=0)) == 1
