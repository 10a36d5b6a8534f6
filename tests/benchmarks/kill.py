# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes to existing files that are killed at random moments: how many files are whole afterwards, old or new.

A process bakes the same object again and again with two seeds in turn, so that every whole file is one of two.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from report import Report

HERE = Path(__file__).resolve().parent


def main(report: Report, quick: bool) -> None:
    moments, random = (2 if quick else 10), np.random.default_rng(0)
    whole = found = begun = 0
    with tempfile.TemporaryDirectory() as folder:
        known: dict[str, set[bytes]] = {}
        for seed in (0, 1):
            subprocess.run(_command(f"kill.bake({folder!r}, {seed})"), check=True, capture_output=True)
            for path in Path(folder).iterdir():
                known.setdefault(path.name, set()).add(path.read_bytes())
        for _ in range(moments):
            command = _command(f"kill.bake_again_and_again({folder!r})")
            with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
                _next_bake(process)
                started = time.perf_counter()
                _next_bake(process)
                time.sleep((time.perf_counter() - started) * random.random())
                process.kill()
            files = [path for path in Path(folder).iterdir() if not path.name.startswith(".")]
            found += len(files)
            whole += sum(path.read_bytes() in known[path.name] for path in files)
            parts = list(Path(folder).glob(".*"))
            begun += bool(parts)
            for part in parts:
                part.unlink()
    report.add(f"files whole after {moments} kills", f"{whole} of {found}", f"{2 * moments} of {2 * moments}")
    report.note(f"{begun} of {moments} kills came while a file was being written")


def _command(code: str) -> list[str]:
    paths = [str(HERE), str(HERE.parent), str(HERE.parent.parent)]
    return [sys.executable, "-c", f"import sys; sys.path[:0] = {paths!r}; import kill; {code}"]


def _next_bake(process: subprocess.Popen) -> None:
    """Wait until one is done."""
    while b"baked" not in process.stdout.readline():
        pass


def bake_again_and_again(folder: str) -> None:
    """Until somebody kills this process; prints a line when the next bake begins."""
    for count in range(1000):
        bake(folder, count % 2)
        os.write(1, b"baked\n")


def bake(folder: str, seed: int) -> None:
    """A texture bake of a small object to files of some megabytes in ``folder``."""
    import bpy
    from bakes import by_the_extension
    from enable_extension import enable_extension
    from meshes import suzanne, unwrap

    if "Suzanne" not in bpy.data.objects:
        enable_extension()
        unwrap(suzanne(levels=0))
    bpy.context.scene.multibounce_ao.output_directory = folder
    by_the_extension(bpy.data.objects["Suzanne"], 1, target="TEXTURE", resolution=1024, seed=seed)
