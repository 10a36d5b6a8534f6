# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start on coarse smooth meshes, against the planes that the lift is defined by."""

import numpy as np

from core.rays import Occluders
from core.sample_points import CornerTable, SurfacePoints
from core.sampling import hemisphere_pattern
from core.surface import Surface
from core.terminator import Terminator
from core.visibility import trace_visibility

from .tracing import finish


def points_on(count, triangles, seed=0):
    random = np.random.default_rng(seed)
    v, w = random.random((2, count))
    over = v + w > 1
    v[over], w[over] = 1 - v[over], 1 - w[over]
    return random.integers(triangles, size=count), v, w


def as_defined(corners, normals, v, w):
    """One point: the definitions, in their own words."""
    weights = np.array((1 - v - w, v, w))
    point, normal = weights @ corners, weights @ normals
    normal /= np.linalg.norm(normal)
    return max((corners - point) @ normal), sum(weights * ((corners - point) * normals).sum(axis=1))


def test_heights_are_as_defined():
    random = np.random.default_rng(1)
    corners, normals = random.normal(size=(2, 50, 3, 3))
    normals += (0, 0, 3)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    triangle, v, w = points_on(400, 50)
    table = Terminator(np.moveaxis(corners, 0, 2), np.moveaxis(normals, 0, 2))
    expected = [as_defined(corners[t], normals[t], *at) for t, *at in zip(triangle, v, w, strict=True)]
    assert np.ptp(expected, axis=0).min() > 0.5
    np.testing.assert_allclose(np.transpose(table.heights(triangle, v, w)), expected, atol=2e-5)


def lift_of(corners, normals, v, w):
    """What :meth:`CornerTable.start` makes of it, on one triangle."""
    heights = Terminator(corners[..., None], normals[..., None]).heights(np.zeros(len(v), np.intp), v, w)
    return np.maximum(np.minimum(*heights), 0)


def triangles_about_z(lean):
    """Equilateral, of side sqrt(3), with normals that lean outwards (> 0, as on a ball) or inwards by so many rad."""
    angle = np.arange(3) * 2 * np.pi / 3
    out = np.column_stack((np.cos(angle), np.sin(angle), np.zeros(3)))
    return out, np.sin(lean) * out + np.cos(lean) * np.array((0.0, 0.0, 1.0))


def test_bulging_triangles_lie_below_and_hollow_ones_are_left():
    _, v, w = points_on(1000, 1)
    weights = np.column_stack((1 - v - w, v, w))
    for lean in (0.05, 0.5, 1.0):
        corners, normals = triangles_about_z(lean)
        normal = weights @ normals
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        lift = lift_of(corners, normals, v, w)
        start = weights @ corners + lift[:, None] * normal
        above = np.einsum("cx,nx->nc", corners, normal) - (start * normal).sum(axis=1)[:, None]
        assert above.max() < 1e-6  # the whole triangle is below the hemisphere ...
        assert (above.max(axis=1) > -1e-6).mean() > 0.9  # ... and its highest corner just below
        corners, normals = triangles_about_z(-lean)
        assert lift_of(corners, normals, v, w).max() < 1e-6


def test_between_a_ridge_and_a_furrow_nothing_is_lifted():
    """Their normals are one: the curved surface passes through the middle of the face."""
    corners = np.array([(0.0, 0, 0), (1, 0, 1), (0, 1, 0)])
    _, v, w = points_on(100, 1)
    assert lift_of(corners, np.tile((0.0, 0, 1), (3, 1)), v, w).max() < 1e-6


def test_flat_shading_needs_none():
    corners, normals = triangles_about_z(0.0)
    assert Terminator(corners[..., None], normals[..., None]).is_flat
    assert Terminator(np.empty((3, 3, 0)), np.empty((3, 3, 0))).is_flat


def ball(segments, rings):
    """A sphere of radius 1 as Blender makes them, with its smooth normals (those of the ideal sphere)."""
    polar, azimuth = np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(segments) / segments
    ring = np.stack(
        [f[:, None] * g for f, g in ((np.sin(polar), np.cos(azimuth)), (np.sin(polar), np.sin(azimuth)))]
        + [np.repeat(np.cos(polar)[:, None], segments, axis=1)],
        axis=-1,
    )
    vertices = np.concatenate((ring.reshape(-1, 3), ((0, 0, 1), (0, 0, -1))))
    j = np.arange(segments)
    k, top, bottom, last = (j + 1) % segments, len(vertices) - 2, len(vertices) - 1, segments * (rings - 2)
    faces = [np.column_stack((np.full(segments, top), j, k)), np.column_stack((last + k, last + j, j * 0 + bottom))]
    for row in range(rings - 2):
        upper, lower = row * segments, (row + 1) * segments
        quads = upper + j, lower + j, lower + k, upper + k
        faces += [np.column_stack(quads[:3]), np.column_stack((quads[0], *quads[2:]))]
    return vertices, np.concatenate(faces)


def table_of(vertices, triangles):
    flat = triangles.reshape(-1)
    corners = np.arange(len(flat), dtype=np.int32).reshape(-1, 3)
    start = np.arange(0, len(flat), 3, dtype=np.int32)
    return CornerTable(Surface(vertices, flat.astype(np.int32), vertices[flat], corners, start, np.full_like(start, 3)))


def traced(occluders, table, places, lifted=True):
    start = table.start(*places)
    points = SurfacePoints(start.positions.T, start.normals.T, start.lift if lifted else None)
    return finish(trace_visibility(occluders, points, hemisphere_pattern(256), extent=2.0))


def test_a_coarse_ball_sees_all_of_the_sky():
    """12 x 6 segments; without the lift up to 3 % of the light is lost."""
    vertices, triangles = ball(12, 6)
    table, occluders = table_of(vertices, triangles), Occluders(vertices, triangles)
    places = points_on(2000, len(triangles))
    assert traced(occluders, table, places, lifted=False).f0.min() < 0.98
    seen = traced(occluders, table, places)
    assert seen.f0.min() > 0.999
    assert seen.alpha.min() > 0.98  # it weighs grazing rays fully: some meet a triangle beside their own


def test_lifts_do_not_pass_what_lies_close_above():
    """A ball in a slightly larger one, and one that stands on a floor: there the ideal sphere sees (1 + z)/2."""
    vertices, triangles = ball(12, 6)
    table, places = table_of(vertices, triangles), points_on(2000, len(triangles))
    for gap in (0.03, 0.001):
        both = np.concatenate((vertices, (1 + gap) * vertices)), np.concatenate((triangles, triangles + len(vertices)))
        assert traced(Occluders(*both), table, places).f0.max() == 0.0
    on_floor = traced(Occluders(vertices, triangles, -1.0), table, places)
    z = table.at(*places)[1][2]
    assert np.sqrt(np.mean((on_floor.f0 - (1 + z) / 2) ** 2)) < 0.005
