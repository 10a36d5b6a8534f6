# SPDX-License-Identifier: GPL-3.0-or-later
"""The World's light at a point, from its bent cone: four baked numbers instead of rays.

A bake knows of what a point sees its solid angle 2pi alpha and its mean direction b. Their product m = alpha b is the
first moment, (1/2pi) * integral of V w, so that direct light under a white sky is known exactly, whatever is seen:

    F0 = (1/pi) * integral of V (n . w) dw = 2 n . m

For other light V itself is wanted. It is taken to be the cone of that solid angle about m, c = 1 - alpha, and its light
(:mod:`.clipped_cone`) is scaled so that a white sky gives F0: E_seen = 2 |m| E/S_1. That is good in pits. Under a slab,
which leaves a band along the horizon, it is bad: there what is *hidden* is the cone, of solid angle 2pi (1 - alpha) and
with the moment n/2 - m, and E_hidden = E_open - (light of the hidden cone) is good. Both give F0 under a white sky.

How well a set of directions is a cone shows in its moments. Of all sets of its solid angle the cone has the longest
mean, 1 - alpha/2, so that

    t = alpha / (2 (1 - |b|)) <= 1, with t = 1 for cones only

Cones miss more where t is low, and the more light there is in them. So the two are mixed by the weights

    seen : hidden = (1 - alpha) t_seen^2 : alpha t_hidden^2

which leave the open point's light plain, the closed point's 0, and a cone's as it is while it is narrow. The powers are
a choice; ``tests/core/test_bent_cone_truth.py`` measures how near the result comes to traced light.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .clipped_cone import mean_light
from .spherical_harmonics import Y0, irradiance

# Where a point sees less than about this much, its light is taken to be that of an open one: what it sees is not known.
LEAST_F0 = 1e-4
# Least light of an open surface to compare with, as a fraction of the World's mean: nine numbers may leave less than
# none on the side away from a lamp.
LEAST_OPEN = 0.05


class SkyLight(NamedTuple):
    """Light of the sky at n points, (n, channels) each, 1 for radiance 1 all around.

    irradiance  E/pi through the bent cone: F0 under a white sky
    sky         mean radiance of the sky that a point sees, weighted by the cosine: irradiance / F0, 1 under a white sky
    relative    sky over the light E/pi of an open surface with the same normal
    """

    irradiance: NDArray[np.float64]
    sky: NDArray[np.float64]
    relative: NDArray[np.float64]


def sky_light(coefficients: ArrayLike, bent: ArrayLike, alpha: ArrayLike, normals: ArrayLike) -> SkyLight:
    """Light of ``coefficients`` (9, channels) at n points.

    bent     (n, 3) mean visible directions b, in the axes of the light; 0 stands for one along the normal
    alpha    (n,) uniform visibility in [0, 1]
    normals  (n, 3) unit normals
    """
    normals, alpha = np.asarray(normals, np.float64), np.clip(np.asarray(alpha, np.float64), 0.0, 1.0)
    bent = np.asarray(bent, np.float64)
    bent = np.where(np.any(bent != 0.0, axis=-1, keepdims=True), bent, 0.5 * normals)
    moment = alpha[:, None] * bent
    seen, fit_of_seen = _cone_light(coefficients, moment, alpha, normals)
    hidden, fit_of_hidden = _cone_light(coefficients, 0.5 * normals - moment, 1.0 - alpha, normals)
    weight, other = (1.0 - alpha) * fit_of_seen**2, alpha * fit_of_hidden**2
    weight = _ratio(weight, weight + other)[:, None]
    opened = irradiance(coefficients, normals)
    light = np.maximum(weight * seen + (1.0 - weight) * (opened - hidden), 0.0)
    f0 = np.maximum(2.0 * (normals * moment).sum(axis=-1), 0.0)[:, None]
    opened = np.maximum(opened, 0.0)
    sky = (light + LEAST_F0 * opened) / (f0 + LEAST_F0)
    mean = Y0 * np.asarray(coefficients, np.float64)[0]
    return SkyLight(light, sky, _ratio(sky, np.maximum(opened, LEAST_OPEN * mean)))


def _cone_light(
    coefficients: ArrayLike, moment: NDArray, alpha: NDArray, normals: NDArray
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """E/pi (n, channels) through the cones of moments (n, 3) and solid angles 2pi ``alpha`` (n,), and their t (n,)."""
    length = np.sqrt(np.square(moment).sum(axis=-1))
    axes = _ratio(moment, length[:, None])
    fit = _ratio(alpha * alpha, np.maximum(2.0 * (alpha - length), alpha * alpha))
    return 2.0 * length[:, None] * mean_light(coefficients, normals, axes, 1.0 - alpha), fit


def _ratio(numerator: NDArray, denominator: NDArray) -> NDArray[np.float64]:
    """numerator / denominator, 0 where the denominator is 0: as shader nodes have it."""
    shape = np.broadcast_shapes(np.shape(numerator), np.shape(denominator))
    return np.divide(numerator, denominator, out=np.zeros(shape), where=np.not_equal(denominator, 0.0))
