# SPDX-License-Identifier: GPL-3.0-or-later
"""Peak memory of a bake over that of the scene, against Cycles' in the same bake, at 16 and 256 samples.

Each is a process of its own, in which a small bake has loaded the libraries. Linux only: it can reset the peak that
it keeps of a process.
"""

from __future__ import annotations

import ctypes
import gc
import os
import subprocess
import sys
from pathlib import Path

from report import Report

HERE = Path(__file__).resolve().parent


def main(report: Report, quick: bool) -> None:
    if not os.access("/proc/self/clear_refs", os.W_OK):
        report.note("not measured: this system has no /proc/self/clear_refs")
        return
    meshes = ["coral", *os.environ.get("BENCH_MESHES", "").split()]
    for name in meshes[: 1 if quick else None]:
        for target in ("VERTEX", "TEXTURE"):
            for samples in (16,) if quick else (16, 256):
                ours, cycles = (_peak(who, name, target, samples) for who in ("the extension", "Cycles"))
                what = f"{Path(name).stem}: {target.lower()} bake at {samples}"
                report.note(f"{what}: {ours:.0f} MB over the scene, Cycles {cycles:.0f} MB")
                report.add(f"{what}, peak memory over Cycles'", f"{ours / cycles:.2f}", "≤ 1")


def _peak(who: str, name: str, target: str, samples: int) -> float:
    paths = [str(HERE), str(HERE.parent), str(HERE.parent.parent)]
    code = f"import sys; sys.path[:0] = {paths!r}; import memory; memory.bake{(who, name, target, samples)!r}"
    output = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    return float(output.split()[-1])


def bake(who: str, name: str, target: str, samples: int) -> None:
    """Print how many megabytes the process grew by at most, in the bake of mesh ``name``."""
    import meshes
    from bakes import by_cycles, by_the_extension, warm_up
    from enable_extension import enable_extension

    enable_extension()
    warm_up()
    obj = meshes.coral() if name == "coral" else meshes.load(name)
    if target == "TEXTURE":
        meshes.unwrap(obj)
    else:
        # What a viewport that shows the mesh has at hand too.
        obj.data.calc_loop_triangles()
    run = by_cycles if who == "Cycles" else by_the_extension
    # What is free already goes back to the system, or a bake that fits in it would seem to take nothing.
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts again from what is in use now
    before = _status("VmRSS")
    run(obj, samples, target=target)
    print(f"{_status('VmHWM') - before:.1f}")


def _status(key: str) -> float:
    """A line of /proc/self/status, in megabytes."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(key + ":")) / 1024
