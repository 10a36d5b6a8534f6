# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels of a UV layout against geometry: what they touch, which triangle lies at each of their places, and where."""

import tracemalloc

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial import Delaunay

from core import rasterise as rasterise_module
from core import scan_conversion
from core.rasterise import bands, rasterise
from core.scan_conversion import owners, trapezoids

SIZE = 32
TILE = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], float)


def touches(triangle, size):
    """Texels (size, size) whose open square the triangle's inside meets: no axis separates them."""
    corners = triangle * size
    column, row = np.meshgrid(np.arange(size), np.arange(size))
    squares = np.stack((column, row), axis=-1)[:, :, None] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    sides = np.roll(corners, -1, axis=0) - corners
    together = np.ones((size, size), bool)
    for axis in ((1.0, 0.0), (0.0, 1.0), *(sides[:, ::-1] * (1.0, -1.0))):
        shadow, square = corners @ np.array(axis), squares @ np.array(axis)
        together &= (shadow.min() < square.max(axis=2)) & (square.min(axis=2) < shadow.max())
    return together


def contains(triangle, points):
    """How deep ``points`` (n, 2) lie in the triangle, negative outside, as a fraction of its heights."""
    a, b, c = triangle
    at = np.linalg.solve(np.column_stack((b - a, c - a)), (points - a).T)
    return np.minimum(1.0 - at.sum(axis=0), at.min(axis=0))


def triangles_at(triangles, points):
    """The lowest triangle that contains each of ``points`` (n, 2), or -1; and whether rounding cannot change that."""
    depth = np.array([contains(triangle, points) for triangle in triangles])
    inside = depth > 0.0
    return np.where(inside.any(axis=0), inside.argmax(axis=0), -1), (np.abs(depth) > 1e-9).all(axis=0)


def distance_to_segment(point, p, q):
    def distance(t):
        return np.linalg.norm(p + t * (q - p) - point)

    return minimize_scalar(distance, bounds=(0, 1), method="bounded", options={"xatol": 1e-9}).fun


def image(texels, size=SIZE):
    covered = np.zeros(size * size, bool)
    covered[texels.texel] = True
    return covered.reshape(size, size)


def position(triangles, texels, size=SIZE):
    """Where the samples (k, K) lie in their texels, in texels: (k, K, 2)."""
    v, w = np.moveaxis(texels.weights.astype(float), 2, 0)[..., None]
    a, b, c = np.moveaxis(triangles[texels.triangle], 2, 0)
    texel = np.column_stack((texels.texel % size, texels.texel // size))
    return ((1.0 - v - w) * a + v * b + w * c) * size - texel[:, None]


def places_of(count):
    """The places in a texel (K, 2), from a layout that holds them all."""
    return position(TILE, rasterise(TILE, 1, 1, count), 1)[0]


def all_places(count, size=SIZE):
    """UV of every place of an image: (size * size, K, 2)."""
    texel = np.arange(size * size)
    return (np.column_stack((texel % size, texel // size))[:, None] + places_of(count)) / size


def triangulation(seed, points=60):
    """A triangulation of the tile, its triangles in random order and with random first corners."""
    random = np.random.default_rng(seed)
    mesh = Delaunay(np.concatenate((TILE.reshape(-1, 2)[[0, 1, 2, 5]], random.uniform(0, 1, (points, 2)))))
    triangles = mesh.points[random.permutation(mesh.simplices)]
    turn = (np.arange(3) + random.integers(0, 3, (len(triangles), 1))) % 3
    return np.take_along_axis(triangles, turn[:, :, None], axis=1)


@pytest.mark.parametrize("places", range(1, 17))
def test_places_share_no_row_and_no_column(places):
    at = places_of(places)
    assert (np.sort(np.floor(at * places), axis=0) == np.arange(places)[:, None]).all()
    np.testing.assert_allclose(at.mean(axis=0), 0.5, atol=1e-6)


@pytest.mark.parametrize("places", (1, 7))
@pytest.mark.parametrize("seed", range(5))
def test_every_texel_that_a_triangle_touches_and_no_other(seed, places):
    random = np.random.default_rng(seed)
    triangles = random.uniform(-0.2, 1.2, (6, 3, 2))
    # ... and slivers, and triangles smaller than a texel
    slivers = random.uniform(0, 1, (6, 3, 2))
    slivers[:, 2] = slivers[:, 0] + 1e-6 * random.uniform(-1, 1, (6, 2))
    small = random.uniform(0, 1, (6, 1, 2)) + random.uniform(-0.5, 0.5, (6, 3, 2)) / SIZE
    triangles = np.concatenate((triangles[:2], slivers, small))
    texels = rasterise(triangles, SIZE, SIZE, places)
    assert (image(texels) == np.any([touches(t, SIZE) for t in triangles], axis=0)).all()
    assert (np.diff(texels.texel) > 0).all()


def test_triangles_that_end_on_texel_borders_touch_none_beyond():
    random = np.random.default_rng(2)
    triangles = random.uniform(4, 10, (100, 3, 2))
    triangles[:, 2, 0] = 10
    triangles[50:, :2, 0] -= 60
    # ... and one with all corners on the texel grid, whose outline passes through the texels' corners, too
    triangles[0] = (4, 4), (10, 4), (10, 10)
    for triangle in triangles / SIZE:
        assert (image(rasterise(triangle[None], SIZE, SIZE)) == touches(triangle, SIZE)).all()


@pytest.mark.parametrize("places", (1, 2, 8, 13))
@pytest.mark.parametrize("seed", range(3))
def test_each_place_shows_the_triangle_that_contains_it(seed, places):
    triangles = triangulation(seed)
    texels = rasterise(triangles, SIZE, SIZE, places)
    assert (texels.texel == np.arange(SIZE * SIZE)).all()
    expected, certain = triangles_at(triangles, all_places(places).reshape(-1, 2))
    assert certain.all()
    assert (texels.triangle.reshape(-1) == expected).all()
    np.testing.assert_allclose(
        position(triangles, texels), np.broadcast_to(places_of(places), (SIZE**2, places, 2)), atol=1e-4
    )


@pytest.mark.parametrize("rows_per_batch", (3, 2**17))
@pytest.mark.parametrize("places", (1, 6))
def test_where_triangles_overlap_the_lowest_wins(monkeypatch, places, rows_per_batch):
    monkeypatch.setattr(scan_conversion, "ROWS_PER_BATCH", rows_per_batch)
    triangles = np.random.default_rng(places).uniform(-0.3, 1.3, (40, 3, 2))
    triangles[-2:] = TILE
    texels = rasterise(triangles, SIZE, SIZE, places)
    expected, certain = triangles_at(triangles[:-2], all_places(places).reshape(-1, 2))
    assert (texels.texel == np.arange(SIZE * SIZE)).all() and certain.all()
    found = texels.triangle.reshape(-1)
    assert (found[expected >= 0] == expected[expected >= 0]).all()
    assert (found[expected < 0] >= 38).all()


def test_a_place_on_a_shared_edge_has_one_owner():
    # A grid through the places themselves: their rows, columns and diagonals.
    places = 4
    at = np.concatenate(((-1.0,), (np.arange(8 * places) + 0.5) / places, (9.0,)))
    x, y = np.meshgrid(at, at)
    quads = np.stack((x[:-1, :-1], y[:-1, :-1], x[1:, 1:], y[1:, 1:]), axis=-1).reshape(-1, 4)
    triangles = np.concatenate((quads[:, [0, 1, 2, 1, 2, 3]], quads[:, [0, 1, 2, 3, 0, 3]])).reshape(-1, 3, 2)
    offset = (np.array([2, 0, 3, 1]) + 0.5) / places
    count = np.zeros((8, places, 8), int)
    for triangle in triangles:
        x, y = triangle.T[:, :, None]
        count += owners(trapezoids(x, y * places, 8, 0, 8 * places), (0, 8), 8, offset) >= 0
    assert (count == 1).all()


def test_shares_of_texels_converge_to_the_triangles_areas():
    size, triangles = 16, triangulation(5, points=600)
    (x0, y0), (x1, y1), (x2, y2) = np.moveaxis(triangles, (1, 2), (0, 1)) * size
    area = np.abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 2
    assert np.median(area) < 0.25
    error = []
    for places in (1, 4, 16, 64):
        shares = (
            np.bincount(rasterise(triangles, size, size, places).triangle.reshape(-1), minlength=len(area)) / places
        )
        assert shares.sum() == size * size
        error.append(np.sqrt(np.mean((shares - area) ** 2)))
    # At least as fast as independent random places would.
    assert error[1] < error[0] / 2 and error[2] < error[0] / 4 and error[3] < error[0] / 8


def test_weights_are_barycentric():
    triangles = np.random.default_rng(11).uniform(-0.5, 1.5, (30, 3, 2))
    weights = rasterise(triangles, SIZE, SIZE, 8).weights
    assert (weights >= 0).all() and (np.float32(1) - weights[..., 0] - weights[..., 1] >= 0).all()


def test_places_outside_the_surface_repeat_those_inside_evenly():
    places = 8
    triangles = np.random.default_rng(7).uniform(0, 1, (4, 3, 2))
    texels = rasterise(triangles, SIZE, SIZE, places)
    expected, certain = triangles_at(triangles, all_places(places).reshape(-1, 2))
    assert certain.all()
    expected = expected.reshape(-1, places)[texels.texel]
    held, at = expected >= 0, position(triangles, texels)
    assert (texels.triangle[held] == expected[held]).all()
    partly = held.any(axis=1) & ~held.all(axis=1)
    assert partly.sum() > 100
    for triangle, shown, inside in zip(texels.triangle[partly], at[partly], held[partly], strict=True):
        away = np.abs(shown[:, None] - places_of(places)).max(axis=2)
        source = away.argmin(axis=1)
        assert away.min(axis=1).max() < 1e-4 and inside[source].all()
        assert (source[inside] == np.flatnonzero(inside)).all()
        assert (triangle == triangle[source]).all()
        assert np.ptp(np.bincount(source, minlength=places)[inside]) <= 1


@pytest.mark.parametrize("places", (1, 5))
def test_a_touched_texel_without_a_place_inside_shows_the_nearest_point(places):
    triangles = np.random.default_rng(7).uniform(0, 1, (8, 3, 2))
    texels = rasterise(triangles, SIZE, SIZE, places)
    expected, certain = triangles_at(triangles, all_places(places).reshape(-1, 2))
    assert certain.all()
    rim = np.flatnonzero((expected.reshape(-1, places)[texels.texel] < 0).all(axis=1))
    assert len(rim) > 20
    at = position(triangles, texels)[rim]
    assert (np.ptp(at, axis=1) == 0).all() and (texels.triangle[rim] == texels.triangle[rim, :1]).all()
    for texel, point in zip(texels.texel[rim], at[:, 0], strict=True):
        centre = np.array([texel % SIZE, texel // SIZE]) + 0.5
        touching = triangles[[touches(triangle, SIZE).reshape(-1)[texel] for triangle in triangles]] * SIZE
        sides = [(p, q) for t in touching for p, q in zip(t, np.roll(t, -1, axis=0), strict=True)]
        nearest = min(distance_to_segment(centre, p, q) for p, q in sides)
        assert np.linalg.norm(point - 0.5) == pytest.approx(nearest, abs=1e-5)


def test_a_texel_under_two_islands_shows_the_one_over_its_centre():
    # the first triangle touches texel (0, 0) at its far corner only; the second covers its centre
    corner = [[1.0, 1.0], [0.9 / SIZE, 1.0], [1.0, 0.9 / SIZE]]
    over = [[0.0, 0.0], [1.9 / SIZE, 0.0], [0.0, 1.9 / SIZE]]
    texels = rasterise(np.array([corner, over]), SIZE, SIZE)
    assert texels.triangle[texels.texel == 0] == [[1]]
    # where both cover the centre, the first stays
    texels = rasterise(np.array([over, over]), SIZE, SIZE)
    assert (texels.triangle == 0).all()
    # ... and where both pass it at the same distance
    sliver = np.array([[0.0, 0.1], [1.0, 0.1], [1.0, 0.1001]]) / SIZE
    texels = rasterise(np.array([sliver, sliver]), SIZE, SIZE, 3)
    assert (texels.texel == 0).all() and (texels.triangle == 0).all()


@pytest.mark.parametrize("places", (1, 6))
def test_bands_threads_and_pieces_make_the_same_image(monkeypatch, places):
    triangles = np.concatenate((triangulation(3)[:90], np.random.default_rng(3).uniform(-0.1, 1.1, (40, 3, 2))))
    triangles[::7] *= 0.01
    whole = rasterise(triangles, SIZE, SIZE, places, threads=1)
    rows = list(bands(SIZE, SIZE, places, limit=5 * SIZE * places))
    assert len(rows) == 7
    others = [[rasterise(triangles, SIZE, SIZE, places, band) for band in rows]]
    monkeypatch.setattr(rasterise_module, "PLACES_PER_TASK", 3 * SIZE * places)
    monkeypatch.setattr(scan_conversion, "ROWS_PER_BATCH", 11)
    others += [[rasterise(triangles, SIZE, SIZE, places, threads=threads)] for threads in (1, 2, 5)]
    for parts in others:
        for name in ("texel", "triangle", "weights"):
            assert (np.concatenate([getattr(part, name) for part in parts]) == getattr(whole, name)).all()


def test_triangles_that_own_nothing():
    point = [[0.5, 0.5]] * 3
    line = [[0.1, 0.1], [0.5, 0.5], [0.9, 0.9]]
    outside = [[1.0, 0.2], [2.0, 0.2], [1.5, 0.9]]
    nan = [[np.nan, 0.0], [1.0, 0.0], [0.0, 1.0]]
    infinite = [[0.0, 0.0], [np.inf, 0.0], [0.0, 1.0]]
    nothing = np.array([point, line, outside, nan, infinite])
    with np.errstate(all="raise"):
        for texels in (rasterise(nothing, SIZE, SIZE, 3), rasterise(nothing[:0], SIZE, SIZE, 3)):
            assert texels.texel.shape == (0,) and texels.triangle.shape == (0, 3) and texels.weights.shape == (0, 3, 2)
        # ... and do not disturb those that do
        texels = rasterise(np.concatenate((nothing, TILE)), SIZE, SIZE, 3)
    assert (texels.texel == np.arange(SIZE * SIZE)).all() and (texels.triangle >= len(nothing)).all()


@pytest.mark.parametrize("places", (1, 8))
def test_a_full_tile_leaves_no_hole(places):
    texels = rasterise(TILE, 512, 512, places)
    assert (texels.texel == np.arange(512 * 512)).all()
    assert np.abs(position(TILE, texels, 512) - places_of(places)).max() < 512 * 2.0**-22


def test_an_image_need_not_be_square():
    texels = rasterise(TILE, 7, 3, 4)
    assert (texels.texel == np.arange(21)).all()
    v, w = texels.weights[..., 0], texels.weights[..., 1]
    # u and v of the tile's corners: (0, 0), (1, 0), (1, 1) and (0, 0), (1, 1), (0, 1)
    second = texels.triangle == 1
    at = np.stack((np.where(second, v, v + w), np.where(second, v + w, w)), axis=-1) * (7, 3)
    row, column = np.divmod(texels.texel, 7)
    np.testing.assert_allclose(at - np.column_stack((column, row))[:, None], [places_of(4)] * 21, atol=1e-5)


def test_memory_follows_neither_the_image_nor_uvs_outside_the_tile():
    far = np.concatenate((TILE * 2e4 - 1e4, np.random.default_rng(1).uniform(-1e4, 1e4, (300, 3, 2))))
    size, places = 4096, 8
    band = next(bands(size, size, places))
    tracemalloc.start()
    try:
        texels = rasterise(far, size, size, places, band, threads=2)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert texels.triangle.size == size * (band[1] - band[0]) * places <= 2**22
    assert peak < 150e6
