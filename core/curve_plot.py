# SPDX-License-Identifier: GPL-3.0-or-later
"""The plot of bounce curves: light of each bounce against AO, as measured and as fitted, and its sum.

After the figures of Patapom, "Improved Ambient Occlusion": irradiance of 20 bounces (Collecting Data), their sum
(Summing the Curves) and the fits (eq. 7, 9 and 11).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import multibounce
from .bounce_curves import BounceCurves, BounceFit
from .plot import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILION, Axis, Series, draw_plot

# Bounces that are shown: the later ones lie close together.
SHOWN = {0: BLUE, 1: VERMILION, 2: GREEN, 3: ORANGE, 5: SKY_BLUE, 10: PURPLE}
MEASURED, FITTED = {"width": 3.0}, {"width": 10.0, "opacity": 0.35}


def draw_curves(curves: BounceCurves, fit: BounceFit, title: str) -> NDArray[np.float32]:
    """``curves`` and their ``fit`` as an image (960, 1280, 4), as :func:`core.plot.draw_plot` returns it."""
    last = len(curves.mean) - 1
    ao = np.linspace(0.0, 1.0, 501)
    decay = multibounce.tau(ao, fit)
    fitted = np.vstack([multibounce.f0(ao, fit), *(multibounce.f1(ao, fit) * decay**n for n in range(last))])
    shown = [
        (f"bounce {order}" if order else "direct", colour, curves.mean[order], fitted[order])
        for order, colour in SHOWN.items()
        if order <= last
    ]
    shown.append((f"sum to {last}", BLACK, curves.mean.sum(axis=0), fitted.sum(axis=0)))

    # How many points each bin has, which is its weight in the fit: on a scale of its own, to an eighth of the height.
    share = np.log1p(curves.count) / max(1.0, np.log1p(curves.count.max())) / 8.0
    series = [Series("log of points", curves.ao, share, GREY, "AREA", opacity=0.3)]
    # A bin between empty ones is no line.
    known = np.pad(curves.count > 0, 1)
    alone = known[1:-1] & ~known[:-2] & ~known[2:]
    series += [Series("", ao, form, colour, **FITTED) for _, colour, _, form in shown]
    for label, colour, mean, _ in shown:
        series.append(Series(label, curves.ao, mean, colour, **MEASURED))
        series.append(Series("", curves.ao[alone], mean[alone], colour, "DOTS", width=7.0))
    series += [Series("measured", colour=GREY, **MEASURED), Series("fitted", colour=GREY, **FITTED)]
    notes = (
        *("Fit of F0", f"factor {fit.f0_factor:.4g}", f"exponent {fit.f0_exponent:.4g}", f"rms {fit.f0_rms:.4f}", ""),
        *("Fit of F1", f"A {fit.a:.4g}", f"B {fit.b:.4g}", f"rms {fit.f1_rms:.4f}"),
    )
    return draw_plot(
        series,
        Axis("AO (alpha, uniform visibility)"),
        Axis("irradiance at albedo 1 / unoccluded irradiance", 0.0, 1.1),
        title=title,
        notes=notes,
    )
