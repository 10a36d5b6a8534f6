# SPDX-License-Identifier: GPL-3.0-or-later
"""Base colours of triangles, against the formulas of interpolation written out, one point at a time."""

import math

import numpy as np
import pytest

from core.albedo import GREY, Albedo, Constants, CornerColours, Texture, TextureColours

RED, GREEN, BLUE, WHITE = np.eye(3)[0], np.eye(3)[1], np.eye(3)[2], np.ones(3)
# Lower row red, green; upper row blue, white.
FOUR = np.array([[RED, GREEN], [BLUE, WHITE]], np.float32)


def reference(pixels, extension, is_closest, u, v):
    """One point: the pixels around it, found by laying out the image again and again, by their distance."""
    height, width = pixels.shape[:2]
    pixels = pixels.astype(np.float64)

    def pixel(column, row):
        if extension == "CLIP" and not (0 <= column < width and 0 <= row < height):
            return np.zeros(3)
        return pixels[inside(row, height), inside(column, width)]

    def inside(index, size):
        if extension == "REPEAT":
            return index - size * math.floor(index / size)
        if extension == "MIRROR":
            tile = math.floor(index / size)
            within = index - size * tile
            return within if tile % 2 == 0 else size - 1 - within
        return min(max(index, 0), size - 1)

    x, y = u * width, v * height
    if is_closest:
        return pixel(math.floor(x), math.floor(y))
    total = np.zeros(3)
    for row in range(math.floor(y) - 1, math.floor(y) + 2):
        for column in range(math.floor(x) - 1, math.floor(x) + 2):
            weight = max(0.0, 1 - abs(x - column - 0.5)) * max(0.0, 1 - abs(y - row - 0.5))
            total += weight * pixel(column, row)
    return total


@pytest.mark.parametrize("is_closest", [False, True])
@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
def test_texture(extension, is_closest):
    random = np.random.default_rng(1)
    pixels = random.random((3, 5, 3)).astype(np.float32)
    uv = random.uniform(-3, 4, (2000, 2))
    expected = [reference(pixels, extension, is_closest, *point) for point in uv]
    error = np.abs(Texture(pixels, extension, is_closest).at(uv) - expected).max()
    print(f"{extension}, closest {is_closest}: largest error {error:.1e}")
    assert error < 1e-12


def test_texture_at_known_places():
    texture = Texture(FOUR, "EXTEND")
    uv = np.array([(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75), (0.5, 0.5), (0.5, 0.25), (0, 0), (9, -9)])
    expected = [RED, GREEN, BLUE, WHITE, (RED + GREEN + BLUE + WHITE) / 4, (RED + GREEN) / 2, RED, GREEN]
    np.testing.assert_allclose(texture.at(uv), expected, atol=1e-15)


def test_clip_fades_to_black_within_half_a_pixel():
    """As Cycles does: what is outside is black, and the bilinear mean runs across the border."""
    at = Texture(FOUR, "CLIP").at(np.array([(0.0, 0.25), (-0.2, 0.25), (-0.25, 0.25), (0.25, 1.5)]))
    np.testing.assert_allclose(at, [RED / 2, RED * 0.1, 0 * RED, 0 * RED], atol=1e-15)


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
def test_no_uv_is_too_wild(extension):
    uv = np.array([(np.nan, 0.1), (np.inf, -np.inf), (1e30, -1e30), (3e18, 1e300)])
    with np.errstate(all="raise"):
        assert np.isfinite(Texture(FOUR, extension).at(uv)).all()


def test_sources_of_a_scene():
    """Each kind, in an order that mixes them; triangles that share a row; the ground."""
    corners = np.array([[RED, GREEN, BLUE]], np.float32)
    uv = np.array([[(0.25, 0.25), (0.75, 0.25), (0.25, 0.75)]], np.float32)
    sources = [
        Constants(np.array([(0.1, 0.2, 0.3), (0.4, 0.5, 0.6)])),
        CornerColours(corners),
        TextureColours(Texture(FOUR), uv, scale=(0.5, 1.0, 1.0), offset=(0.25, 0.0, 0.0)),
    ]
    albedo = Albedo(sources, np.array([3, 1, 2, 0, 2]), ground=(0.3, 0.2, 0.1))
    assert len(albedo) == 5
    v, w = 0.5, 0.125
    gradient = (1 - v - w) * RED + v * GREEN + w * BLUE
    # The UVs of the corners are the middles of three pixels: at 1/2 and 1/8 of the way along the square's sides.
    bilinear = (1 - v) * (1 - w) * RED + v * (1 - w) * GREEN + (1 - v) * w * BLUE + v * w * WHITE
    tinted = bilinear * (0.5, 1, 1) + (0.25, 0, 0)
    expected = [gradient, (0.4, 0.5, 0.6), tinted, (0.3, 0.2, 0.1), gradient, (0.1, 0.2, 0.3)]
    triangle = np.array([2, 1, 0, 5, 4, 3])
    np.testing.assert_allclose(albedo.at(triangle, np.full(6, v), np.full(6, w)), expected, atol=1e-7)


def test_the_corners_are_first_second_third():
    albedo = Albedo([CornerColours(np.array([[RED, GREEN, BLUE]], np.float32))], np.array([0]))
    np.testing.assert_array_equal(albedo.at(np.zeros(3, int), [0, 1, 0], [0, 0, 1]), [RED, GREEN, BLUE])


def test_a_hit_does_not_depend_on_the_others():
    """What is asked together may be another set of hits each time: the bits must not change."""
    random = np.random.default_rng(2)
    sources = [
        Constants(random.random((7, 3))),
        CornerColours(random.random((50, 3, 3)).astype(np.float32)),
        TextureColours(Texture(random.random((8, 8, 3)).astype(np.float32)), random.random((60, 3, 2), np.float32)),
        TextureColours(Texture(FOUR, "MIRROR", True), random.random((70, 3, 2)).astype(np.float32)),
    ]
    albedo = Albedo(sources, random.integers(0, 7 + 50 + 60 + 70, 500))
    triangle, v, w = random.integers(0, 501, 3000), random.random(3000) / 2, random.random(3000) / 2
    together = albedo.at(triangle, v, w)
    apart = np.concatenate(
        [albedo.at(triangle[i : i + 1], v[i : i + 1], w[i : i + 1]) for i in range(0, len(triangle), 7)]
    )
    np.testing.assert_array_equal(together[::7], apart)


def test_always_within_0_and_1():
    wild = np.array([(-1.0, 2.0, np.nan), (np.inf, -np.inf, 0.5)])
    albedo = Albedo([Constants(wild)], np.array([0, 1]), ground=(2.0, -1.0, 0.5))
    np.testing.assert_array_equal(
        albedo.at(np.arange(3), np.zeros(3), np.zeros(3)), [(0, 1, 0), (1, 0, 0.5), (1, 0, 0.5)]
    )


def test_without_triangles_or_hits():
    albedo = Albedo([], np.empty(0, int))
    np.testing.assert_array_equal(albedo.at(np.array([0]), [0.2], [0.2]), [GREY])
    assert albedo.at(np.empty(0, int), [], []).shape == (0, 3)


@pytest.mark.parametrize("row", [-1, 1])
def test_a_row_that_no_source_has(row):
    with pytest.raises(ValueError, match="row"):
        Albedo([Constants(np.array([GREY]))], np.array([0, row]))
