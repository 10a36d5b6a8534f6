# SPDX-License-Identifier: GPL-3.0-or-later
"""Tracing time against the number of triangles, of points and of threads.

The shape is a wavy torus whatever its triangles, baked to a texture that its UVs fill, so that points and samples stay
equal. Tracing time is without the scene's build, which the second bake of an unchanged scene does not need either.
"""

from __future__ import annotations

import statistics

import meshes
import numpy as np
from bakes import AO, CONE, by_the_extension, colours
from report import Plot, Report
from timing import RayClock, side_by_side

SAMPLES = 64
TRIANGLES = (10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000)
RESOLUTIONS = (128, 256, 512, 1024)


def main(report: Report, quick: bool) -> None:
    repeats = 1 if quick else 3
    counts, tracing, whole = [], [], []
    for triangles in TRIANGLES[: 3 if quick else None]:
        obj = meshes.torus(triangles)
        counts.append(2 * len(obj.data.polygons))
        for values, value in zip((whole, tracing), _texture(obj, 256, repeats), strict=True):
            values.append(value)
        report.note(f"{counts[-1]:9,} triangles: tracing {tracing[-1]:.2f} s, the first bake {whole[-1]:.2f} s")
    if not quick:
        growth = tracing[TRIANGLES.index(1_000_000)] / tracing[TRIANGLES.index(100_000)]
        report.add("tracing time, 10^6 triangles over 10^5", f"{growth:.2f}", "≤ 1.6")
    report.add(f"tracing time, {counts[-1]:,} triangles over {counts[0]:,}", f"{tracing[-1] / tracing[0]:.2f}")
    report.plot(
        Plot(
            "scaling",
            f"a torus, {256 * 256:,} points, {SAMPLES} samples",
            "triangles",
            "seconds",
            [("tracing", counts, tracing), ("whole first bake", counts, whole)],
        )
    )
    obj = meshes.torus(100_000)
    for resolution in RESOLUTIONS[: 2 if quick else None]:
        seconds = _texture(obj, resolution, repeats, samples=16)[1]
        rate = resolution**2 * 16 / seconds / 1e6
        report.note(
            f"{resolution**2:9,} points at 16 samples: tracing {seconds:.2f} s, {rate:.1f} million rays a second"
        )
    _threads(report, quick)


def _texture(obj, resolution: int, repeats: int, samples: int = SAMPLES) -> tuple[float, float]:
    """Seconds of a first bake, and of the tracing in this one and ``repeats`` more: the median."""
    meshes.nudge(obj)
    whole, traced = [], []
    for _ in range(1 + repeats):
        with RayClock() as clock:
            whole.append(by_the_extension(obj, samples, target="TEXTURE", resolution=resolution))
        traced.append(clock.seconds)
    return whole[0], statistics.median(traced)


def _threads(report: Report, quick: bool) -> None:
    obj = meshes.coral(4 if quick else 7)
    results = {}
    clocks: dict[int, list[float]] = {1: [], 2: []}

    def bake(threads: int) -> float:
        meshes.nudge(obj)
        with RayClock() as clock:
            whole = by_the_extension(obj, 256, threads=threads)
        clocks[threads].append(clock.seconds)
        return whole

    taken = side_by_side({"one": lambda: bake(1), "two": lambda: bake(2)}, 1 if quick else 5, 20.0)
    for threads in (1, 2):
        by_the_extension(obj, 64, threads=threads)
        results[threads] = np.stack((colours(obj, AO), colours(obj, CONE)))
    one, two = (statistics.median(clocks[threads]) for threads in (1, 2))
    report.add("times that two threads are faster, tracing", f"{one / two:.2f}", "≥ 1.8")
    report.add("times that two threads are faster, whole first bake", f"{taken['one'] / taken['two']:.2f}", "≥ 1.8")
    same = np.array_equal(results[1], results[2])
    report.add("bits of one thread and of two", "equal" if same else "different", "equal")
