# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex bakes at 64 samples, against Cycles' AO bake to vertex colors.

Both are timed as operators, from the call to the stored attribute. Cycles traces every face corner, so it does several
times the work: that is what an artist would wait for. Embree alone, on rays that lie ready, is as fast as a bake could
ever be.
"""

from __future__ import annotations

import meshes
from atrium import atrium
from bakes import AO, CYCLES, by_cycles, by_the_extension, colours
from report import Report
from timing import RayClock, side_by_side

SAMPLES = 64


def main(report: Report, quick: bool) -> None:
    made = {"suzanne": meshes.suzanne, "coral": meshes.coral, "atrium": atrium}
    if quick:
        made = {"suzanne": lambda: meshes.suzanne(2)}
    for name, make in (made | meshes.added()).items():
        obj = make()

        def first(obj=obj):
            meshes.nudge(obj)
            return by_the_extension(obj, SAMPLES)

        with RayClock(keep=True) as kept:
            by_the_extension(obj, SAMPLES)
        taken = side_by_side(
            {
                "first": first,
                "again": lambda obj=obj: by_the_extension(obj, SAMPLES),
                "Cycles": lambda obj=obj: by_cycles(obj, SAMPLES),
                "Embree": kept.embree_alone,
            },
            repeats=1 if quick else 5,
        )
        means = [colours(obj, attribute)[:, 0].mean() for attribute in (AO, CYCLES)]
        vertices = len(obj.data.vertices)
        report.note(
            f"{name}, {vertices:,} vertices: {taken['first']:.2f} s, again {taken['again']:.2f} s "
            f"({vertices * SAMPLES / taken['first'] / 1e6:.1f} million vertex rays a second), "
            f"Cycles {taken['Cycles']:.2f} s; mean F0 {means[0]:.4f} and {means[1]:.4f}"
        )
        asked = "≥ 20" if name in {"bunny", "sponza"} else "≥ 12"
        report.add(f"{name}: times faster than Cycles", f"{taken['Cycles'] / taken['first']:.1f}", asked)
        report.add(f"{name}: the same, baked again unchanged", f"{taken['Cycles'] / taken['again']:.1f}")
        report.add(f"{name}: the same, Embree alone on these rays", f"{taken['Cycles'] / taken['Embree']:.1f}")
