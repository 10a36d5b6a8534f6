# SPDX-License-Identifier: GPL-3.0-or-later
"""What measured bounces cost: the time of a bake with them, over that of one with the published fit.

Both are whole bakes, by the operator, of an unchanged object at the same samples, in turns. Neither builds the scene
for its rays, which the bake before has left, so that the ratio is that of the work that differs.
"""

from __future__ import annotations

import meshes
from bakes import by_the_extension
from report import Report
from timing import side_by_side

TEXTURE = {"target": "TEXTURE", "resolution": 512}


def main(report: Report, quick: bool) -> None:
    cases = [(meshes.suzanne, samples, {}) for samples in (64, 256)]
    cases += [(meshes.coral, 64, {}), (meshes.coral, 256, {}), (meshes.coral, 64, TEXTURE)]
    if quick:
        cases = [(lambda: meshes.suzanne(2), 16, {}), (lambda: meshes.coral(4), 16, {**TEXTURE, "resolution": 64})]
    for make, samples, chosen in cases:
        obj = make()
        if chosen:
            meshes.unwrap(obj)
        by_the_extension(obj, samples, **chosen)  # leaves the scene for its rays

        def timed(bounces, obj=obj, samples=samples, chosen=chosen):
            return by_the_extension(obj, samples, bounces=bounces, **chosen)

        taken = side_by_side(
            {bounces: lambda bounces=bounces: timed(bounces) for bounces in ("FITTED", "BAKED")},
            repeats=1 if quick else 5,
            budget=20.0,
        )
        what = f"{obj.name.lower()}, {chosen.get('target', 'VERTEX').lower()} bake at {samples} samples"
        report.note(f"{what}: fitted {taken['FITTED']:.2f} s, measured {taken['BAKED']:.2f} s")
        report.add(f"{what}: measured over fitted", f"{taken['BAKED'] / taken['FITTED']:.2f}", "< 3")
