# SPDX-License-Identifier: GPL-3.0-or-later
"""The ray loop: how much of the sky each point sees.

    F0    = k_A = (1/pi)  * integral of V(w) cos(theta) dw    what people call the AO map
    alpha =       (1/2pi) * integral of V(w) dw               the published multi-bounce fit's input
    bent  = mean of the visible directions, not normalised    (integral of V(w) w dw) / (integral of V(w) dw)

with V = 1 where a ray escapes, or rho(d) for obscurance ("Real-Time Rendering", 4th ed., sections 11.3.1 and 11.3.2).
All come from the same rays. Points are taken along a space-filling curve in blocks that stay in the cache, a thread a
core (Embree runs without Python's lock); nothing is kept a ray, so memory does not follow the sample count.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rays import Obscurance, Occluders
from .sample_points import SamplePoints
from .sampling import Pattern, carried_frames, turns
from .workers import Workers, slices

# Rays in flight a thread, few enough for the cache. Fixed, because results must not depend on the machine.
RAYS_PER_BLOCK = 2**15
# Places prepared and summed up at once. Numpy calls between traced blocks would each find the
# cache full of Embree's tree, so what needs many calls is done for many blocks together, in chunks.
PLACES_PER_WINDOW = 2**18
PLACES_PER_CHUNK = 2**13
# Multiplications of a matrix product up to which OpenBLAS stays in the calling thread; the others have work already.
SERIAL_PRODUCT = 2**18


@dataclass(frozen=True)
class Visibility:
    """What n points see. f0 (n,), alpha (n,) in [0, 1]; bent (n, 3), length at most 1, world axes. All float32."""

    f0: NDArray[np.float32]
    alpha: NDArray[np.float32]
    bent: NDArray[np.float32]

    def __getitem__(self, part: slice) -> Visibility:
        """What a slice of the points sees."""
        return Visibility(self.f0[part], self.alpha[part], self.bent[part])


def trace_visibility(
    occluders: Occluders,
    points: SamplePoints,
    pattern: Pattern,
    *,
    extent: float,
    obscurance: Obscurance | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> Generator[int, None, Visibility]:
    """Trace ``pattern`` from each point; yields the number of points done so far, returns their :class:`Visibility`.

    extent   size of the surface that the points lie on, world units: the ray offset is a fraction of it
    seed     turns the pattern; equal seeds give equal bits, whatever the number of threads
    threads  default: one a core

    Closing the generator stops after the blocks in flight.
    """
    obscurance = obscurance or Obscurance()
    order, places = points.order(), points.places
    directions, weights = _deal(pattern, places)
    # Turned directions as one product, entries of frames (.., 9) by (places, 9, 3r): numpy's batch of 3x3 products is
    # slower.
    to_rays = np.stack([np.kron(each.T, np.eye(3)) for each in directions]).astype(np.float32)
    rays_per_place = directions.shape[1]
    block_size = max(1, RAYS_PER_BLOCK // (places * rays_per_place))
    rows = max(1, SERIAL_PRODUCT // (to_rays.shape[1] * to_rays.shape[2]))
    window_size = max(block_size, PLACES_PER_WINDOW // places // block_size * block_size)
    buffers = threading.local()
    result = Visibility(
        np.empty(len(points), np.float32), np.empty(len(points), np.float32), np.empty((len(points), 3), np.float32)
    )

    def trace_window(workers: Workers, window: NDArray[np.intp]) -> Generator[int, None, None]:
        size = len(window)
        start = np.empty((size, places, 3), np.float32)
        frame = np.empty((size, places, 3, 3), np.float32)
        sums = np.empty((size, places, weights.shape[2]))

        def prepare(part: slice) -> int:
            positions, normals = points.at(window[part])
            start[part] = np.moveaxis(occluders.origins(positions, normals, extent), 0, 2)
            frame[part] = carried_frames(normals, turns(points.number(window[part]), seed))
            return 0

        def trace(part: slice) -> int:
            count = part.stop - part.start
            if not hasattr(buffers, "rays"):
                buffers.rays, buffers.visible = _buffers((2, block_size, places, rays_per_place, 3))
            origins, directions = buffers.rays[:, :count]
            _triples(origins)[...] = _triples(start[part])[..., None]
            by_place = directions.reshape(count, places, -1).swapaxes(0, 1)
            turned = frame[part].reshape(count, places, 9).swapaxes(0, 1)
            for row in range(0, count, rows):
                np.matmul(turned[:, row : row + rows], to_rays, out=by_place[:, row : row + rows])
            visible = buffers.visible[: origins.size // 3]
            occluders.visibility(origins.reshape(-1, 3), directions.reshape(-1, 3), obscurance, out=visible)
            np.matmul(visible.reshape(count, places, -1).swapaxes(0, 1), weights, out=sums[part].swapaxes(0, 1))
            return count

        def sum_up(part: slice) -> int:
            f0, alpha = sums[part, :, 0].sum(axis=1), sums[part, :, 1].sum(axis=1)
            # Points last, so that numpy runs along them.
            local = np.ascontiguousarray(sums[part, :, 2:].T)
            bent = (local[:, None] * np.ascontiguousarray(frame[part].transpose(2, 3, 1, 0))).sum(axis=(0, 2)).T
            result.f0[window[part]] = f0
            result.alpha[window[part]] = alpha
            result.bent[window[part]] = np.divide(
                bent, alpha[:, None], out=np.zeros_like(bent), where=alpha[:, None] > 0.0
            )
            return 0

        chunks = slices(size, max(1, PLACES_PER_CHUNK // places))
        yield from workers.run(prepare, chunks)
        yield from workers.run(trace, slices(size, block_size))
        for _ in workers.run(sum_up, chunks):
            yield size

    done = 0
    with Workers(threads) as workers:
        for part in slices(len(order), window_size):
            for count in trace_window(workers, order[part]):
                yield done + count
            done += count
    return result


def _buffers(shape: tuple[int, ...]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """For rays (2, ..., 3), origins and directions, and for the visibility of each, flat."""
    rays = math.prod(shape) // 6
    # For 4 MB and more numpy asks Linux for huge pages, which spare Embree's tree its place in the TLB.
    memory = np.empty(max(2**23, 32 * rays), np.uint8)
    return memory[: 24 * rays].view(np.float32).reshape(shape), memory[-8 * rays :].view(np.float64)


def _triples(vectors: NDArray[np.float32]) -> NDArray[np.void]:
    """Vectors (..., 3) as (...) elements: numpy copies those in one go."""
    return vectors.view(np.dtype((np.void, 12)))[..., 0]


def _deal(pattern: Pattern, places: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The rays of each place: directions (places, r, 3) and weights (places, r, 5), zero for rays that only fill up.

    Every place gets one of each ``places`` directions in turn. Which one moves on by two: always the same would be, for
    8 places or another Fibonacci number, one arm of the pattern's spirals. A place's rays go around its normal, so that
    one finds in the cache what the last one met.

    The weights say what a visible ray adds to F0, alpha and the mean direction's x, y, z. They are multiples of 2^-40,
    like the pattern's own, so that the product sums them without rounding in any order. The pattern's directions are
    not quite balanced about the normal; taking their mean x and y from each (a control variate) makes an open point's
    bent direction its normal.
    """
    sideways = pattern.uniform @ (pattern.directions * (1.0, 1.0, 0.0))
    bent = np.rint((pattern.directions - sideways) * pattern.uniform[:, None] * 2.0**40) / 2.0**40
    weights = np.column_stack((pattern.cosine, pattern.uniform, bent))
    count = len(weights)
    azimuth = np.arctan2(pattern.directions[:, 1], pattern.directions[:, 0])
    turn = np.arange(-(-count // places))[:, None]
    dealt = (turn * places + (np.arange(places) + 2 * turn) % places).T
    dealt = np.take_along_axis(dealt, np.argsort(azimuth[dealt % count], axis=1, kind="stable"), axis=1)
    return pattern.directions[dealt % count], np.where(dealt[..., None] < count, weights[dealt % count], 0.0)
