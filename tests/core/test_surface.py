# SPDX-License-Identifier: GPL-3.0-or-later
"""Points on surfaces: the nearest one, split vertices, the margin, and a Morton curve."""

import numpy as np
import pytest

from core.closest_point import closest_point
from core.exr import read_exr, write_exr
from core.margin import extend_margin
from core.morton import morton_order
from core.surface import INSET, Surface


def nearest_by_brute_force(query, triangle):
    """Distance by dense sampling: an upper bound within the sampling step."""
    u, v = np.meshgrid(np.linspace(0, 1, 120), np.linspace(0, 1, 120))
    inside = u + v <= 1
    u, v = u[inside], v[inside]
    points = triangle[0] + u[:, None] * (triangle[1] - triangle[0]) + v[:, None] * (triangle[2] - triangle[0])
    return np.linalg.norm(points - query, axis=1).min()


def test_closest_point_of_triangles_of_many_sizes():
    rng = np.random.default_rng(0)
    centres = rng.uniform(-1, 1, (40, 1, 3))
    corners = centres + rng.normal(size=(40, 3, 3)) * 10.0 ** rng.uniform(-3, 0, (40, 1, 1))
    vertices, triangles = corners.reshape(-1, 3), np.arange(120).reshape(40, 3)
    queries = rng.uniform(-2, 2, (25, 3))
    triangle, barycentric = closest_point(queries, vertices, triangles)
    found = np.linalg.norm(np.einsum("qc,qcx->qx", barycentric, corners[triangle]) - queries, axis=1)
    expected = np.array([min(nearest_by_brute_force(q, t) for t in corners) for q in queries])
    assert (barycentric >= 0).all()
    assert (found <= expected + 1e-12).all() and (found >= expected - 0.05).all()


def test_closest_point_on_a_sphere_is_along_the_radius():
    from .shapes import sphere

    vertices, triangles = sphere(rings=64)
    directions = np.random.default_rng(1).normal(size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    triangle, barycentric = closest_point(3.0 * directions, vertices, triangles)
    found = np.einsum("qc,qcx->qx", barycentric, vertices[triangles[triangle]])
    assert np.linalg.norm(found - directions, axis=1).max() < 0.03  # half a facet's diagonal off at the most


def test_degenerate_triangles_have_a_closest_point():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]], float)
    triangle, barycentric = closest_point([[1.5, 1.0, 0.0]], vertices, np.array([[0, 1, 2], [3, 3, 3]]))
    assert triangle == [0]
    np.testing.assert_allclose(barycentric @ vertices[[0, 1, 2]], [[1.5, 0, 0]], atol=1e-12)


def roof(smooth):
    """Two square faces that meet at a right angle along y; corners 0-3 and 4-7."""
    vertices = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 1], [-1, 1, 0], [1, 0, 0], [1, 1, 0]], float)
    corner_vertex = np.array([0, 1, 2, 3, 1, 4, 5, 2], np.int32)
    left, right = np.array([-1, 0, 1]) / 2**0.5, np.array([1, 0, 1]) / 2**0.5
    normals = np.array([left] * 4 + [right] * 4)
    if smooth:
        normals[[1, 2, 4, 7]] = (0, 0, 1)
    corners = vertices[corner_vertex]
    centres = np.repeat(corners.reshape(2, 4, 3).mean(axis=1), 4, axis=0)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    return Surface(vertices, corner_vertex, normals, centres - corners, triangles)


def test_split_vertices_at_a_sharp_ridge_and_not_at_a_smooth_one():
    positions, normals, split = roof(smooth=False).split_vertices()
    assert len(positions) == 8
    positions, normals, split = roof(smooth=True).split_vertices()
    assert len(positions) == 6 and split[1] == split[4] and split[2] == split[7]
    surface = roof(smooth=False)
    positions, normals, split = surface.split_vertices()
    np.testing.assert_allclose(normals[split], surface.corner_normals)
    np.testing.assert_allclose(positions[split] - surface.vertices[surface.corner_vertex], INSET * surface.corner_inset)


def test_normals_where_the_corners_cancel_out():
    surface = roof(smooth=False)
    opposite = surface.corner_normals.copy()
    opposite[1] = -opposite[0]
    flipped = Surface(surface.vertices, surface.corner_vertex, opposite, surface.corner_inset, surface.triangles)
    normal = flipped.normals_at(np.array([0]), np.array([[0.5, 0.5, 0.0]]))
    a, b, c = surface.vertices[[0, 1, 2]]
    face = np.cross(b - a, c - a)
    np.testing.assert_allclose(normal, [face / np.linalg.norm(face)], atol=1e-12)


def test_margin_takes_the_nearest_texel_and_stops():
    pixels, covered = np.zeros((9, 20, 4), np.float32), np.zeros((9, 20), bool)
    pixels[4, 5], covered[4, 5] = 1.0, True
    pixels[4, 12], covered[4, 12] = 2.0, True
    extend_margin(pixels, covered, 3)
    row, column = np.mgrid[:9, :20]
    left, right = np.hypot(row - 4, column - 5), np.hypot(row - 4, column - 12)
    expected = np.where(np.minimum(left, right) > 3, 0.0, np.where(left < right, 1.0, 2.0))
    assert (pixels == expected[..., None]).all()
    before = pixels.copy()
    extend_margin(pixels, covered, 0)
    assert (pixels == before).all()


def test_morton_neighbours_stay_together():
    points = np.random.default_rng(0).random((4096, 3))
    order = morton_order(points)
    assert (np.sort(order) == np.arange(4096)).all()
    step = np.linalg.norm(np.diff(points[order], axis=0), axis=1).mean()
    assert step < 0.25 * np.linalg.norm(np.diff(points, axis=0), axis=1).mean()
    # octants come in order: z above y above x
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    assert (morton_order(corners[::-1]) == np.arange(8)[::-1]).all()


def test_exr_keeps_every_bit_and_leaves_no_scraps(tmp_path):
    pixels = np.random.default_rng(0).normal(size=(5, 7, 4)).astype(np.float32)
    write_exr(tmp_path / "map.exr", pixels)
    assert (read_exr(tmp_path / "map.exr") == pixels).all()
    write_exr(tmp_path / "map.exr", 2 * pixels)
    assert (read_exr(tmp_path / "map.exr") == 2 * pixels).all()
    with pytest.raises(OSError, match="cannot write"):
        write_exr(tmp_path / "missing" / "map.exr", pixels)
    assert [path.name for path in tmp_path.iterdir()] == ["map.exr"]
