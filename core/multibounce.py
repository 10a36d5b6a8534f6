# SPDX-License-Identifier: GPL-3.0-or-later
"""The published multi-bounce fit: from one ambient-occlusion value to the light of all bounces.

Source: Patapom, "Improved Ambient Occlusion" (study notes), equations (7) to (12). For a Lambertian surface of albedo
rho under uniform light the irradiance, as a fraction of the unoccluded irradiance E0, is

    E / E0 = F0(alpha) + rho F1(alpha) + rho^2 F2(alpha) + ...                                        eq. (8)

with F2 = tau F1, F3 = tau F2, ..., a geometric series. ``alpha`` is the *uniform* visibility (1/2pi) * integral of V,
not the cosine-weighted k_A that most programs bake as AO: k_A is what F0 predicts.

As printed the fit breaks down on nearly open surfaces: F0 passes 1 at alpha = 0.949, so that tau = 1 - F1/(1 - F0) runs
to minus, then plus infinity, and rho*tau crosses 1. Energy gives the guard: at rho = 1 all bounces sum to 1, so what is
not direct is at most 1 - F0. With F0 <= 1 and F1 <= 1 - F0 the result is continuous, rises with albedo, stays in
[F0, 1], and is untouched where the printed tau is positive (alpha < 0.765).

Everything here takes array-likes that broadcast and returns float64; inputs are clamped to [0, 1].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Coefficients of F1, eq. (11), fitted by the notes' author to 20 simulated bounces on a brick wall.
A = 27.576937094210385
B = 3.3364392003423804


def _unit(x: ArrayLike) -> NDArray[np.float64]:
    return np.clip(np.asarray(x, np.float64), 0.0, 1.0)


def _ratio(numerator: NDArray, denominator: NDArray) -> NDArray[np.float64]:
    """numerator / denominator, with 0/0 = 0: no light left to share out."""
    shape = np.broadcast_shapes(np.shape(numerator), np.shape(denominator))
    return np.divide(numerator, denominator, out=np.zeros(shape), where=np.greater(denominator, 0.0))


def f0(alpha: ArrayLike) -> NDArray[np.float64]:
    """Direct irradiance factor F0 in [0, 1], eq. (7), guarded by F0 <= 1."""
    a = _unit(alpha)
    root = np.sqrt(1.0 - a)  # powers of a quarter by square roots, which are faster
    return np.minimum(a * (1.0 + 0.5 * root * np.sqrt(root)), 1.0)


def f1(alpha: ArrayLike) -> NDArray[np.float64]:
    """First-bounce factor F1 in [0, 1 - F0], eq. (11) with the fourth root of alpha, guarded by F0 + F1 <= 1."""
    a = _unit(alpha)
    closed = 1.0 - a
    return np.minimum(A * a * closed * np.sqrt(closed) * np.exp(-B * np.sqrt(np.sqrt(a))), 1.0 - f0(a))


def tau(alpha: ArrayLike) -> NDArray[np.float64]:
    """Ratio of each bounce to the one before it, in [0, 1], eq. (9)."""
    return decay(f0(alpha), f1(alpha))


def decay(f0: NDArray, f1: NDArray) -> NDArray[np.float64]:
    """tau of F0 and F1, eq. (9): what lets the bounces sum to 1.

    Written as (1 - F0 - F1) / (1 - F0) with 0/0 = 0: where no light is left to bounce it stays the 0 that it comes
    from.
    """
    left = 1.0 - f0
    return _ratio(left - f1, left)


def irradiance(alpha: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """E/E0 after all bounces, in [F0, 1], eq. (12): 1 is the unoccluded irradiance."""
    rho, left = _unit(albedo), 1.0 - f0(alpha)
    # rho F1 / (1 - rho tau) with eq. (9) put in, so that no 1 - tau cancels near alpha = 0 and 1.
    first = rho * f1(alpha)
    return f0(alpha) + left * _ratio(first, first + (1.0 - rho) * left)


def irradiance_from_bounces(
    f0: ArrayLike, f1: ArrayLike, f2: ArrayLike, tail: ArrayLike, albedo: ArrayLike
) -> NDArray[np.float64]:
    """E/E0 = F0 + rho F1 + rho^2 F2 / (1 - rho T) from the channels of a bake, in [F0, 1].

    ``f0, f1, f2`` are the direct light and two bounces at albedo 1 as fractions of E0, ``tail`` the decay T of the
    bounces after them. Whatever comes in (filtered, quantised), energy bounds it: the bounces at rho = 1 never sum
    past 1, which asks F1 <= 1 - F0, F2 <= 1 - F0 - F1 and T <= 1 - F2 / (1 - F0 - F1).
    """
    direct, rho = _unit(f0), _unit(albedo)
    first = np.clip(np.asarray(f1, np.float64), 0.0, 1.0 - direct)
    left = 1.0 - direct - first
    second = np.clip(np.asarray(f2, np.float64), 0.0, left)
    decay = np.clip(np.asarray(tail, np.float64), 0.0, 1.0 - _ratio(second, left))
    return direct + rho * first + rho**2 * _ratio(second, 1.0 - rho * decay)


def jimenez_2016(k_a: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """E/E0 from the cosine-weighted k_A by a cubic, never below k_A; a comparator.

    Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", the GTAO multi-bounce fit.
    """
    k, rho = _unit(k_a), _unit(albedo)
    a = 2.0404 * rho - 0.3324
    b = -4.7951 * rho + 0.6417
    c = 2.7552 * rho + 0.6903
    return np.maximum(k, ((k * a + b) * k + c) * k)


def equal_neighbours(k_a: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """E/E0 = k_A / (1 - rho (1 - k_A)): every occluder is as bright as the point itself; exact in a spherical pit.

    Akenine-Moller et al., "Real-Time Rendering", 4th ed., section 11.3.3 (after Stewart and Langer 1997); a comparator.
    """
    k, rho = _unit(k_a), _unit(albedo)
    return _ratio(k, 1.0 - rho * (1.0 - k))
