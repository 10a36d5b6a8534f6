# SPDX-License-Identifier: GPL-3.0-or-later
"""Peak memory of a texture bake of 8192 x 8192 of a mesh of a million triangles, packed and to files, beside what the
extension says that it needs.

Each is a process of its own, which counts with all that Blender and the scene take. Linux only, as memory.py.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from report import Report

HERE = Path(__file__).resolve().parent


def main(report: Report, quick: bool) -> None:
    if not os.access("/proc/self/clear_refs", os.W_OK):
        report.note("not measured: this system has no /proc/self/clear_refs")
        return
    steps, resolution = (100, 1024) if quick else (708, 8192)
    with tempfile.TemporaryDirectory() as folder:
        for where, output in {"packed": "", "to files": folder}.items():
            paths = [str(HERE), str(HERE.parent), str(HERE.parent.parent)]
            call = f"memory_8k.bake{(steps, resolution, output)!r}"
            code = f"import sys; sys.path[:0] = {paths!r}; import memory_8k; {call}"
            done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
            peak, grown, said = done.stdout.split()[-3:]
            report.note(f"{where}: grew by {grown} GB over the scene, said {said} GB")
            report.add(f"{2 * steps**2:,} triangles, {resolution} x {resolution}, {where}: GB", peak, "< 6")


def bake(steps: int, resolution: int, folder: str) -> None:
    """Print the peak memory of the process in GB, how much of it is over that of the scene, and what the bake said."""
    import bpy
    import numpy as np
    from bakes import by_the_extension, warm_up
    from enable_extension import enable_extension
    from memory import _status
    from meshes import empty_scene, object_of

    enable_extension()
    warm_up()
    empty_scene()
    t = np.linspace(-1.0, 1.0, steps + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(t, t))
    low = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    quads = np.column_stack((low, low + 1, low + steps + 2, low + steps + 1))
    obj = object_of("Waves", np.column_stack((x, y, 0.05 * np.sin(9 * x) * np.cos(8 * y))), quads)
    layer = obj.data.uv_layers.new()
    layer.uv.foreach_set("vector", np.float32(np.column_stack((x, y))[quads.ravel()] * 0.48 + 0.5).ravel())
    bpy.context.scene.multibounce_ao.output_directory = folder
    Path("/proc/self/clear_refs").write_text("5")
    before = _status("VmRSS")
    by_the_extension(obj, 1, target="TEXTURE", resolution=resolution, bounces="BAKED")
    peak = _status("VmHWM")
    said = re.search(r"([\d.]+) GB", str(obj["multibounce_ao"].get("memory", "")))
    print(f"{peak / 1024:.2f} {(peak - before) / 1024:.2f} {said[1] if said else '-'}")
