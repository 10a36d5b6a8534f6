# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preview of a bake in the window costs, drawing apart, and how soon there is something to see.

The job is driven as the window does, with and without a preview in turns. Seconds are of all processors, which other
work on the machine changes less than the time that passes.
"""

from __future__ import annotations

import time

import bpy
import numpy as np
from bakes import _operators
from meshes import empty_scene, nudge, select, suzanne
from report import Report

CASES = (("VERTEX", 16), ("VERTEX", 64), ("VERTEX", 256), ("TEXTURE", 16), ("TEXTURE", 64), ("TEXTURE", 256))


def main(report: Report, quick: bool) -> None:
    for target, samples in CASES:
        empty_scene()
        obj = suzanne(2 if quick else 3 if samples > 64 else 4)
        settings = bpy.context.scene.multibounce_ao
        settings.target, settings.samples, settings.bounces = target, samples, "BAKED"
        settings.resolution = 128 if quick else 512
        select(obj)
        taken, seen = {False: [], True: []}, []
        for turn in range(2 if quick else 10):
            nudge(obj)
            cpu, first = _bake(obj, shown := bool(turn % 2))
            taken[shown].append(cpu)
            if shown:
                seen.append(first)
        without, shown = (float(np.median(taken[each])) for each in (False, True))
        what = f"{target.lower()}, {samples} samples"
        report.add(f"{what}: with a preview, without {without:.2f} s", f"{shown / without - 1.0:+.1%}", "a few percent")
        report.add(f"{what}: seconds until the sketch", f"{np.median(seen):.2f}", "1")


def _bake(obj: bpy.types.Object, is_shown: bool) -> tuple[float, float]:
    """Seconds of all processors, and those that pass until the sketch is there."""
    preview, first = _operators("preview").Preview() if is_shown else None, np.inf
    chosen = _operators("settings").BakeSettings.of(bpy.context.scene)
    began, cpu = time.perf_counter(), time.process_time()
    for _ in _operators("bake_job").bake(bpy.context, [obj], chosen, preview=preview):
        if first == np.inf and is_shown and any(each.version for each in preview.pictures.values()):
            first = time.perf_counter() - began
    return time.process_time() - cpu, first
