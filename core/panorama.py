# SPDX-License-Identifier: GPL-3.0-or-later
"""An equirectangular picture's nine spherical-harmonic coefficients, exactly as a renderer shows it.

A renderer reads the picture bilinearly: L(latitude, longitude) is a sum of pixels times tents, one as wide as two
columns and one as high as two rows, around in columns, while the first and the last row go on to the poles. Each basis
function is a product too, of one function of the latitude and cos or sin of m times the longitude, m = 0, 1, 2. So the
integral over the sphere is two small matrix products, however large the picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .spherical_harmonics import Y0, Y1, Y2, Y20, Y22

# Rows that are held as float64 at once.
ROWS = 64
# Nodes of the quadrature between two rows' middles; what it integrates is smooth there.
NODES = 8


def project_picture(pixels: NDArray) -> NDArray[np.float64]:
    """Coefficients (9, channels) in the order of :mod:`.spherical_harmonics` of ``pixels`` (height, width, channels),
    laid out as :func:`.spherical_harmonics.equirectangular` has it, bottom row first."""
    height, width, channels = pixels.shape
    around = _around(width)
    turned = np.empty((height, 5, channels))
    for first in range(0, height, ROWS):
        turned[first : first + ROWS] = around @ pixels[first : first + ROWS].astype(np.float64)
    # One row of the sum for each function of the latitude, one column for each of the longitude.
    one, sin, square, cos, both, cos_square = np.tensordot(_along(height), turned, axes=(1, 0))
    c0, c1, s1, c2, s2 = range(5)
    return np.stack(
        (
            Y0 * one[c0],
            *(Y1 * cos[s1], Y1 * sin[c0], Y1 * cos[c1]),
            *(0.5 * Y2 * cos_square[s2], Y2 * both[s1], Y20 * square[c0], Y2 * both[c1], Y22 * cos_square[c2]),
        )
    )


def _around(width: int) -> NDArray[np.float64]:
    """(5, width): integrals over the longitude of each column's tent times 1, cos, sin, cos 2., sin 2.

    A tent's Fourier transform is the square of sin(x) / x.
    """
    step = 2.0 * np.pi / width
    longitude = np.pi * (1.0 - 2.0 * (np.arange(width) + 0.5) / width)
    once, twice = (np.sinc(m * step / (2.0 * np.pi)) ** 2 for m in (1, 2))  # numpy's sinc(x) is of pi x
    waves = (np.ones(width), once * np.cos(longitude), once * np.sin(longitude))
    return step * np.stack((*waves, twice * np.cos(2.0 * longitude), twice * np.sin(2.0 * longitude)))


def _along(height: int) -> NDArray[np.float64]:
    """(6, height): integrals over the latitude b of each row's tent times cos b, the area, and 1, sin b, 3 sin^2 b - 1,
    cos b, sin b cos b, cos^2 b; by Gauss and Legendre between the rows' middles."""
    middles = np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    edges = np.concatenate(([-0.5 * np.pi], middles, [0.5 * np.pi]))
    node, weight = np.polynomial.legendre.leggauss(NODES)
    part, size = 0.5 * (node + 1.0), np.diff(edges)[:, None]
    latitude = edges[:-1, None] + size * part
    sin, cos = np.sin(latitude), np.cos(latitude)
    functions = np.stack((np.ones_like(sin), sin, 3.0 * sin * sin - 1.0, cos, sin * cos, cos * cos))
    functions *= cos * size * (0.5 * weight)
    lower, upper = (functions * (1.0 - part)).sum(axis=2), (functions * part).sum(axis=2)
    rows = lower[:, 1:] + upper[:, :-1]
    rows[:, 0] += lower[:, 0]
    rows[:, -1] += upper[:, -1]
    return rows
