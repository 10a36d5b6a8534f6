# SPDX-License-Identifier: GPL-3.0-or-later
"""The time left that is told after a tenth of a bake, over what it then took.

Driven as the window does, a preview included, but nothing is drawn. The scene is built anew for each. Seconds are of
all processors, which other work on the machine changes less than the time that passes.
"""

from __future__ import annotations

import itertools
import time

import bpy
from bakes import _operators
from meshes import empty_scene, nudge, select, suzanne
from report import Report

TARGETS, BOUNCES = ("VERTEX", "TEXTURE"), ("FITTED", "BAKED", "RADIOSITY")


def main(report: Report, quick: bool) -> None:
    good = []
    for target, bounces, samples in itertools.product(TARGETS, BOUNCES, (16, 64, 256)):
        # About the same time for each.
        levels = 2 if quick else {16: 4, 64: 4, 256: 3}[samples]
        empty_scene()
        obj = suzanne(levels)
        nudge(obj)
        settings = bpy.context.scene.multibounce_ao
        settings.target, settings.bounces, settings.samples = target, bounces, samples
        settings.resolution = 128 if quick else {16: 1024, 64: 512, 256: 512}[samples]
        select(obj)
        told, true, whole = _tenth(obj)
        ratio = told / true if told and true else float("nan")
        good.append(abs(ratio - 1.0) < 0.3)
        what = f"{target.lower()}, {bounces.lower()}, {samples} samples, {whole:.1f} s"
        report.add(what, f"{ratio:.2f}", ".7 to 1.3")
    report.add("cases within 30 %", f"{sum(good)} of {len(good)}", "all")


def _tenth(obj: bpy.types.Object) -> tuple[float | None, float, float]:
    """Seconds left as told after a tenth, and as they were; and of the whole bake."""
    progress, preview = _operators("progress"), _operators("preview")
    chosen = _operators("settings").BakeSettings.of(bpy.context.scene)
    pace, told, at = progress.Pace(now=time.process_time), None, 0.0
    began = time.process_time()
    for step in _operators("bake_job").bake(bpy.context, [obj], chosen, preview=preview.Preview()):
        pace(step)
        if told is None and step.fraction >= 0.1:
            told, at = pace.left, time.process_time()
    ended = time.process_time()
    return told, ended - at, ended - began
