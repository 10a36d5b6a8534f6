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

Beside it stand curves of k_A: two comparators, and :func:`surface_curve`, which comes nearest to simulated bounces.

Everything here takes array-likes that broadcast and returns float64; inputs are clamped to [0, 1].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Coefficients of F1, eq. (11), fitted by the notes' author to 20 simulated bounces on a brick wall.
A = 27.576937094210385
B = 3.3364392003423804

# Albedo at which a bake fits the decay T: near enough to 1 that late bounces count, far enough that they are known.
TAIL_ALBEDO = 0.9
# Highest decay: below 1, which is what shaders read where a mesh has no bake.
MOST_TAIL = 1.0 - 2.0**-10


@dataclass(frozen=True)
class Coefficients:
    """F0 = alpha (1 + f0_factor (1 - alpha)^f0_exponent) and F1 = a alpha (1 - alpha)^1.5 exp(-b alpha^(1/4)), each
    with its guard; the defaults are the published ones, eq. (7) and (11)."""

    a: float = A
    b: float = B
    f0_factor: float = 0.5
    f0_exponent: float = 0.75


PUBLISHED = Coefficients()


def _unit(x: ArrayLike) -> NDArray[np.float64]:
    return np.clip(np.asarray(x, np.float64), 0.0, 1.0)


def _ratio(numerator: NDArray, denominator: NDArray) -> NDArray[np.float64]:
    """numerator / denominator, with 0/0 = 0: no light left to share out."""
    shape = np.broadcast_shapes(np.shape(numerator), np.shape(denominator))
    return np.divide(numerator, denominator, out=np.zeros(shape), where=np.greater(denominator, 0.0))


def f0(alpha: ArrayLike, fit: Coefficients = PUBLISHED) -> NDArray[np.float64]:
    """Direct irradiance factor F0 in [0, 1], eq. (7), guarded by F0 <= 1."""
    a = _unit(alpha)
    return np.clip(a * (1.0 + fit.f0_factor * (1.0 - a) ** fit.f0_exponent), 0.0, 1.0)


def f1(alpha: ArrayLike, fit: Coefficients = PUBLISHED) -> NDArray[np.float64]:
    """First-bounce factor F1 in [0, 1 - F0], eq. (11) with the fourth root of alpha, guarded by F0 + F1 <= 1."""
    a = _unit(alpha)
    closed = 1.0 - a
    # Powers of a quarter by square roots, which are faster.
    bounce = fit.a * a * closed * np.sqrt(closed) * np.exp(-fit.b * np.sqrt(np.sqrt(a)))
    return np.clip(bounce, 0.0, 1.0 - f0(a, fit))


def tau(alpha: ArrayLike, fit: Coefficients = PUBLISHED) -> NDArray[np.float64]:
    """Ratio of each bounce to the one before it, in [0, 1], eq. (9)."""
    return decay(f0(alpha, fit), f1(alpha, fit))


def decay(f0: NDArray, f1: NDArray) -> NDArray[np.float64]:
    """tau of F0 and F1, eq. (9): what lets the bounces sum to 1.

    Written as (1 - F0 - F1) / (1 - F0) with 0/0 = 0: where no light is left to bounce it stays the 0 that it comes
    from.
    """
    left = 1.0 - f0
    return _ratio(left - f1, left)


def irradiance(alpha: ArrayLike, albedo: ArrayLike, fit: Coefficients = PUBLISHED) -> NDArray[np.float64]:
    """E/E0 after all bounces, in [F0, 1], eq. (12): 1 is the unoccluded irradiance."""
    rho, direct = _unit(albedo), f0(alpha, fit)
    left = 1.0 - direct
    # rho F1 / (1 - rho tau) with eq. (9) put in, so that no 1 - tau cancels near alpha = 0 and 1.
    first = rho * f1(alpha, fit)
    return direct + left * _ratio(first, first + (1.0 - rho) * left)


def irradiance_from_bounces(
    f0: ArrayLike, f1: ArrayLike, f2: ArrayLike, tail: ArrayLike, albedo: ArrayLike
) -> NDArray[np.float64]:
    """E/E0 = F0 + rho F1 + rho^2 F2 / (1 - rho T) from the channels of a bake, in [F0, 1].

    ``f0, f1, f2`` are the direct light and two bounces at albedo 1 as fractions of E0, ``tail`` the decay T of the
    bounces after them. Whatever comes in (filtered, quantised), energy bounds it: the bounces at rho = 1 never sum past
    1. So F1 <= 1 - F0 and F2 <= 1 - F0 - F1, and up to rho = TAIL_ALBEDO, where T is fitted, the later ones are at most
    what is then left. From there on E keeps below the straight line to 1 at rho = 1, as every true E does: a sum of
    powers of rho is convex. Where T lets all bounces sum to no more than 1 the formula stands as it is.
    """
    direct, rho = _unit(f0), _unit(albedo)
    first = np.clip(np.asarray(f1, np.float64), 0.0, 1.0 - direct)
    left = 1.0 - direct - first
    second = np.clip(np.asarray(f2, np.float64), 0.0, left)
    left = left - second
    most = np.minimum(_ratio(left, second + TAIL_ALBEDO * left), MOST_TAIL)
    decay = np.clip(np.asarray(tail, np.float64), 0.0, most)

    def series(rho: float | NDArray) -> NDArray[np.float64]:
        return direct + rho * (first + rho * (second / (1.0 - rho * decay)))

    line = 1.0 - (1.0 - series(TAIL_ALBEDO)) * np.minimum((1.0 - rho) / (1.0 - TAIL_ALBEDO), 1.0)
    return np.minimum(series(rho), line)


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
    return _ratio(k, (1.0 - rho) + rho * k)  # so that nothing cancels near k_A = 0


def surface_openness(k_a: ArrayLike, area: ArrayLike = 1.0) -> float:
    """Mean k_A of what blocks the rays of a whole surface, in [0, 1], from the k_A of its points.

    Point i sends 1 - k_i of its rays to others. Light takes every way in both directions alike, A_i F_ij = A_j F_ji, so
    the others' mean is that of k_j itself, weighted by 1 - k_j and the ``area`` that the point stands for. 1 where
    nothing is blocked: nothing asks for it.
    """
    k = _unit(k_a)
    blocked = (1.0 - k) * np.asarray(area, np.float64)
    return float((k * blocked).sum() / blocked.sum()) if blocked.sum() > 0.0 else 1.0


def surface_curve(k_a: ArrayLike, openness: ArrayLike, albedo: ArrayLike) -> NDArray[np.float64]:
    """E/E0 from k_A and the surface's ``openness`` (:func:`surface_openness`), in [k_A, 1].

        E = k_A + rho (1 - k_A) E',    E' = k' / (1 - rho (1 - k')),    k' = sqrt(k_A openness)

    What blocks a point is not as bright as the point itself, as :func:`equal_neighbours` has it, but lies half-way
    between it and the surface's mean. Exact in a spherical pit, where both are alike, and with ``openness`` = k_A the
    same as :func:`equal_neighbours`. Any one function of k_A would have to be that, to be exact in every pit.
    ``tests/benchmarks/curves.py`` compares.
    """
    k, rho = _unit(k_a), _unit(albedo)
    return k + rho * (1.0 - k) * equal_neighbours(np.sqrt(k * _unit(openness)), rho)
