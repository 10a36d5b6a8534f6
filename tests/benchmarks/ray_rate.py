# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays a second inside a bake against Embree alone on the very same rays, and how much of a bake is not tracing.

Embree alone gets the rays of a bake as they were, in the same blocks and on as many threads: no directions are made,
nothing is summed.
"""

from __future__ import annotations

import statistics

import meshes
from atrium import atrium
from bakes import by_the_extension
from report import Report
from timing import RayClock, side_by_side

SAMPLES = 64


def main(report: Report, quick: bool) -> None:
    made = {"coral": lambda: meshes.coral(5)} if quick else {"coral": meshes.coral, "atrium": atrium}
    for name, make in (made | meshes.added()).items():
        obj = make()
        _rate(report, name, obj, 1 if quick else 5)
        shares = [("vertex bake at 256 samples", "≤ 15 %", 256, {})]
        if name != "atrium":  # whose thousands of separate faces leave most of an image empty
            meshes.unwrap(obj)
            resolution = 256 if quick else 1024
            shares.append(("texture bake at 16 samples", "≤ 30 %", 16, {"target": "TEXTURE", "resolution": resolution}))
        for what, asked, samples, chosen in shares:
            first, again = _other_shares(obj, samples, chosen, 1 if quick else 3)
            report.add(f"{name}: not tracing, {what}", f"{100 * first:.0f} %", asked)
            report.add(f"{name}: the same, baked again unchanged", f"{100 * again:.0f} %")


def _rate(report: Report, name: str, obj, repeats: int) -> None:
    with RayClock(keep=True) as kept:
        by_the_extension(obj, SAMPLES)

    def bake() -> float:
        with RayClock() as clock:
            by_the_extension(obj, SAMPLES)
        return clock.seconds

    taken = side_by_side({"bake": bake, "Embree": kept.embree_alone}, repeats)
    rates = {key: kept.rays / each / 1e6 for key, each in taken.items()}
    report.note(f"{name}: {rates['bake']:.1f} million rays a second in the bake, {rates['Embree']:.1f} in Embree alone")
    report.add(f"{name}: rays a second, of Embree alone", f"{rates['bake'] / rates['Embree']:.2f}", "≥ .85")


def _other_shares(obj, samples: int, chosen: dict, repeats: int) -> tuple[float, float]:
    """What part of a first bake and of the same again passes without rays in flight: medians."""
    shares: tuple[list[float], list[float]] = [], []
    for _ in range(repeats):
        meshes.nudge(obj)
        for share in shares:
            with RayClock() as clock:
                whole = by_the_extension(obj, samples, **chosen)
            share.append(1.0 - clock.seconds / whole)
    return statistics.median(shares[0]), statistics.median(shares[1])
