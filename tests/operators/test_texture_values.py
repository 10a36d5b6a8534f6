# SPDX-License-Identifier: GPL-3.0-or-later
"""What the texels of a texture bake hold: which UV map, which texels, which points of the surface."""

import math

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, alpha, bake, f0, pixels, reports, rms
from .meshes import add_mesh, add_uv_map, box, plate, positions


def texture(obj, channel=MULTIBOUNCE_AO):
    return pixels(bpy.data.images[f"{obj.name} {channel}"])


def bake_texture(*objects, **settings):
    bake(*objects, **{"target": "TEXTURE", "resolution": 16, "margin": 0, **settings})


def plate_at(low, high, name="Plate"):
    """A plate whose UV map fills the rectangle from ``low`` to ``high``."""
    obj = plate(name)
    obj.data.uv_layers.remove(obj.data.uv_layers[0])
    add_uv_map(obj.data, unit(obj) * np.subtract(high, low) + low)
    return obj


def unit(obj):
    """The vertices in [0, 1]^2."""
    return (positions(obj)[:, :2] + 1) / 2


def test_each_texel_shows_its_part_of_the_surface():
    """A quarter of the floor, x > 0 and y < 0, stands in a closed box: the same quarter of the image is black."""
    obj = plate("Floor")
    box(low=(0, -2, -1), high=(2, 0, 1), inward=True)
    bake_texture(obj, ignore_backfaces=True, samples=256)
    dark = texture(obj)[..., 0] == 0
    expected = np.zeros((16, 16), bool)
    expected[:8, 8:] = True  # rows from the bottom
    np.testing.assert_array_equal(dark, expected)


def test_agrees_with_the_vertex_bake():
    """Each vertex in the centre of a texel, which is small enough for its mean to be the value there."""
    steps, fine = 15, 5
    floor = plate("Floor", half=2.0, steps=steps)
    floor.data.uv_layers.remove(floor.data.uv_layers[0])
    column_row = np.stack(np.meshgrid(np.arange(steps + 1), np.arange(steps + 1)), axis=-1).reshape(-1, 2)
    add_uv_map(floor.data, (column_row + 0.5) / (steps + 1))
    box(low=(-0.5, -0.5, 0.25), high=(0.5, 0.5, 1.25))
    bake(floor, samples=1024)
    bake_texture(floor, samples=1024, resolution=fine * (steps + 1))
    at_vertices = 2 * (slice(fine // 2, None, fine),)
    assert np.ptp(f0(floor)) > 0.4
    # Two bakes, each within .004 of the truth for F0 and .006 for alpha.
    assert rms(texture(floor)[at_vertices][..., 0].ravel() - f0(floor)) < 0.006
    assert rms(texture(floor, BENT_CONE)[at_vertices][..., 3].ravel() - alpha(floor)) < 0.009


def test_smooth_normals_are_interpolated():
    """A strip around a corner of 90 degrees, over an infinite floor: the normal n turns from up to the side, and sees
    what lies above the horizon, (1 + n_z)/2; its own flat faces do not hide any of it."""
    strip = add_mesh(
        "Strip", [(0, 0, 5), (0, 1, 5), (1, 0, 5), (1, 1, 5), (1, 0, 4), (1, 1, 4)], [(0, 2, 3, 1), (2, 4, 5, 3)]
    )
    add_uv_map(strip.data, [(0, 0), (0, 1), (0.5, 0), (0.5, 1), (1, 0), (1, 1)])
    bake_texture(strip, samples=1024, resolution=32, use_ground_plane=True)

    to_edge = (np.arange(32) + 0.5) / 16  # 0 at the outer edge of the upper face, 1 at the middle one
    upper = to_edge < 1
    weight = np.where(upper, to_edge, 2 - to_edge)[:, None]
    normal = (1 - weight) * np.where(upper[:, None], (0, 1), (1, 0)) + weight * math.sqrt(0.5)
    z = (normal / np.linalg.norm(normal, axis=1, keepdims=True))[:, 1]
    assert rms(texture(strip)[..., 0] - (1 + z) / 2) < 0.004


@pytest.mark.parametrize(
    ("wanted", "active_render", "columns"),
    [
        ("", "Left", slice(0, 8)),
        ("", "Right", slice(8, 16)),
        ("Right", "Left", slice(8, 16)),
        ("Left", "Right", slice(0, 8)),
    ],
)
def test_uv_map(wanted, active_render, columns):
    obj = plate()
    obj.data.uv_layers.remove(obj.data.uv_layers[0])
    add_uv_map(obj.data, unit(obj) * (0.5, 1), "Left")
    add_uv_map(obj.data, unit(obj) * (0.5, 1) + (0.5, 0), "Right")
    obj.data.uv_layers[active_render].active_render = True
    obj.data.uv_layers.active = obj.data.uv_layers["Left"]
    bake_texture(obj, uv_map=wanted)
    expected = np.zeros((16, 16))
    expected[:, columns] = 1
    np.testing.assert_array_equal(texture(obj)[..., 0], expected)


@pytest.mark.parametrize("margin", [0, 1, 3, 100])
def test_margin(margin):
    """Texels up to ``margin`` from the island take the value of the nearest in it; those further away stay empty."""
    obj = plate_at((6 / 16, 6 / 16), (10 / 16, 10 / 16))
    bake_texture(obj, margin=margin)
    row, column = np.indices((16, 16))
    dx, dy = (np.maximum(np.maximum(6 - axis, axis - 9), 0) for axis in (column, row))
    inside = np.hypot(dx, dy) <= margin
    assert 16 <= inside.sum() <= 256
    np.testing.assert_array_equal(texture(obj)[..., 0], inside)
    np.testing.assert_array_equal(texture(obj, BENT_CONE)[..., 3], inside)


def test_margin_takes_the_nearest_value():
    """Two islands, a black and a white one: with "Extend" the border between them lies half-way."""
    obj = plate("Floor", steps=2)
    corners = positions(obj)[:, 0]
    box(low=(0, -2, -1), high=(2, 2, 1), inward=True)
    obj.data.uv_layers[0].uv.foreach_set("vector", halves_apart(obj, corners).ravel())
    bake_texture(obj, margin=16, margin_type="EXTEND", ignore_backfaces=True)
    dark = texture(obj)[..., 0] == 0
    np.testing.assert_array_equal(dark, np.tile(np.arange(16) >= 8, (16, 1)))


def halves_apart(obj, x):
    """UVs of the corners: the faces of x < 0 in the columns 0 to 3, those of x > 0 in the columns 12 to 15."""
    uv = []
    for face in obj.data.polygons:
        right = face.center.x > 0
        for vertex in face.vertices:
            u = x[vertex] - right  # from -1 to 0
            uv.append(((u + 1) / 4 + 0.75 * right, (positions(obj)[vertex, 1] + 1) / 2))
    return np.float32(uv)


def test_islands_thinner_than_a_texel_are_not_lost():
    """No texel centre lies in it, yet every texel that it touches is baked."""
    obj = plate_at((0.0, 0.51), (1.0, 0.52))
    bake_texture(obj)
    covered = texture(obj)[..., 0] == 1
    expected = np.zeros((16, 16), bool)
    expected[8] = True
    np.testing.assert_array_equal(covered, expected)


def test_points_and_rays_are_those_of_the_covered_texels():
    obj = plate_at((0, 0), (0.5, 0.25))
    (report,) = reports(obj, target="TEXTURE", resolution=16, margin=16, samples=32)
    assert (report.points, report.samples, report.rays) == (8 * 4, 32, 8 * 4 * 32)
    assert report.f0 == {"min": 1.0, "mean": 1.0, "max": 1.0}
    assert report.outputs == ["Plate Multibounce AO", "Plate Bent Cone"]
    assert report.warnings == []


def test_what_lies_outside_the_tile_is_told():
    obj = plate_at((0.5, 0), (1.5, 1))
    (report,) = reports(obj, target="TEXTURE", resolution=16, margin=0)
    assert report.error is None
    assert any("0-1 tile" in warning for warning in report.warnings)
    np.testing.assert_array_equal(texture(obj)[..., 0], np.tile(np.arange(16) >= 8, (16, 1)))


def test_overlap_is_told():
    obj = plate()
    obj.data.uv_layers[0].uv.foreach_set("vector", np.tile(np.float32([0, 0, 1, 0, 1, 1, 0, 1]), 16))
    (report,) = reports(obj, target="TEXTURE", resolution=16)
    assert any("overlap" in warning for warning in report.warnings)
    assert report.error is None


def test_mirrored_uvs_are_as_good():
    obj = plate_at((1, 0), (0, 1))
    box(low=(0, -2, -1), high=(2, 2, 1), inward=True)
    bake_texture(obj, ignore_backfaces=True)
    np.testing.assert_array_equal(texture(obj)[..., 0] == 0, np.tile(np.arange(16) < 8, (16, 1)))
