# SPDX-License-Identifier: GPL-3.0-or-later
"""Coefficients of a picture, against sums over many lookups."""

import numpy as np
import pytest

from core import spherical_harmonics as sh
from core.panorama import project_picture


def magnified(pixels, times):
    """(h, w, c) read bilinearly at ``times`` as many places; columns go round, rows end."""
    for axis, count in enumerate(pixels.shape[:2]):
        at = (np.arange(count * times) + 0.5) / times - 0.5
        low = np.floor(at).astype(int)
        part = (at - low).reshape(-1, *(1,) * (2 - axis))
        first, second = (np.take(pixels, index, axis=axis, mode="wrap" if axis else "clip") for index in (low, low + 1))
        pixels = first + part * (second - first)
    return pixels


@pytest.mark.parametrize("shape", [(1, 1), (2, 3), (5, 8), (16, 32)])
def test_as_many_lookups(shape):
    pixels = np.random.default_rng(0).uniform(0, 1, (*shape, 3)) ** 2
    expected = sh.project_panorama(magnified(pixels, 1024 // shape[0]))
    error = np.abs(project_picture(pixels) - expected).max()
    print(f"picture of {shape}: within {error:.1e} of the sum over lookups")
    assert error < 5e-5  # the sum is of one lookup for each of 1024 rows


def test_a_large_picture_of_a_light_gives_its_coefficients():
    light = np.random.default_rng(1).normal(size=(9, 3))
    directions, _ = sh.equirectangular(512, 1024)
    error = np.abs(project_picture(sh.evaluate(light, directions).astype(np.float32)) - light).max()
    print(f"picture of 1024 x 512 of nine coefficients: within {error:.1e}")
    assert error < 1e-4


def test_a_white_picture_is_exact():
    expected = np.zeros((9, 1))
    expected[0] = 1 / sh.Y0
    np.testing.assert_allclose(project_picture(np.ones((7, 13, 1))), expected, atol=1e-9)
