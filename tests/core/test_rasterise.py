# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels of a UV layout against a brute-force coverage test, and what each of them shows."""

import numpy as np
import pytest

from core.rasterise import bands, rasterise

SIZE, FINE = 32, 40


def covered_by_brute_force(triangles):
    """Texels that hold at least one of FINE x FINE points of a triangle."""
    at = (np.arange(SIZE * FINE) + 0.5) / (SIZE * FINE)
    x, y = np.meshgrid(at, at)
    covered = np.zeros((SIZE, SIZE), bool)
    for triangle in triangles:
        sides = []
        for p, q in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            sides.append((q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]))
        inside = (np.min(sides, axis=0) >= 0) | (np.max(sides, axis=0) <= 0)
        covered |= inside.reshape(SIZE, FINE, SIZE, FINE).any(axis=(1, 3))
    return covered


def image(texels):
    covered = np.zeros(SIZE * SIZE, bool)
    covered[texels.texel] = True
    return covered.reshape(SIZE, SIZE)


def uv_at(triangles, texels):
    return np.einsum("kc,kcx->kx", texels.barycentric, triangles[texels.triangle])


@pytest.mark.parametrize("seed", range(5))
def test_every_texel_that_a_triangle_touches(seed):
    triangles = np.random.default_rng(seed).uniform(-0.2, 1.2, (12, 3, 2))
    found, expected = image(rasterise(triangles, SIZE, SIZE)), covered_by_brute_force(triangles)
    assert (found | ~expected).all(), "a touched texel is missing"
    # ... and no more than slivers that fall between the brute force's points
    assert (found & ~expected).sum() < 0.03 * found.sum() + 3


def test_points_lie_in_their_texel_or_at_the_island_next_to_it():
    triangles = np.random.default_rng(7).uniform(0, 1, (8, 3, 2))
    texels = rasterise(triangles, SIZE, SIZE)
    centre = np.stack((texels.texel % SIZE + 0.5, texels.texel // SIZE + 0.5), axis=1) / SIZE
    away = np.linalg.norm(uv_at(triangles, texels) - centre, axis=1) * SIZE
    assert (texels.barycentric > 0).all()
    np.testing.assert_allclose(texels.barycentric.sum(axis=1), 1.0)
    # a triangle that touches the texel comes at least as near to its centre as the texel's corners; plus the inset
    assert away.max() < 0.5**0.5 + 1e-3 * SIZE


def test_a_texel_under_two_islands_shows_the_one_over_its_centre():
    # the first triangle touches texel (0, 0) at its far corner only; the second covers its centre
    corner = [[1.0, 1.0], [0.9 / SIZE, 1.0], [1.0, 0.9 / SIZE]]
    over = [[0.0, 0.0], [1.9 / SIZE, 0.0], [0.0, 1.9 / SIZE]]
    texels = rasterise(np.array([corner, over]), SIZE, SIZE)
    assert texels.triangle[texels.texel == 0] == [1]
    # where both cover the centre, the first stays
    texels = rasterise(np.array([over, over]), SIZE, SIZE)
    assert (texels.triangle == 0).all()


def test_bands_make_the_same_image():
    triangles = np.random.default_rng(3).uniform(-0.1, 1.1, (40, 3, 2))
    whole = rasterise(triangles, SIZE, SIZE)
    parts = [rasterise(triangles, SIZE, SIZE, rows) for rows in bands(SIZE, SIZE, texels=5 * SIZE)]
    assert len(parts) == 7
    for name in ("texel", "triangle", "barycentric"):
        assert (np.concatenate([getattr(part, name) for part in parts]) == getattr(whole, name)).all()


def test_triangles_that_own_nothing():
    point = [[0.5, 0.5]] * 3
    line = [[0.1, 0.1], [0.5, 0.5], [0.9, 0.9]]
    outside = [[1.0, 0.2], [2.0, 0.2], [1.5, 0.9]]
    nan = [[np.nan, 0.0], [1.0, 0.0], [0.0, 1.0]]
    with np.errstate(all="raise"):
        assert len(rasterise(np.array([point, line, outside]), SIZE, SIZE).texel) == 0
    assert len(rasterise(np.array([nan]), SIZE, SIZE).texel) == 0
    assert len(rasterise(np.empty((0, 3, 2)), SIZE, SIZE).texel) == 0


def test_a_full_tile_leaves_no_hole():
    tile = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], float)
    texels = rasterise(tile, 1024, 1024)
    assert (texels.texel == np.arange(1024 * 1024)).all()
    centre = np.stack((texels.texel % 1024 + 0.5, texels.texel // 1024 + 0.5), axis=1) / 1024
    assert np.abs(uv_at(tile, texels) - centre).max() < 1e-3
