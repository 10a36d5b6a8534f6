# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions of the distance that fit what was measured along each direction, all directions at once.

scipy.optimize solves one problem a call; thousands of three or four unknowns each want one solver that moves all of
them a step at a time, the Levenberg-Marquardt method (Marquardt 1963) on stacked small systems.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

STEPS = 15
# No solid angle is fitted larger than the whole sphere, so there is no pole.
MOST = 4.0 * np.pi
# Less than this counts as this: where rays meet nothing, a function that is next to nothing.
LEAST = 1e-4
# Parts of the way from r0 to r_min from where on a denominator rises that else would not be positive.
RETREATS = (0.25, 0.5, 0.75, 1.0)
# Less of d than this part of a changes nothing, and zeros make small files.
LEAST_D = 1e-3
# C0 lies nearer than this part of r0 along omega.
FURTHEST = 0.95
# Bounds of the exponent e: at most as fast as lines of sight to C0, and not so fast that lookups between texels jump.
LEAST_E, MOST_E = 1.0, 12.0
# A fit from another start replaces one whose cost is not lower by more than this part: rounding chooses nothing.
CLEARLY = 0.99


def levenberg_marquardt(
    residuals: Callable[[NDArray], tuple[NDArray, NDArray]], start: NDArray[np.float64], steps: int = STEPS
) -> NDArray[np.float64]:
    """Unknowns (k, u) that make the sum of squared residuals least, for k problems at once, from ``start`` (k, u).

    residuals  of unknowns (k, u): the residuals (k, N) and their derivatives (k, N, u). Where they are not finite, a
               step is not taken
    """
    x = start.copy()
    e, J = residuals(x)
    cost = np.square(e).sum(axis=1)
    damping = np.full(len(x), 1e-3)
    for _ in range(steps):
        transposed = J.swapaxes(1, 2)
        H = transposed @ J
        g = transposed @ e[..., None]
        # Marquardt's scaling, by the diagonal; the floor keeps systems regular where an unknown has no say.
        diagonal = np.maximum(np.einsum("kii->ki", H), 1e-12 * np.einsum("kii->k", H)[:, None] + 1e-300)
        damped = H + np.einsum("k,ki,ij->kij", damping, diagonal, np.eye(x.shape[1]))
        tried = x - np.linalg.solve(damped, g)[..., 0]
        e_tried, J_tried = residuals(tried)
        cost_tried = np.square(e_tried).sum(axis=1)
        better = cost_tried < cost  # False where it is not a number
        x[better], e[better], J[better], cost[better] = (each[better] for each in (tried, e_tried, J_tried, cost_tried))
        damping = np.clip(np.where(better, damping / 5.0, damping * 4.0), 1e-12, 1e12)
    return x


def _best_of(
    residuals: Callable[[NDArray], tuple[NDArray, NDArray]], starts: Iterable[NDArray[np.float64]]
) -> NDArray[np.float64]:
    """Of :func:`levenberg_marquardt` from several ``starts`` (k, u), each problem's best (k, u)."""
    best, least = None, None
    for start in starts:
        found = levenberg_marquardt(residuals, start)
        cost = np.square(residuals(found)[0]).sum(axis=1)
        if best is None:
            best, least = found, cost
            continue
        better = cost < CLEARLY * least
        best[better], least[better] = found[better], cost[better]
    return best


def fit_solid_angle(
    r: NDArray[np.float64],
    Omega: NDArray[np.float64],
    weight: NDArray[np.float64],
    r0: NDArray[np.float64],
    r_min: NDArray[np.float64],
    d: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """a, b, c, d (4, k) of 1 / (a r^2 + b r + c + d r sqrt(r^2 - r0^2)) for ``Omega`` (k, N) at distances ``r`` (k, N)
    of ``r0`` (k,) or more: the least sum of ``weight`` (k, N) times error squared (the notes' epsilon_Omega).

    The notes have no d. With it, d >= 0, a sphere is met: 1 / 2pi (1 - sqrt(1 - (R/r)^2)) is
    (r^2 + r sqrt(r^2 - R^2)) / 2pi R^2. A given ``d`` (k,) stays, and the others are fitted.

    The denominator rises from r0 on, from 1/MOST or more, and is at least a quarter of that from ``r_min`` (k,) on, the
    least r0 of the texels around: no lookup between texels finds a pole.
    """
    found = _rising(r, Omega, weight, r0, r0, d)
    for part in RETREATS:
        a, b, c, _ = found
        # Least between r_min and r0: at an end, or at the parabola's vertex between them.
        lowest = np.clip(-b / (2.0 * a), r_min, r0)
        least = np.minimum((a * r_min + b) * r_min + c, (a * lowest + b) * lowest + c)
        low = np.flatnonzero(least < 0.25 / MOST)
        if len(low):
            base = r0[low] - part * (r0[low] - r_min[low])
            d_low = None if d is None else d[low]
            found[:, low] = _rising(r[low], Omega[low], weight[low], r0[low], base, d_low)
    return found


def _rising(
    r: NDArray, Omega: NDArray, weight: NDArray, r0: NDArray, base: NDArray, d: NDArray | None
) -> NDArray[np.float64]:
    """:func:`fit_solid_angle` whose a, b, c alone rise from 1/MOST or more at ``base`` (k,) on: with t = r / base - 1
    they are q t^2 + s t + v, where q = e^x0, s = e^x1 and v = 1/MOST + e^x2; d base^2 = e^x3."""
    t = r / base[:, None] - 1.0
    Omega = np.maximum(Omega, LEAST)
    root = np.sqrt(weight)
    powers = np.stack((t * t, t, np.ones_like(t)), axis=-1)
    graze = r * np.sqrt(r * r - (r0 * r0)[:, None]) / (base * base)[:, None]
    known = 1.0 / MOST if d is None else 1.0 / MOST + (d * base * base)[:, None] * graze

    # Start: a linear fit of the denominator, whose error is that of Omega over Omega^2.
    linear = (root * Omega**2)[..., None] * powers
    normal = np.einsum("kni,knj->kij", linear, linear)
    right = np.einsum("kni,kn->ki", linear, root * Omega**2 * (1.0 / Omega - known))
    ridge = 1e-9 * np.einsum("kii->k", normal)[:, None, None] * np.eye(3)
    coefficients = np.linalg.solve(normal + ridge, right[..., None])[..., 0]
    # What must be positive and is not starts small: the solid angle's fall far away is the measure.
    small = 1e-3 / (Omega * np.square(t + 1.0)).max(axis=1)
    starts = [np.log(np.maximum(coefficients, small[:, None]))]
    if d is None:
        # One start without the square root, one where it has half of the growth far away.
        q, s, v = starts[0].T
        halves = np.column_stack((q + np.log(0.5), s, v, q + np.log(0.5)))
        starts = [np.column_stack((starts[0], q + np.log(1e-3))), halves]
        powers = np.concatenate((powers, graze[..., None]), axis=-1)

    def residuals(x: NDArray) -> tuple[NDArray, NDArray]:
        parts = _positive(x)
        value = 1.0 / (np.einsum("kni,ki->kn", powers, parts) + known)
        return root * (value - Omega), (-root * value * value)[..., None] * powers * parts[:, None]

    q, s, v, *square_root = _positive(_best_of(residuals, starts)).T
    # So much that float32 still knows that it rises.
    q = np.maximum(q, 1e-9)
    s = np.maximum(s, 1e-6 * q)
    a, b = q / base**2, s / base
    if d is None:
        d = square_root[0] / base**2
        d = np.where(d < LEAST_D * a, 0.0, d)
    return np.stack((a, b - 2.0 * a * base, v + 1.0 / MOST - s + q, d))


def _positive(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """e^x up to 3000, next to which float32 still resolves 1/MOST; solid angles of less than 1/3000 are nothing."""
    return np.exp(np.clip(x, -30.0, 8.0))


def fit_direction(
    r: NDArray[np.float64],
    Upsilon: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    r0: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """C0 (k, 3) and e (k,) of normalize((r0 / r)^e C0 - r0 omega) for unit ``Upsilon`` (k, N, 3) at distances ``r``
    (k, N) along unit ``omega`` (k, 3): the least sum of ``weight`` (k, N) times 1 - cos of the error, half |error|^2.

    (The notes square that once more, which would leave small errors without a say. They have no e: with e = 1 these are
    their lines of sight to C0, normalize(C0 - r omega).) C0 stays nearer than ``r0`` (k,) along omega, so that no
    receiver outside the hull has passed it.
    """
    x = r[..., None] * omega[:, None]
    # Start: the point next to all the lines of sight. A slight pull to the centre, for lines that are all one.
    across = weight[..., None, None] * (np.eye(3) - Upsilon[..., :, None] * Upsilon[..., None, :])
    pull = (1e-4 * weight.sum(axis=1) + 1e-12)[:, None, None] * np.eye(3)
    right = np.einsum("knij,knj->ki", across, x)
    start = np.linalg.solve(across.sum(axis=1) + pull, right[..., None])[..., 0]
    root = np.sqrt(weight)[..., None]
    # The same slight pull, for the solver; and one of e to 1.
    weak = np.column_stack((*3 * (1e-2 / r0,), np.full_like(r0, 1e-2)))
    nearness = np.log(r0[:, None] / r)

    def residuals(unknown: NDArray) -> tuple[NDArray, NDArray]:
        """Of C0 and the logarithm of e (k, 4), or of C0 alone (k, 3), e = 1."""
        count = unknown.shape[1]
        e = _exponent(unknown[:, 3:]) if count == 4 else 1.0
        near = np.exp(e * nearness)[..., None]
        from_centre = near * unknown[:, None, :3]
        towards = from_centre - (r0[:, None] * omega)[:, None]
        size = np.linalg.norm(towards, axis=-1, keepdims=True)
        unit = towards / size
        turning = (root / size)[..., None] * (np.eye(3) - unit[..., :, None] * unit[..., None, :])
        slope = near[..., None] * turning
        if count == 4:
            by_e = turning @ ((e * nearness)[..., None] * from_centre)[..., None]
            slope = np.concatenate((slope, by_e), axis=-1)
        error = np.concatenate(((root * (unit - Upsilon)).reshape(len(r0), -1), weak[:, :count] * unknown), axis=1)
        kept = weak[:, :count, None] * np.eye(count)
        return error, np.concatenate((slope.reshape(len(r0), -1, count), kept), axis=1)

    C0 = _before(levenberg_marquardt(residuals, _before(start, omega, r0)), omega, r0)
    found = _best_of(residuals, (np.column_stack((C0, np.full_like(r0, log_e))) for log_e in (0.0, 1.2)))
    return _before(found[:, :3], omega, r0), _exponent(found[:, 3])


def _exponent(log_e: NDArray[np.float64]) -> NDArray[np.float64]:
    """e, at most as large as it may be."""
    return np.exp(np.clip(log_e, np.log(LEAST_E), np.log(MOST_E)))


def _before(C0: NDArray, omega: NDArray, r0: NDArray) -> NDArray[np.float64]:
    """``C0`` (k, 3) moved back along ``omega`` where it is not nearer than FURTHEST of ``r0``."""
    too_far = np.maximum(np.einsum("ki,ki->k", C0, omega) - FURTHEST * r0, 0.0)
    return C0 - too_far[:, None] * omega
