# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions of the distance that fit what was measured along each direction, all directions at once.

scipy.optimize solves one problem a call; thousands of three unknowns each want one solver that moves all of them a step
at a time, the Levenberg-Marquardt method (Marquardt 1963) on stacked 3 x 3 systems.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

STEPS = 15
# No solid angle is fitted larger than the whole sphere, so there is no pole.
MOST = 4.0 * np.pi
# Less than this counts as this: where rays meet nothing, a function that is next to nothing.
LEAST = 1e-4
# Parts of the way from r0 to r_min from where on a denominator rises that else would not be positive.
RETREATS = (0.25, 0.5, 0.75, 1.0)
# C0 lies nearer than this part of r0 along omega.
FURTHEST = 0.95


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


def fit_solid_angle(
    r: NDArray[np.float64],
    Omega: NDArray[np.float64],
    weight: NDArray[np.float64],
    r0: NDArray[np.float64],
    r_min: NDArray[np.float64],
) -> NDArray[np.float64]:
    """a, b, c (3, k) of 1 / (a r^2 + b r + c) for ``Omega`` (k, N) at distances ``r`` (k, N): the least sum of
    ``weight`` (k, N) times error squared (the notes' epsilon_Omega).

    The denominator rises from ``r0`` (k,) on, from 1/MOST or more, and is at least a quarter of that from ``r_min``
    (k,) on, the least r0 of the texels around: no lookup between texels finds a pole.
    """
    found = _rising(r, Omega, weight, r0)
    for part in RETREATS:
        a, b, c = found
        # Least between r_min and r0: at an end, or at the parabola's vertex between them.
        lowest = np.clip(-b / (2.0 * a), r_min, r0)
        least = np.minimum((a * r_min + b) * r_min + c, (a * lowest + b) * lowest + c)
        low = np.flatnonzero(least < 0.25 / MOST)
        if len(low):
            base = r0[low] - part * (r0[low] - r_min[low])
            found[:, low] = _rising(r[low], Omega[low], weight[low], base)
    return found


def _rising(r: NDArray, Omega: NDArray, weight: NDArray, r_min: NDArray) -> NDArray[np.float64]:
    """:func:`fit_solid_angle` with the denominator rising from 1/MOST or more at ``r_min`` (k,) on: with
    d = r / r_min - 1 it is q d^2 + s d + v, where q = e^x0, s = e^x1 and v = 1/MOST + e^x2."""
    d = r / r_min[:, None] - 1.0
    Omega = np.maximum(Omega, LEAST)
    root = np.sqrt(weight)
    powers = np.stack((d * d, d, np.ones_like(d)), axis=-1)

    # Start: a linear fit of the denominator, whose error is that of Omega over Omega^2.
    linear = (root * Omega**2)[..., None] * powers
    normal = np.einsum("kni,knj->kij", linear, linear)
    right = np.einsum("kni,kn->ki", linear, root * Omega)
    ridge = 1e-9 * np.einsum("kii->k", normal)[:, None, None] * np.eye(3)
    coefficients = np.linalg.solve(normal + ridge, right[..., None])[..., 0] - (0.0, 0.0, 1.0 / MOST)
    # What must be positive and is not starts small: the solid angle's fall far away is the measure.
    small = 1e-3 / (Omega * np.square(d + 1.0)).max(axis=1)
    start = np.log(np.maximum(coefficients, small[:, None]))

    def residuals(x: NDArray) -> tuple[NDArray, NDArray]:
        q, s, v = _positive(x).T[:, :, None]
        value = 1.0 / ((q * d + s) * d + v + 1.0 / MOST)
        slope = (-root * value * value)[..., None] * powers * np.stack((q, s, v), axis=-1)
        return root * (value - Omega), slope

    q, s, v = _positive(levenberg_marquardt(residuals, start)).T
    # So much that float32 still knows that it rises.
    q = np.maximum(q, 1e-9)
    s = np.maximum(s, 1e-6 * q)
    a, b = q / r_min**2, s / r_min
    return np.stack((a, b - 2.0 * a * r_min, v + 1.0 / MOST - s + q))


def _positive(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """e^x up to 3000, next to which float32 still resolves 1/MOST; solid angles of less than 1/3000 are nothing."""
    return np.exp(np.clip(x, -30.0, 8.0))


def fit_direction(
    r: NDArray[np.float64],
    Upsilon: NDArray[np.float64],
    weight: NDArray[np.float64],
    omega: NDArray[np.float64],
    r0: NDArray[np.float64],
) -> NDArray[np.float64]:
    """C0 (k, 3) of normalize(C0 - r omega) for unit ``Upsilon`` (k, N, 3) at distances ``r`` (k, N) along unit
    ``omega`` (k, 3): the least sum of ``weight`` (k, N) times 1 - cos of the error, half |error|^2.

    (The notes square that once more, which would leave small errors without a say.) C0 stays nearer than ``r0`` (k,)
    along omega, so that no receiver outside the hull has passed it.
    """
    x = r[..., None] * omega[:, None]
    # Start: the point next to all the lines of sight. A slight pull to the centre, for lines that are all one.
    across = weight[..., None, None] * (np.eye(3) - Upsilon[..., :, None] * Upsilon[..., None, :])
    pull = (1e-4 * weight.sum(axis=1) + 1e-12)[:, None, None] * np.eye(3)
    right = np.einsum("knij,knj->ki", across, x)
    start = np.linalg.solve(across.sum(axis=1) + pull, right[..., None])[..., 0]
    root = np.sqrt(weight)[..., None]
    # The same slight pull, for the solver.
    far = 1e2 * r0[:, None]

    def residuals(C0: NDArray) -> tuple[NDArray, NDArray]:
        towards = C0[:, None] - x
        length = np.linalg.norm(towards, axis=-1, keepdims=True)
        unit = towards / length
        slope = (root / length)[..., None] * (np.eye(3) - unit[..., :, None] * unit[..., None, :])
        e = np.concatenate(((root * (unit - Upsilon)).reshape(len(C0), -1), C0 / far), axis=1)
        kept = np.broadcast_to(np.eye(3) / far[..., None], (len(C0), 3, 3))
        return e, np.concatenate((slope.reshape(len(C0), -1, 3), kept), axis=1)

    start = _before(start, omega, r0)
    return _before(levenberg_marquardt(residuals, start), omega, r0)


def _before(C0: NDArray, omega: NDArray, r0: NDArray) -> NDArray[np.float64]:
    """``C0`` (k, 3) moved back along ``omega`` where it is not nearer than FURTHEST of ``r0``."""
    too_far = np.maximum(np.einsum("ki,ki->k", C0, omega) - FURTHEST * r0, 0.0)
    return C0 - too_far[:, None] * omega
