# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from far away as nine numbers a colour channel: real spherical harmonics up to order 2.

    L(w) = sum of L_lm Y_lm(w)        Y_00, Y_1-1, Y_10, Y_11, Y_2-2, Y_2-1, Y_20, Y_21, Y_22, in this order

with the real, orthonormal basis of Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance
Environment Maps", eq. (3). The cosine lobe keeps of each band A_l = pi, 2pi/3, pi/4 (their eq. (8)), and next to
nothing of the bands above.

A band-limited light is also a polynomial of the direction, which is easier to turn and to integrate over cones:

    L(w) = mean + slope . w + w . curve w        curve symmetric and without a trace

Colour is the last axis of coefficients (9, ...), if there is one. All is float64.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Ramamoorthi and Hanrahan's 0.282095, 0.488603, 1.092548, 0.315392 and 0.546274 to all digits.
Y0 = 0.5 / np.sqrt(np.pi)
Y1 = np.sqrt(3.0) * Y0
Y2 = np.sqrt(15.0) * Y0
Y20 = 0.5 * np.sqrt(5.0) * Y0
Y22 = 0.5 * Y2

COUNT = 9
BAND = np.array((0, 1, 1, 1, 2, 2, 2, 2, 2))
"""l of each coefficient."""

COSINE_LOBE = np.array((np.pi, 2.0 * np.pi / 3.0, np.pi / 4.0))
"""A_l of max(cos, 0): what a convolution with it multiplies each band by."""


class Polynomial(NamedTuple):
    """L(w) = mean + slope . w + w . curve w, with ``mean`` (...), ``slope`` (3, ...), ``curve`` (3, 3, ...)."""

    mean: NDArray[np.float64]
    slope: NDArray[np.float64]
    curve: NDArray[np.float64]


def basis(directions: ArrayLike) -> NDArray[np.float64]:
    """The nine Y_lm (..., 9) in unit ``directions`` (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(directions, np.float64), -1, 0)
    one = np.ones_like(x)
    values = (
        *(Y0 * one, Y1 * y, Y1 * z, Y1 * x),
        *(Y2 * x * y, Y2 * y * z, Y20 * (3.0 * z * z - 1.0), Y2 * x * z, Y22 * (x * x - y * y)),
    )
    return np.stack(values, axis=-1)


def project(radiance: ArrayLike, directions: ArrayLike, weights: ArrayLike) -> NDArray[np.float64]:
    """Coefficients (9, ...) of ``radiance`` (n, ...) seen in unit ``directions`` (n, 3).

    weights  (n,) solid angles in steradians that the samples stand for; over the whole sphere they sum to 4 pi
    """
    weighted = basis(directions) * np.asarray(weights, np.float64)[:, None]
    return np.tensordot(weighted, np.asarray(radiance, np.float64), axes=(0, 0))


def equirectangular(height: int, width: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions (height, width, 3) of a panorama's pixel centres, and their solid angles (height, width).

    As Blender has it: the bottom row first and looking down -z, longitude falling from pi to -pi along a row, so that
    +x is in the middle.
    """
    edges = -np.cos(np.pi / height * np.arange(height + 1))
    latitude = np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    longitude = np.pi * (1.0 - 2.0 * (np.arange(width) + 0.5) / width)
    across, up = np.cos(latitude)[:, None], np.sin(latitude)[:, None]
    directions = np.broadcast_arrays(across * np.cos(longitude), across * np.sin(longitude), up)
    solid_angles = np.broadcast_to(np.diff(edges)[:, None] * (2.0 * np.pi / width), (height, width))
    return np.stack(directions, axis=-1), solid_angles


def project_panorama(pixels: ArrayLike) -> NDArray[np.float64]:
    """Coefficients (9, ...) of an equirectangular picture (height, width, ...), bottom row first."""
    pixels = np.asarray(pixels, np.float64)
    directions, solid_angles = equirectangular(*pixels.shape[:2])
    return project(pixels.reshape(-1, *pixels.shape[2:]), directions.reshape(-1, 3), solid_angles.ravel())


def evaluate(coefficients: ArrayLike, directions: ArrayLike) -> NDArray[np.float64]:
    """The light (..., channels) in unit ``directions`` (..., 3)."""
    return basis(directions) @ np.asarray(coefficients, np.float64)


def convolve(coefficients: ArrayLike, zonal: ArrayLike) -> NDArray[np.float64]:
    """``coefficients`` (9, ...) with each band times one of ``zonal`` (3,).

    ``zonal`` l is 2pi * integral of f(z) P_l(z) dz of a function f about an axis; then the result, evaluated at an
    axis, is the integral of L f about it (Ramamoorthi and Hanrahan's eq. (7)).
    """
    coefficients = np.asarray(coefficients, np.float64)
    factor = np.asarray(zonal, np.float64)[BAND]
    return coefficients * factor.reshape(COUNT, *(1,) * (coefficients.ndim - 1))


def irradiance(coefficients: ArrayLike, normals: ArrayLike) -> NDArray[np.float64]:
    """E/pi (..., channels) on open surfaces with unit ``normals`` (..., 3): radiance 1 all around gives 1."""
    return evaluate(convolve(coefficients, COSINE_LOBE / np.pi), normals)


def polynomial(coefficients: ArrayLike) -> Polynomial:
    """``coefficients`` (9, ...) as a polynomial of the direction."""
    c = np.asarray(coefficients, np.float64)
    slope = Y1 * np.stack((c[3], c[1], c[2]))
    xx, yy, zz = Y22 * c[8] - Y20 * c[6], -Y22 * c[8] - Y20 * c[6], 2.0 * Y20 * c[6]
    xy, yz, xz = (0.5 * Y2 * c[i] for i in (4, 5, 7))
    curve = np.stack([np.stack(row) for row in ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))])
    return Polynomial(Y0 * c[0], slope, curve)


def from_polynomial(light: Polynomial) -> NDArray[np.float64]:
    """The coefficients (9, ...) of a polynomial; the other way of :func:`polynomial`."""
    slope, curve = light.slope / Y1, light.curve
    return np.stack(
        (
            light.mean / Y0,
            *(slope[1], slope[2], slope[0]),
            *(2.0 / Y2 * curve[0, 1], 2.0 / Y2 * curve[1, 2], curve[2, 2] / (2.0 * Y20)),
            *(2.0 / Y2 * curve[0, 2], (curve[0, 0] - curve[1, 1]) / (2.0 * Y22)),
        )
    )


def rotate(coefficients: ArrayLike, rotation: ArrayLike) -> NDArray[np.float64]:
    """``coefficients`` (9, ...) of the same light turned by ``rotation`` (3, 3): L'(R w) = L(w)."""
    turn = np.asarray(rotation, np.float64)
    light = polynomial(coefficients)
    slope = np.tensordot(turn, light.slope, axes=1)
    curve = np.einsum("ai,bj,ij...->ab...", turn, turn, light.curve)
    return from_polynomial(Polynomial(light.mean, slope, curve))
