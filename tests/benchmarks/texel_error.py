# SPDX-License-Identifier: GPL-3.0-or-later
"""What the texels of a bake of 1024 x 1024 at 64 samples are off by: all over, and where islands end.

Smart UV Project makes the layout. The truth is the mean of k_A over the part of a texel that the surface covers, by two
times 2304 rays (texel_truth.py). It starts on the faces themselves, so the meshes are shaded flat.
"""

from __future__ import annotations

import bpy
import meshes
import numpy as np
from bakes import AO, by_the_extension
from report import Report
from scipy.ndimage import binary_erosion
from texel_truth import TexelTruth
from truth import rms

SAMPLES = 64


def main(report: Report, quick: bool) -> None:
    resolution, count = (256, 100) if quick else (1024, 1500)
    for name, make in ({"Suzanne": lambda: meshes.suzanne(0)} | meshes.added()).items():
        obj = make()
        obj.data.shade_flat()
        meshes.unwrap(obj)
        bpy.context.scene.multibounce_ao.margin_type = "EXTEND"
        by_the_extension(obj, SAMPLES, target="TEXTURE", resolution=resolution, margin=0)
        image = np.empty(resolution * resolution * 4, np.float32)
        bpy.data.images[f"{obj.name} {AO}"].pixels.foreach_get(image)
        image = image.reshape(resolution, resolution, 4).astype(np.float64)
        covered = image.any(axis=2)
        border = covered & ~binary_erosion(covered, np.ones((3, 3)))
        truth = TexelTruth(obj, resolution)
        worst = 0.0
        for what, among, asked in (("all texels", covered, "< .018"), ("texels at borders", border, "< .03")):
            row, column = np.nonzero(among)
            chosen = np.sort(np.random.default_rng(0).permutation(len(row))[:count])
            row, column = row[chosen], column[chosen]
            expected = truth.visibility(np.column_stack((column, row)))
            known = np.isfinite(expected).all(axis=0)
            found, expected = image[row[known], column[known], 0], expected[:, known]
            worst = max(worst, np.abs(found - expected.mean(axis=0)).max())
            report.note(f"{name}: {known.sum():,} of {among.sum():,} {what}")
            report.add(f"{name}: rms of {what}", f"{rms(found, expected):.4f}", asked)
        report.add(f"{name}: no texel off by more than", f"{worst:.3f}", ".35")
