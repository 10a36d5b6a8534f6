# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves of each bounce against AO, as histograms of a simulation, and the published forms fitted to them.

Source: Patapom, "Improved Ambient Occlusion": points are sorted into bins by their alpha, the bins' means are the
curves (Collecting Data, step 4), and F0 and F1 are fitted to them (eq. 7 and 11).
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from . import multibounce
from .multibounce import PUBLISHED, Coefficients
from .simulation import Simulation

# Bounds of log A and of B, for curves too short to tell the two apart: exp of it is far from float64's ends.
MOST_EXPONENT = 50.0
# Least exponent of F0. At 0 the form jumps at alpha = 1, which no surface does: one that is all but open sees all but
# the whole sky. At 0.1 two fifths of the jump are spread over a hundred bins, and hardly any residual is lost.
LEAST_F0_EXPONENT = 0.1


@dataclass(frozen=True)
class BounceCurves:
    """Means of N + 1 bounces over bins of alpha.

    ao     (bins,) float64, the bins' centres
    count  (bins,) int64, points in each
    mean   (N + 1, bins) float64, F_0 to F_N at albedo 1; NaN where a bin has no point
    """

    ao: NDArray[np.float64]
    count: NDArray[np.int64]
    mean: NDArray[np.float64]


@dataclass(frozen=True)
class BounceFit(Coefficients):
    """Coefficients that fit some curves, and how well: rms residuals over the points' bins, of F0, of F1, and of tau
    against F2 / F1 (NaN for curves of one bounce).

    Errors of tau count by F1, the light that tau multiplies, so that bins without light, where F2 / F1 is any number,
    have no say: ``tau_rms`` is the rms error of F2 = tau F1, with F1 as measured, over the rms of F1.
    """

    f0_rms: float = np.nan
    f1_rms: float = np.nan
    tau_rms: float = np.nan


def bin_bounces(simulation: Simulation, bins: int = 100) -> BounceCurves:
    """Histogram of all bounces over ``bins`` equal bins of alpha in [0, 1]; alpha = 1 counts to the last.

    Raises ValueError for fewer than one bin.
    """
    if bins < 1:
        raise ValueError(f"one bin or more is needed, not {bins}")
    index = np.minimum((np.clip(simulation.alpha, 0.0, 1.0) * bins).astype(np.intp), bins - 1)
    count = np.bincount(index, minlength=bins)
    total = np.stack([np.bincount(index, weights=bounce, minlength=bins) for bounce in simulation.bounces])
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return BounceCurves((np.arange(bins) + 0.5) / bins, count, mean)


def fit_curves(curves: BounceCurves) -> BounceFit:
    """F0's factor and exponent, then A and B of F1, by least squares over the bins, weighted by their counts.

    The forms are fitted with their guards (:mod:`core.multibounce`), as they are evaluated.

    Raises ValueError for curves without F1, or with light that bounces in fewer than two bins: two unknowns need two.
    """
    from scipy.optimize import least_squares

    if len(curves.mean) < 2:
        raise ValueError("the curves hold no bounce to fit: simulate one or more")
    used = (curves.count > 0) & np.isfinite(curves.mean).all(axis=0)
    ao, weight = curves.ao[used], np.sqrt(curves.count[used] / max(1, curves.count[used].sum()))
    direct, first = curves.mean[:2, used]
    if np.count_nonzero(first > 0.0) < 2:
        raise ValueError("too little of the surface is shaded by it to fit a curve: choose one with more relief")

    def f0_residuals(unknown: NDArray) -> NDArray:
        return weight * (multibounce.f0(ao, Coefficients(f0_factor=unknown[0], f0_exponent=unknown[1])) - direct)

    start = PUBLISHED.f0_factor, PUBLISHED.f0_exponent
    f0_fit = least_squares(f0_residuals, start, bounds=((-1.0, LEAST_F0_EXPONENT), (np.inf, np.inf)))

    def with_f1(log_a: float, b: float) -> Coefficients:
        return Coefficients(float(np.exp(log_a)), float(b), *map(float, f0_fit.x))

    def f1_residuals(unknown: NDArray) -> NDArray:
        return weight * (multibounce.f1(ao, with_f1(*unknown)) - first)

    # A by its logarithm, which keeps it positive and of B's size. Without the guard it and B are on a line: the start,
    # from which the guard's flat parts are not in the way.
    lit = (first > 0.0) & (ao < 1.0)
    closed, share = 1.0 - ao[lit], weight[lit] * first[lit]
    line = np.column_stack((np.ones_like(closed), -np.sqrt(np.sqrt(ao[lit]))))
    height = np.log(first[lit] / (ao[lit] * closed * np.sqrt(closed)))
    start = np.linalg.lstsq(share[:, None] * line, share * height, rcond=None)[0]
    start = np.clip(start, -MOST_EXPONENT, MOST_EXPONENT)
    f1_fit = least_squares(f1_residuals, start, x_scale="jac", bounds=(-MOST_EXPONENT, MOST_EXPONENT))
    fit, tau_rms = with_f1(*f1_fit.x), np.nan
    if len(curves.mean) > 2:
        missed = multibounce.tau(ao, fit) * first - curves.mean[2, used]
        tau_rms = float(np.linalg.norm(weight * missed) / np.linalg.norm(weight * first))
    f0_rms, f1_rms = (float(np.sqrt(np.square(each.fun).sum())) for each in (f0_fit, f1_fit))
    return BounceFit(*astuple(fit), f0_rms, f1_rms, tau_rms)


def csv_text(curves: BounceCurves, fit: Coefficients = PUBLISHED) -> str:
    """The curves as CSV with a line a bin: ao, count, F0 to FN as measured and their sum (empty where a bin holds no
    point), then F0, F1, tau and the sum of all bounces at albedo 1 as fitted."""
    names = [f"F{order}" for order in range(len(curves.mean))]
    lines = [",".join(("ao", "count", *names, "sum", "fitted_F0", "fitted_F1", "fitted_tau", "fitted_sum"))]
    measured = np.vstack((curves.mean, curves.mean.sum(axis=0))).T
    forms = [form(curves.ao, fit) for form in (multibounce.f0, multibounce.f1, multibounce.tau)]
    fitted = np.column_stack((*forms, multibounce.irradiance(curves.ao, 1.0, fit)))
    for ao, count, means, values in zip(curves.ao, curves.count, measured, fitted, strict=True):
        cells = [f"{mean:.6f}" if count else "" for mean in means]
        lines.append(",".join((f"{ao:.6g}", str(count), *cells, *(f"{value:.6f}" for value in values))))
    return "\n".join(lines) + "\n"
