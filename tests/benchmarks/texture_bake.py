# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture bakes of 1024 x 1024 at 64 samples, against Cycles' AO bake to a float image.

Smart UV Project makes the layout, margins are equal. Embree alone, on rays that lie ready, is as fast as a bake could
ever be. rms errors are of random texels whose center is covered, against the mean of k_A over their area
(texel_truth.py).
"""

from __future__ import annotations

import meshes
import numpy as np
from bakes import AO, CYCLES, by_cycles, by_the_extension, pixels
from report import Report
from texel_truth import TexelTruth
from timing import RayClock, side_by_side
from truth import rms

SAMPLES = 64


def main(report: Report, quick: bool) -> None:
    resolution, texels = (256, 300) if quick else (1024, 3000)
    for name, make in ({"coral": lambda: meshes.coral(5 if quick else 7)} | meshes.added()).items():
        obj = make()
        meshes.unwrap(obj)
        chosen = {"target": "TEXTURE", "resolution": resolution}

        def first(obj=obj, chosen=chosen):
            meshes.nudge(obj)
            return by_the_extension(obj, SAMPLES, **chosen)

        with RayClock(keep=True) as kept:
            by_the_extension(obj, SAMPLES, **chosen)
        taken = side_by_side(
            {
                "first": first,
                "again": lambda obj=obj, chosen=chosen: by_the_extension(obj, SAMPLES, **chosen),
                "Cycles": lambda obj=obj, chosen=chosen: by_cycles(obj, SAMPLES, **chosen),
                "Embree": kept.embree_alone,
            },
            repeats=1 if quick else 3,
        )
        truth = TexelTruth(obj, resolution)
        compared = truth.covered(texels)
        expected = truth.visibility(compared)
        known = np.isfinite(expected).all(axis=0)
        expected, (column, row) = expected[:, known], compared[known].T
        errors = [rms(pixels(image)[row, column], expected) for image in (f"{obj.name} {AO}", CYCLES)]
        report.note(
            f"{name}, {len(obj.data.loop_triangles):,} triangles, {known.sum():,} texels compared: "
            f"{taken['first']:.2f} s, again {taken['again']:.2f} s, rms {errors[0]:.4f}; "
            f"Cycles {taken['Cycles']:.2f} s, rms {errors[1]:.4f}"
        )
        report.add(f"{name}: times faster than Cycles", f"{taken['Cycles'] / taken['first']:.1f}", "≥ 5")
        report.add(f"{name}: the same, baked again unchanged", f"{taken['Cycles'] / taken['again']:.1f}")
        report.add(f"{name}: the same, Embree alone on these rays", f"{taken['Cycles'] / taken['Embree']:.1f}")
        report.add(f"{name}: rms as a part of Cycles'", f"{errors[0] / errors[1]:.2f}", "≤ .80")
