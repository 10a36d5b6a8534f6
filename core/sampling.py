# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions over the hemisphere: one low-discrepancy pattern, turned about the normal at every point.

All points share one pattern of S directions in the frame where the normal is +z. A point differs only by a random turn
about its normal, so its rays cost one 3x3 matrix product and every weight is known before the first ray.

The pattern is a spherical Fibonacci set (Keinert et al. 2015, "Spherical Fibonacci Mapping"): azimuths step by the
golden ratio, elevations are the midpoints of S equal slices of the density below. Stratified in both, it beats Sobol
and jittered sets at equal S.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

GOLDEN_RATIO = (1.0 + 5.0**0.5) / 2.0

Density = Literal["uniform", "cosine", "mixture"]


def hemisphere_elevation(u: ArrayLike, density: Density) -> NDArray[np.float64]:
    """cos(theta) of direction ``u`` in [0, 1), by inverting the cumulative distribution of z = cos(theta).

    uniform  p(w) = 1/2pi                 z = u
    cosine   p(w) = z/pi                  z = sqrt(u), Malley's method: the disk lifted to the hemisphere
    mixture  p(w) = (1/2pi + z/pi)/2      u = (z + z^2)/2, so z = (sqrt(1 + 8u) - 1)/2
    """
    u = np.asarray(u, np.float64)
    if density == "uniform":
        return u
    if density == "cosine":
        return np.sqrt(u)
    return (np.sqrt(1.0 + 8.0 * u) - 1.0) / 2.0


def hemisphere_density(z: ArrayLike, density: Density) -> NDArray[np.float64]:
    """p(w) of :func:`hemisphere_elevation` at cos(theta) = ``z``, per steradian."""
    z = np.asarray(z, np.float64)
    uniform, cosine = np.full_like(z, 0.5 / np.pi), z / np.pi
    if density == "uniform":
        return uniform
    if density == "cosine":
        return cosine
    return 0.5 * (uniform + cosine)


@dataclass(frozen=True)
class Pattern:
    """S directions about +z, and what a visible one adds to each integral.

    directions  (S, 3) float64, unit length, z > 0
    uniform     (S,) float64, sums to 1: weights of alpha = (1/2pi) * integral of V
    cosine      (S,) float64, sums to 1: weights of k_A = (1/pi) * integral of V cos(theta)
    """

    directions: NDArray[np.float64]
    uniform: NDArray[np.float64]
    cosine: NDArray[np.float64]


def hemisphere_pattern(samples: int, density: Density = "mixture", shift: float = 0.5) -> Pattern:
    """The Fibonacci pattern of ``samples`` directions, with importance weights for alpha and k_A.

    shift  in (0, 1), where in its slice each elevation lies. Few samples need patterns of many shifts for their points:
           the error that one and the same set of elevations makes is not noise, which means would remove

    alpha wants uniform directions and k_A cosine-weighted ones, and both come from the same rays. Half of each,
    weighted by the balance heuristic (Veach 1995), keeps both weights bounded, where cosine directions alone give
    alpha an unbounded 1/cos(theta) at the horizon. ``tests/benchmarks/density.py`` measures the three.
    """
    if samples < 1:
        raise ValueError(f"samples must be at least 1, not {samples}")
    index = np.arange(samples)
    z = hemisphere_elevation((index + shift) / samples, density)
    azimuth = 2.0 * np.pi * np.mod(index / GOLDEN_RATIO, 1.0)
    radius = np.sqrt(1.0 - z * z)
    directions = np.column_stack((radius * np.cos(azimuth), radius * np.sin(azimuth), z))
    pdf = hemisphere_density(z, density)
    return Pattern(directions, _exact_weights(1.0 / pdf), _exact_weights(z / pdf))


def _exact_weights(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights scaled to sum to 1, as multiples of 2^-40.

    Sums of such numbers are exact in float64 in whatever order they are added. So an open point gets exactly 1, a
    closed one exactly 0, and threads, blocks and BLAS kernels cannot change a bit of a result.
    """
    units = np.rint(weights / weights.sum() * 2.0**40)
    units[np.argmax(units)] += 2.0**40 - units.sum()
    return units / 2.0**40


def deal(pattern: Pattern, places: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The rays of each place: directions (places, r, 3) and weights (places, r, 5), zero for rays that only fill up.

    Every place gets one of each ``places`` directions in turn. Which one moves on by two: always the same would be, for
    8 places or another Fibonacci number, one arm of the pattern's spirals. A place's rays go around its normal, so that
    one finds in the cache what the last one met.

    The weights say what a visible ray adds to F0, alpha and the mean direction's x, y, z. They are multiples of 2^-41,
    as the pattern's own are, so that the product sums them without rounding in any order. z has half of F0's weight, so
    that F0 = 2 alpha b . n, which is exact for integrals, is so for any number of samples. The pattern's directions are
    not quite balanced about the normal; taking their mean x and y from each (a control variate) makes an open point's
    bent direction its normal.
    """
    sideways = pattern.uniform @ pattern.directions[:, :2]
    bent = np.rint((pattern.directions[:, :2] - sideways) * pattern.uniform[:, None] * 2.0**40) / 2.0**40
    weights = np.column_stack((pattern.cosine, pattern.uniform, bent, 0.5 * pattern.cosine))
    count = len(weights)
    azimuth = np.arctan2(pattern.directions[:, 1], pattern.directions[:, 0])
    turn = np.arange(-(-count // places))[:, None]
    dealt = (turn * places + (np.arange(places) + 2 * turn) % places).T
    dealt = np.take_along_axis(dealt, np.argsort(azimuth[dealt % count], axis=1, kind="stable"), axis=1)
    return pattern.directions[dealt % count], np.where(dealt[..., None] < count, weights[dealt % count], 0.0)


def turns(index: ArrayLike, seed: int) -> NDArray[np.float64]:
    """A random angle in [0, 2pi) for each point ``index`` (integers), the same whoever asks for it and when.

    The PCG hash of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", once for the seed and once for the
    index.
    """
    h = _pcg_hash(np.asarray(index, np.uint64).astype(np.uint32) ^ _pcg_hash(np.array(seed & 0xFFFFFFFF, np.uint32)))
    return h.astype(np.float64) * (2.0 * np.pi / 2.0**32)


def _pcg_hash(x: NDArray[np.uint32]) -> NDArray[np.uint32]:
    """32-bit integer hash; arrays only, whose arithmetic wraps silently."""
    x = np.atleast_1d(x)
    state = x * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(277803737)
    return (word >> np.uint32(22)) ^ word


def frames(normals: NDArray, turn: NDArray) -> NDArray[np.float32]:
    """Orthonormal frames about unit ``normals`` (3, ...), turned by ``turn`` (...) radians.

    Shape (..., 3, 3), rows x, y, z = normal: ``pattern @ frame`` takes local directions to the world.
    """
    return np.ascontiguousarray(np.moveaxis(_axes(normals, turn), (0, 1), (-2, -1)))


def carried_frames(normals: NDArray, turn: NDArray) -> NDArray[np.float32]:
    """Frames (K, 3, 3, b) of b points with K places each, unit ``normals`` (3, K, b), turned by ``turn`` (b,).

    The first place's frame is carried to the others by the shortest rotation between their normals, so that directions
    dealt out among the places stay one pattern. Tangents of their own would turn against each other: no field of
    tangents on the sphere is smooth everywhere.
    """
    normals = normals.astype(np.float32)
    first, others = normals[:, :1], normals[:, 1:]
    result = np.empty((normals.shape[1], 3, *normals[:, 0].shape), np.float32)
    result[0] = _axes(first[:, 0], turn)
    if not others.size:
        return result
    cos = (first * others).sum(axis=0)
    between = (first + others) / np.maximum(1.0 + cos, np.float32(1e-3))
    for row in range(2):
        axis = result[0, row][:, None]
        result[1:, row] = np.moveaxis(axis - (axis * others).sum(axis=0) * between, 1, 0)
    result[1:, 2] = np.moveaxis(others, 1, 0)
    # There is no shortest way to the opposite side of a sheet.
    place, point = np.nonzero(cos < -0.99)
    result[1 + place, :, :, point] = frames(others[:, place, point], turn[point])
    return result


def _axes(normals: NDArray, turn: NDArray) -> NDArray[np.float32]:
    """The frames as (3 rows, 3 axes, ...). Tangents by Duff et al. 2017, "Building an Orthonormal Basis, Revisited"."""
    x, y, z = normals.astype(np.float32)
    sign = np.copysign(np.float32(1.0), z)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = (1.0 + sign * x * x * a, sign * b, -sign * x)
    bitangent = (b, sign + y * y * a, -y)
    cos, sin = np.cos(turn).astype(np.float32), np.sin(turn).astype(np.float32)
    result = np.empty((3, 3, *x.shape), np.float32)
    for axis in range(3):
        result[0, axis] = cos * tangent[axis] + sin * bitangent[axis]
        result[1, axis] = cos * bitangent[axis] - sin * tangent[axis]
        result[2, axis] = normals[axis]
    return result
