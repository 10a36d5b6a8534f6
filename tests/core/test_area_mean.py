# SPDX-License-Identifier: GPL-3.0-or-later
"""Images made smaller by the exact mean over each new pixel."""

from fractions import Fraction

import numpy as np
import pytest

from core.area_mean import area_mean, fitting_shape


@pytest.mark.parametrize(("old", "new"), [((12, 8), (3, 4)), ((7, 5), (3, 2)), ((9, 9), (9, 9)), ((10, 3), (7, 3))])
def test_means_against_rational_overlaps(old, new):
    pixels = np.random.default_rng(0).random(old)
    expected = np.zeros(new)
    for row, column in np.ndindex(new):
        for i, j in np.ndindex(old):
            share = overlap(i, old[0], row, new[0]) * overlap(j, old[1], column, new[1])
            expected[row, column] += float(share) * pixels[i, j]
    np.testing.assert_allclose(area_mean(pixels, new), expected, rtol=0, atol=1e-14)


def overlap(i, old, row, new):
    """Share of the new pixel that the old one covers."""
    left, right = max(Fraction(i, old), Fraction(row, new)), min(Fraction(i + 1, old), Fraction(row + 1, new))
    return max(Fraction(0), right - left) * new


def test_the_mean_of_all_stays():
    pixels = np.random.default_rng(1).random((97, 131))
    assert area_mean(pixels, (31, 42)).mean() == pytest.approx(pixels.mean(), abs=1e-14)


@pytest.mark.parametrize("shape", [(2, 2), (300, 200), (4096, 4096), (2, 10**6), (10**6, 3), (8192, 512)])
@pytest.mark.parametrize("most", [64, 1024, 65536])
def test_fitting_shape(shape, most):
    height, width = fitting_shape(shape, most)
    assert 2 <= height <= shape[0] and 2 <= width <= shape[1]
    assert height * width <= max(most, 4)
    if shape[0] * shape[1] <= most:
        assert (height, width) == shape
    elif min(height, width) > 2:
        assert height * width > 0.8 * most
        assert height / width == pytest.approx(shape[0] / shape[1], rel=1 / min(height, width))
