# SPDX-License-Identifier: GPL-3.0-or-later
"""Points on surfaces: normals, split vertices, the margin, and a Morton curve."""

from dataclasses import replace

import numpy as np
import pytest

from core.margin import extend_margin
from core.morton import morton_order
from core.surface import INSET, Surface, into_faces


def roof(smooth):
    """Two square faces that meet at a right angle along y; corners 0-3 and 4-7."""
    vertices = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 1], [-1, 1, 0], [1, 0, 0], [1, 1, 0]], float)
    corner_vertex = np.array([0, 1, 2, 3, 1, 4, 5, 2], np.int32)
    left, right = np.array([-1, 0, 1]) / 2**0.5, np.array([1, 0, 1]) / 2**0.5
    normals = np.array([left] * 4 + [right] * 4)
    if smooth:
        normals[[1, 2, 4, 7]] = (0, 0, 1)
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]], np.int32)
    return Surface(vertices, corner_vertex, normals, triangles, np.array([0, 4]), np.array([4, 4]))


def test_split_vertices_at_a_sharp_ridge_and_not_at_a_smooth_one():
    positions, normals, split = roof(smooth=False).split_vertices()
    assert len(positions) == 8
    positions, normals, split = roof(smooth=True).split_vertices()
    assert len(positions) == 6 and split[1] == split[4] and split[2] == split[7]
    surface = roof(smooth=False)
    positions, normals, split = surface.split_vertices()
    np.testing.assert_allclose(normals[split], surface.corner_normals)
    corners = surface.vertices[surface.corner_vertex]
    centres = np.repeat(corners.reshape(2, 4, 3).mean(axis=1), 4, axis=0)
    moved = positions[split] - corners
    assert (np.einsum("cx,cx->c", moved, centres - corners) > 0).all()
    assert (np.linalg.norm(moved, axis=1) <= INSET).all()  # of edges of length 1 and more


def inside(point, outline):
    """Even-odd rule: how often a ray to +x crosses the outline."""
    crossings = 0
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        if (y0 > point[1]) != (y1 > point[1]):
            crossings += point[0] < x0 + (point[1] - y0) / (y1 - y0) * (x1 - x0)
    return crossings % 2 == 1


@pytest.mark.parametrize("turned", [False, True])
def test_corners_move_into_concave_faces(turned):
    """A U whose centre lies outside of it, with a corner on a straight edge, and a triangle."""
    u = np.array([(0, 0), (3, 0), (6, 0), (6, 5), (5, 5), (5, 1), (1, 1), (1, 5), (0, 5)], float)
    triangle = np.array([(8, 0), (9, 0), (8, 0.01)])
    outlines = [u[::-1] if turned else u, triangle]
    corners = np.column_stack((np.concatenate(outlines), np.full(12, 1e5)))
    moved = corners + 1e-2 * into_faces(corners, np.array([0, 9]), np.array([9, 3]))
    np.testing.assert_allclose(moved[:, 2], 1e5)
    assert all(inside(point, outlines[0]) for point in moved[:9, :2])
    assert all(inside(point, outlines[1]) for point in moved[9:, :2])


def test_barycentric_coordinates_of_points_on_triangles():
    surface = roof(smooth=False)
    weights = np.random.default_rng(0).dirichlet((1, 1, 1), 50)
    triangle = np.arange(50) % 4
    points = np.einsum("kc,kcx->kx", weights, surface.vertices[surface.vertex_triangles[triangle]])
    np.testing.assert_allclose(surface.barycentric_at(triangle, points), weights, atol=1e-12)


def test_loose_vertices_do_not_count_for_the_size():
    surface = roof(smooth=False)
    vertices = np.concatenate((surface.vertices, [(1e6, 0, 0)]))
    assert replace(surface, vertices=vertices).extent == surface.extent == 2.0


def test_margin_takes_the_nearest_texel_and_stops():
    pixels, covered = np.zeros((9, 20, 4), np.float32), np.zeros((9, 20), bool)
    pixels[4, 5], covered[4, 5] = 1.0, True
    pixels[4, 12], covered[4, 12] = 2.0, True
    extend_margin((pixels,), covered, 3)
    row, column = np.mgrid[:9, :20]
    left, right = np.hypot(row - 4, column - 5), np.hypot(row - 4, column - 12)
    expected = np.where(np.minimum(left, right) > 3, 0.0, np.where(left < right, 1.0, 2.0))
    assert (pixels == expected[..., None]).all()
    before = pixels.copy()
    extend_margin((pixels,), covered, 0)
    assert (pixels == before).all()


@pytest.mark.parametrize("margin", [1, 20, 1000])
def test_margin_of_a_tall_image(margin):
    """Each texel takes the value of one that is as near as any, whichever part of the image it lies in."""
    rng = np.random.default_rng(margin)
    covered = rng.random((700, 30)) < 0.002
    own = np.stack(np.indices(covered.shape), axis=-1)
    image = np.where(covered[..., None], own, -1).astype(np.float32)
    extend_margin((image,), covered, margin, threads=3)
    distance = np.sqrt(np.square(own[:, :, None] - own[covered]).sum(axis=-1)).min(axis=2)
    filled = image[..., 0] >= 0
    assert (filled == (distance <= margin)).all()
    source = image[filled].astype(int)
    assert covered[tuple(source.T)].all()
    np.testing.assert_allclose(np.sqrt(np.square(own[filled] - source).sum(axis=1)), distance[filled])


def test_morton_neighbours_stay_together():
    points = np.random.default_rng(0).random((4096, 3))
    order = morton_order(points)
    assert (np.sort(order) == np.arange(4096)).all()
    step = np.linalg.norm(np.diff(points[order], axis=0), axis=1).mean()
    assert step < 0.25 * np.linalg.norm(np.diff(points, axis=0), axis=1).mean()
    # octants come in order: z above y above x
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    assert (morton_order(corners[::-1]) == np.arange(8)[::-1]).all()


@pytest.mark.parametrize("height", [0.3, -0.3])
@pytest.mark.parametrize("cut", [((0, 1, 2), (0, 2, 3)), ((1, 2, 3), (1, 3, 0))])
def test_split_vertices_of_a_bent_quad_lie_below_neither_of_its_triangles(cut, height):
    """A ridge and a valley along either diagonal, flat-shaded."""
    vertices = np.array([(0.0, 0, height), (1, 0, 0), (1, 1, height), (0, 1, 0)])
    triangles = np.array(cut, np.int32)
    up = np.tile((0.0, 0.0, 1.0), (4, 1))
    corners = np.arange(4, dtype=np.int32)
    surface = Surface(vertices, corners, up, triangles, np.array([0], np.int32), np.array([4], np.int32))
    positions, _, corner_point = surface.split_vertices()
    for triangle in triangles:
        a, b, c = vertices[triangle]
        normal = np.cross(b - a, c - a)
        assert ((positions[corner_point[triangle]] - a) @ normal).min() > -1e-12
    assert np.abs(positions[corner_point] - vertices).max() < INSET
