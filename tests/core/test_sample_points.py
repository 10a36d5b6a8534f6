# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start: on the triangles, along their normals, the same however the surface is divided."""

from dataclasses import replace

import numpy as np
import pytest

from core.rasterise import bands, rasterise
from core.rays import Occluders
from core.sample_points import CornerTable, SurfacePoints, TexelPoints, texel_places
from core.sampling import hemisphere_pattern
from core.surface import INSET, Surface, unit
from core.visibility import trace_visibility

from .tracing import finish


def bowl(side=24):
    """A smooth bowl over the unit square, whose UVs are its x and y."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(0, 1, side), np.linspace(0, 1, side), indexing="ij"))
    vertices = np.column_stack((x, y, 2 * (x - 0.5) ** 2 + 2 * (y - 0.5) ** 2))
    i, j = np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij")
    a = (i * side + j).ravel()
    triangles = np.concatenate(
        (np.column_stack((a, a + side, a + side + 1)), np.column_stack((a, a + side + 1, a + 1)))
    ).astype(np.int32)
    corner_vertex = triangles.ravel()
    normals = unit(np.column_stack((-4 * (x - 0.5), -4 * (y - 0.5), np.ones(len(x)))))
    start = np.arange(0, corner_vertex.size, 3)
    return Surface(
        vertices,
        corner_vertex,
        normals[corner_vertex],
        np.arange(corner_vertex.size, dtype=np.int32).reshape(-1, 3),
        start,
        np.full_like(start, 3),
        np.column_stack((x, y))[corner_vertex],
    )


def texels(surface, size, places, rows=None):
    found = rasterise(surface.corner_uv[surface.triangles], size, size, places, rows)
    return TexelPoints(CornerTable(surface), found, size)


def test_points_lie_on_their_triangles_off_the_edges():
    surface = bowl()
    rng = np.random.default_rng(0)
    triangle = rng.integers(len(surface.triangles), size=(40, 3))
    u, v, w = rng.dirichlet((0.3, 0.3, 0.3), size=triangle.shape).transpose(2, 0, 1)
    positions, normals = CornerTable(surface).at(triangle, v, w)
    corners = surface.vertices[surface.vertex_triangles[triangle]]
    on_triangle = np.einsum("cnp,npcx->xnp", np.stack((u, v, w)), corners)
    edge = np.abs(corners - corners[:, :, :1]).max()
    assert 0 < np.abs(positions - on_triangle).max() <= INSET * edge
    # The bowl's normals go as (-4 (x - .5), -4 (y - .5), 1), whose first two parts triangles interpolate exactly.
    slope = -4.0 * (positions[:2] - 0.5)
    expected = np.stack((*slope, np.ones_like(v))) / np.sqrt(np.square(slope).sum(axis=0) + 1.0)
    np.testing.assert_allclose(normals, expected, atol=1e-2)
    np.testing.assert_allclose(np.square(normals).sum(axis=0), 1.0, atol=1e-12)


def test_normals_where_the_corners_cancel_out():
    surface = bowl()
    normals = surface.corner_normals.copy()
    normals[surface.triangles[5, 1]] = -normals[surface.triangles[5, 0]]
    triangle, middle = np.array([5]), np.array([0.5 - INSET / 3]) / (1.0 - INSET)
    _, normal = CornerTable(replace(surface, corner_normals=normals)).at(
        triangle, middle, -INSET / 3 / (1.0 - INSET) + 0 * middle
    )
    a, b, c = surface.vertices[surface.vertex_triangles[5]]
    face = np.cross(b - a, c - a)
    np.testing.assert_allclose(normal[:, 0], face / np.linalg.norm(face), atol=1e-12)


def test_places_stand_for_the_area_of_their_texel():
    """The mean of x over a texel is its centre's."""
    size = 8
    points = texels(bowl(), size, 16)
    positions = points.at(np.arange(len(points))).positions
    assert len(points) == size * size
    mean = positions.mean(axis=1)
    texel = points.number(np.arange(len(points)))
    np.testing.assert_allclose(mean[0], (texel % size + 0.5) / size, atol=2e-3 / size)
    np.testing.assert_allclose(mean[1], (texel // size + 0.5) / size, atol=2e-3 / size)
    assert np.ptp(positions[0], axis=0).min() > 0.8 / size


@pytest.mark.parametrize("kind", ["vertices", "texels"])
def test_order_names_every_point_once_and_keeps_neighbours_together(kind):
    surface = bowl(80)
    points = texels(surface, 100, 1) if kind == "texels" else SurfacePoints(surface.vertices, surface.vertices * 0)
    order = points.order()
    assert (np.sort(order) == np.arange(len(points))).all()
    block = points.at(order[:1000]).positions.reshape(3, -1)
    assert np.ptp(block[:2], axis=1).prod() < 0.5  # a row-by-row block of texels would span the square's whole width


def test_texels_traced_in_bands_are_the_same():
    surface = bowl()
    occluders = Occluders(surface.vertices, surface.vertex_triangles)
    size, places, pattern = 50, texel_places(40), hemisphere_pattern(40)

    def trace(rows):
        return finish(trace_visibility(occluders, texels(surface, size, places, rows), pattern, extent=1.0, seed=5))

    parts = [trace(rows) for rows in bands(size, size, places, 600 * places)]
    assert len(parts) > 3
    whole = trace(None)
    for channel in ("f0", "alpha", "bent"):
        assert np.concatenate([getattr(part, channel) for part in parts]).tobytes() == getattr(whole, channel).tobytes()


@pytest.mark.parametrize(
    ("samples", "places"), [(1, 1), (15, 3), (16, 4), (64, 8), (100, 10), (256, 16), (1024, 16), (4096, 16)]
)
def test_as_many_places_as_rays_for_each_up_to_sixteen(samples, places):
    assert texel_places(samples) == places


@pytest.mark.parametrize("samples", [16, 97, 100])
def test_rays_that_do_not_divide_evenly_still_count_fully(samples):
    """An open plane sees all of the sky, whatever number of rays its places share."""
    surface = bowl()
    flat = replace(
        surface, vertices=surface.vertices * (1, 1, 0), corner_normals=surface.corner_normals * 0 + (0, 0, 1)
    )
    points = texels(flat, 10, texel_places(samples))
    occluders = Occluders(flat.vertices, flat.vertex_triangles)
    seen = finish(trace_visibility(occluders, points, hemisphere_pattern(samples), extent=1.0))
    assert (seen.f0 == 1.0).all() and (seen.alpha == 1.0).all()
    length = np.linalg.norm(seen.bent, axis=1)
    # Mean of cos over the hemisphere: 1/2, within a ray's stratum.
    np.testing.assert_allclose(length, 0.5, atol=0.5 / samples)
