# SPDX-License-Identifier: GPL-3.0-or-later
"""An ambient occlusion field of 100k triangles: seconds, size of its files, rays a second beside Embree alone.

The rays of a bake are kept as they were, in the same blocks, and traced once more on as many threads: no directions are
made and nothing is summed or fitted.
"""

from __future__ import annotations

import os
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from unittest.mock import patch

import meshes
import numpy as np
from report import Report
from timing import seconds, side_by_side

from core.ao_field import AOField
from core.field_bake import bake_field
from core.field_files import save_field
from core.rays import Occluders


def main(report: Report, quick: bool) -> None:
    obj = meshes.torus(2_000 if quick else 100_000)
    mesh = obj.data
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    vertices, triangles = vertices.reshape(-1, 3).astype(np.float64), triangles.reshape(-1, 3)

    def bake() -> AOField:
        work = bake_field(Occluders(vertices, triangles), vertices, triangles)
        while True:
            try:
                next(work)
            except StopIteration as finished:
                return finished.value

    blocks: list[tuple] = []
    times: list[tuple[float, float]] = []

    def clocked(scene, origins, directions, *args, _whole=Occluders.visibility, **kwargs):
        started = time.perf_counter()
        visible = _whole(scene, origins, directions, *args, **kwargs)
        times.append((started, time.perf_counter()))
        if keep:
            blocks.append((scene, origins, directions))
        return visible

    def tracing() -> float:
        """From the first block's start to the last one's end, with what is done between them."""
        times.clear()
        with patch.object(Occluders, "visibility", clocked):
            bake()
        return max(end for _, end in times) - min(start for start, _ in times)

    keep = True
    tracing()
    keep = False
    rays = sum(len(origins) for _, origins, _ in blocks)

    def embree() -> float:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return seconds(lambda: list(pool.map(lambda b: b[0]._scene.run(*b[1:], query="OCCLUDED"), blocks)))

    taken = side_by_side({"tracing": tracing, "Embree": embree, "bake": lambda: seconds(bake)}, 1 if quick else 3)
    rates = {key: rays / taken[key] / 1e6 for key in ("tracing", "Embree")}
    report.note(
        f"{rays / 1e6:.1f} million rays around the object: {rates['tracing']:.1f} million a second in the bake, "
        f"{rates['Embree']:.1f} in Embree alone"
    )
    report.add(
        f"{len(triangles)} triangles: rays a second, of Embree alone", f"{rates['tracing'] / rates['Embree']:.2f}"
    )
    report.add(f"{len(triangles)} triangles: seconds for the whole field", f"{taken['bake']:.1f}")
    with tempfile.TemporaryDirectory() as folder:
        size = sum(path.stat().st_size for path in save_field(bake(), folder, "Object"))
    report.add(f"{len(triangles)} triangles: kB of its files", f"{size / 1000:.0f}")
