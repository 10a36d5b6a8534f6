# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray loop: how much of the sky each point sees.

    F0    = k_A = (1/pi)  * integral of V(w) cos(theta) dw    what people call the AO map
    alpha =       (1/2pi) * integral of V(w) dw               the published multi-bounce fit's input
    bent  = mean of the visible directions, not normalised    (integral of V(w) w dw) / (integral of V(w) dw)

with V = 1 where a ray escapes, or rho(d) for obscurance ("Real-Time Rendering", 4th ed., sections 11.3.1 and 11.3.2).
All come from the same rays. Points are taken along a Morton curve in blocks that stay in the cache, a thread a core
(Embree runs without Python's lock); nothing is kept a ray, so memory is that of the block whatever the sample count.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .morton import morton_order
from .rays import Obscurance, Occluders
from .sampling import Pattern, frames, turns

# Rays in flight a thread: under 1 MB, and few enough that BLAS sums a block without waking threads of its own beside
# ours. Fixed, because results must not depend on the machine.
RAYS_PER_BLOCK = 2**15


@dataclass(frozen=True)
class Visibility:
    """What n points see. f0 (n,), alpha (n,) in [0, 1]; bent (n, 3), length at most 1, world axes. All float32."""

    f0: NDArray[np.float32]
    alpha: NDArray[np.float32]
    bent: NDArray[np.float32]


def trace_visibility(
    occluders: Occluders,
    points: NDArray,
    normals: NDArray,
    pattern: Pattern,
    *,
    extent: float,
    obscurance: Obscurance | None = None,
    seed: int = 0,
    first_index: int = 0,
    threads: int | None = None,
) -> Generator[int, None, Visibility]:
    """Trace ``pattern`` from each point; yields the number of points done so far, returns their :class:`Visibility`.

    points, normals  (n, 3) float, world space; normals of unit length
    extent           size of the surface they lie on, which the ray offset is a fraction of
    seed             turns the pattern; equal seeds give equal bits, whatever the number of threads
    first_index      number of the first point, where a surface is traced a part at a time
    threads          default: one a core

    Closing the generator stops after the blocks in flight.
    """
    points, normals = np.asarray(points, np.float64), np.asarray(normals, np.float64)
    obscurance = obscurance or Obscurance()
    order = morton_order(points)
    samples = len(pattern.directions)
    step = max(1, RAYS_PER_BLOCK // samples)
    blocks = [order[start : start + step] for start in range(0, len(order), step)]
    local = pattern.directions.astype(np.float32)
    weights = _weights(pattern)
    result = Visibility(
        np.empty(len(points), np.float32), np.empty(len(points), np.float32), np.empty((len(points), 3), np.float32)
    )

    def trace(block: NDArray[np.intp]) -> int:
        normal = normals[block]
        turned = frames(normal, turns(first_index + block, seed))
        directions = np.matmul(local, turned.astype(np.float32)).reshape(-1, 3)
        origins = np.repeat(occluders.origins(points[block], normal, extent), samples, axis=0)
        visible = occluders.visibility(origins, directions, obscurance).reshape(-1, samples)
        sums = visible @ weights
        f0, alpha = sums[:, 0], sums[:, 1]
        mean = np.divide(sums[:, 2:], alpha[:, None], out=np.zeros((len(block), 3)), where=alpha[:, None] > 0.0)
        result.f0[block] = f0
        result.alpha[block] = alpha
        result.bent[block] = np.einsum("ni,nij->nj", mean, turned)
        return len(block)

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        done = 0
        try:
            for count in pool.map(trace, blocks):
                done += count
                yield done
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    return result


def _weights(pattern: Pattern) -> NDArray[np.float64]:
    """(S, 5): what a visible ray adds to F0, alpha and the mean direction's x, y, z.

    Multiples of 2^-40, like the pattern's own weights, so that the product sums them without rounding in any order. The
    pattern's directions are not quite balanced about the normal; taking their mean x and y from each (a control
    variate) makes an open point's bent direction its normal.
    """
    sideways = pattern.uniform @ (pattern.directions * (1.0, 1.0, 0.0))
    directions = (pattern.directions - sideways) * pattern.uniform[:, None]
    return np.column_stack((pattern.cosine, pattern.uniform, np.rint(directions * 2.0**40) / 2.0**40))
