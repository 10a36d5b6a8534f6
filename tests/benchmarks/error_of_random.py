# SPDX-License-Identifier: GPL-3.0-or-later
"""rms error of k_A and alpha as a part of what independent random rays have, their bias, and the worst vertex of all.

Independent rays have sqrt(k (1 - k) / S) for k_A, from cosine-weighted directions, and the same for alpha from uniform
ones. The bakes are those of the operator with several seeds. The truth (truth.py) is traced at random vertices; for the
worst one it is traced everywhere with fewer rays, then in full where the bake seems to be most off. Vertices that lie
on another face, so that rounding decides their truth, are left out and counted.
"""

from __future__ import annotations

import meshes
import numpy as np
from atrium import atrium
from bakes import AO, CONE, by_the_extension, colours
from report import Report
from truth import COARSE_STRATA, Geometry, rms

SEEDS = range(4)
ASKED = {("k_A", 64): "≤ .40", ("k_A", 256): "≤ .30", ("alpha", 64): "≤ .50", ("alpha", 256): "≤ .40"}
WORST = 256


def main(report: Report, quick: bool) -> None:
    made = {"coral": lambda: meshes.coral(4)} if quick else {"coral": meshes.coral, "atrium": atrium}
    for name, make in (made | meshes.added()).items():
        obj = make()
        geometry = Geometry.of(obj)
        for samples in (64, 256):
            bakes = []
            for seed in SEEDS:
                by_the_extension(obj, samples, seed=seed)
                bakes.append((colours(obj, AO)[:, 0], colours(obj, CONE)[:, 1]))
            if samples == 64:
                domain = obj.data.attributes[AO].domain
                points, normals = geometry.elements(domain)
                chosen = np.random.default_rng(0).permutation(geometry.used(domain))[: 300 if quick else 2000]
                is_settled = geometry.is_settled(points[chosen], normals[chosen])
                report.note(f"{name}: left out {(~is_settled).sum()} of {len(chosen)}, whose truth hangs on rounding")
                chosen = chosen[is_settled]
                truths = {
                    "k_A": geometry.visibility(points[chosen], normals[chosen], "cosine"),
                    "alpha": geometry.visibility(points[chosen], normals[chosen], "uniform"),
                }
            for (what, truth), values in zip(truths.items(), np.moveaxis(np.array(bakes), 1, 0), strict=True):
                values = values[:, chosen]
                random = np.sqrt(np.mean(truth[0] * (1.0 - truth[1])) / samples)
                error = rms(values, truth)
                report.note(f"{name}, {what} at {samples} samples: rms {error:.4f}, of random rays {random:.4f}")
                report.add(
                    f"{name}: rms of {what} at {samples}, of random", f"{error / random:.2f}", ASKED[what, samples]
                )
                bias = np.mean(values - truth.mean(axis=0))
                report.add(f"{name}: bias of {what} at {samples}", f"{bias:+.5f}", "within ± .0005")
        worst, left_out = _worst(geometry, domain, bakes[0][0])
        report.add(f"{name}: most that a vertex is off, at 256", f"{worst:.3f}", "≤ .1")
        report.add(f"{name}: vertices left out there, whose truth hangs on rounding", f"{left_out}")


def _worst(geometry: Geometry, domain: str, values: np.ndarray) -> tuple[float, int]:
    """Largest error of k_A in ``values`` (n,) of all elements of ``domain``, and how many were left out."""
    points, normals = geometry.elements(domain)
    each = geometry.used(domain)
    coarse = geometry.visibility(points[each], normals[each], strata=COARSE_STRATA).mean(axis=0)
    each = each[np.argsort(-np.abs(values[each] - coarse))[:WORST]]
    is_settled = geometry.is_settled(points[each], normals[each])
    each = each[is_settled]
    truth = geometry.visibility(points[each], normals[each], seed=1).mean(axis=0)
    return float(np.abs(values[each] - truth).max()), int((~is_settled).sum())
