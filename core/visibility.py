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
from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .final_gather import gather
from .light_cache import LightCache
from .rays import Obscurance, Occluders
from .sample_points import SamplePoints
from .sampling import Pattern, carried_frames, deal, turns
from .workers import Workers, slices

# Rays in flight a thread, few enough for the cache. Fixed, because results must not depend on the machine.
RAYS_PER_BLOCK = 2**15
# Places prepared and summed up at once, about 50 MB. Numpy calls between traced blocks would each find the cache full
# of Embree's tree, so what needs many calls is done for many blocks together, in chunks: large ones, because threads
# that are done with a call sooner wait for Python's lock more often.
PLACES_PER_WINDOW = 2**19
PLACES_PER_CHUNK = 2**15
# Rays of a place in the dark that look whether it is inside of something.
PROBES = 8
# Multiplications of a matrix product up to which OpenBLAS stays in the calling thread; the others have work already.
SERIAL_PRODUCT = 2**18


# Points (k,) that are done, their F0 (k,), what they gathered (k, fields) or None without a cache, and which are lost
# (k,). Places that are inside of something still count, as dark.
Watch = Callable[[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64] | None, NDArray[np.bool_]], None]


@dataclass(frozen=True)
class Visibility:
    """What n points see. f0 (n,), alpha (n,) in [0, 1]; bent (n, 3), length at most 1, world axes. All float32.

    gathered  (n, 3) float64, one bounce of each field of the light cache; None without a cache
    lost      (n,) bool, points without a place that can be seen: all lie inside of something closed, or have no
              surface. Not looked for inside where rays pass through backs
    """

    f0: NDArray[np.float32]
    alpha: NDArray[np.float32]
    bent: NDArray[np.float32]
    gathered: NDArray[np.float64] | None = None
    lost: NDArray[np.bool_] | None = None

    def __getitem__(self, part: slice) -> Visibility:
        """What a slice of the points sees."""
        optional = (None if each is None else each[part] for each in (self.gathered, self.lost))
        return Visibility(self.f0[part], self.alpha[part], self.bent[part], *optional)


def trace_visibility(
    occluders: Occluders,
    points: SamplePoints,
    pattern: Pattern,
    *,
    extent: float,
    cache: LightCache | None = None,
    obscurance: Obscurance | None = None,
    seed: int = 0,
    threads: int | None = None,
    watch: Watch | None = None,
) -> Generator[int, None, Visibility]:
    """Trace ``pattern`` from each point; yields the number of points done so far, returns their :class:`Visibility`.

    extent   size of the surface that the points lie on, world units: the ray offset is a fraction of it
    cache    light of the surfaces around, for the rays to gather; without it, rays only tell whether they are blocked
    seed     turns the pattern; equal seeds give equal bits, whatever the number of threads
    threads  default: one a core
    watch    is told before each yield what has been found since the last; it may take its time, as tracing goes on

    A place from which only the inside of what is closed is seen lies in it; a point is the mean over its other places.
    Closing the generator stops after the blocks in flight.
    """
    obscurance = obscurance or Obscurance()
    order, places = points.order(), points.places
    directions, weights = deal(pattern, places)
    # Turned directions as one product, entries of frames (.., 9) by (places, 9, 3r): numpy's batch of 3x3 products is
    # slower.
    to_rays = np.stack([np.kron(each.T, np.eye(3)) for each in directions]).astype(np.float32)
    rays_per_place = directions.shape[1]
    block_size = max(1, RAYS_PER_BLOCK // (places * rays_per_place))
    rows = max(1, SERIAL_PRODUCT // (to_rays.shape[1] * to_rays.shape[2]))
    window_size = max(block_size, PLACES_PER_WINDOW // places // block_size * block_size)
    buffers = threading.local()
    ray = np.arange(places * rays_per_place, dtype=np.uint32)
    cosine = np.ascontiguousarray(weights[:, :, 0])
    sky, fields = weights.shape[2], 0 if cache is None else len(cache.light)
    result = Visibility(
        np.empty(len(points), np.float32),
        np.empty(len(points), np.float32),
        np.empty((len(points), 3), np.float32),
        np.empty((len(points), fields)) if cache else None,
        np.empty(len(points), bool),
    )
    # What each place's rays sum up to where all see the sky, and which of them look whether it is inside.
    most = weights.sum(axis=1)
    probes = np.linspace(0, rays_per_place - 1, min(PROBES, rays_per_place)).astype(np.intp)

    def trace_window(workers: Workers, window: NDArray[np.intp]) -> Generator[int, None, None]:
        size = len(window)
        start = np.empty((size, places, 3), np.float32)
        # Points last, so that numpy runs along them.
        frame = np.empty((places, 3, 3, size), np.float32)
        sums = np.empty((size, places, sky + fields))
        lost = np.zeros((size, places), bool)
        number = points.number(window)
        unseen: list[slice] = []  # parts that were traced, and not watched yet

        def prepare(part: slice) -> int:
            positions, normals, lift, missing = points.at(window[part])
            origins = occluders.origins(positions, normals, extent)
            if lift is not None:
                occluders.lift(origins, normals, lift, extent)
            if missing is not None:
                lost[part] = missing.T
            start[part] = origins.T
            frame[..., part] = carried_frames(normals, turns(number[part], seed))
            return 0

        def trace(part: slice) -> int:
            count = part.stop - part.start
            if not hasattr(buffers, "rays"):
                buffers.rays, buffers.visible = _buffers((2, block_size, places, rays_per_place, 3))
                buffers.light = np.empty((fields, buffers.visible.size))
            origins, directions = buffers.rays[:, :count]
            _triples(origins)[...] = _triples(start[part])[..., None]
            by_place = directions.reshape(count, places, -1).swapaxes(0, 1)
            turned = frame.reshape(places, 9, size)[:, :, part].swapaxes(1, 2)
            for row in range(0, count, rows):
                np.matmul(turned[:, row : row + rows], to_rays, out=by_place[:, row : row + rows])
            visible = buffers.visible[: origins.size // 3]
            rays = origins.reshape(-1, 3), directions.reshape(-1, 3)
            if cache is None:
                occluders.visibility(*rays, obscurance, out=visible)
            else:
                names = (number[part, None].astype(np.uint32) * np.uint32(places * rays_per_place) + ray).reshape(-1)
                light = buffers.light[:, : visible.size]
                gather(occluders, cache, obscurance, *rays, names, seed, visible, light, extent=extent)
                for field, values in enumerate(light):
                    # Not as a product with a vector: for that OpenBLAS wakes its threads at any size.
                    of_rays = values.reshape(count, places, -1)
                    np.einsum("cpr,pr->cp", of_rays, cosine, out=sums[part, :, sky + field])
            by_place = visible.reshape(count, places, -1).swapaxes(0, 1)
            np.matmul(by_place, weights, out=sums[part, :, :sky].swapaxes(0, 1))
            if not obscurance.ignore_backfaces:
                dark = np.flatnonzero(sums[part, :, 1] == 0.0)
                for some in (probes[:1], probes[1:]):  # of most places in the dark the first ray sees a front
                    chosen = (dark[:, None] * rays_per_place + some).reshape(-1)
                    inside = occluders.see_inside(*(each.take(chosen, axis=0) for each in rays))
                    dark = dark[inside.reshape(len(dark), len(some)).all(axis=1)]
                lost[part].reshape(-1)[dark] = True
            if watch is not None:
                unseen.append(part)
            return count

        def show() -> None:
            parts = [unseen.pop() for _ in range(len(unseen))]
            if parts:
                row = np.concatenate([np.arange(part.start, part.stop) for part in parts])
                seen = sums[row].sum(axis=1)
                watch(window[row], seen[:, 0], seen[:, sky:] if cache else None, lost[row].all(axis=1))

        def sum_up(part: slice) -> int:
            result.lost[window[part]] = lost[part].all(axis=1)
            partly = np.flatnonzero(lost[part].any(axis=1))
            _leave_out(sums[part], partly, ~lost[part][partly], most)
            f0, alpha = sums[part, :, 0].sum(axis=1), sums[part, :, 1].sum(axis=1)
            if cache:
                result.gathered[window[part]] = sums[part, :, sky:].sum(axis=1)
            # The mean direction's parts along each place's x, y and z.
            bent = np.zeros((3, part.stop - part.start))
            for axis, along in enumerate(np.ascontiguousarray(sums[part, :, 2:sky].T)):
                bent += (frame[:, axis, :, part] * along[:, None]).sum(axis=0)
            result.f0[window[part]] = f0
            result.alpha[window[part]] = alpha
            result.bent[window[part]] = np.divide(bent, alpha, out=np.zeros_like(bent), where=alpha > 0.0).T
            return 0

        chunks = slices(size, max(1, PLACES_PER_CHUNK // places))
        yield from workers.run(prepare, chunks)
        for count in workers.run(trace, slices(size, block_size)):
            show()
            yield count
        for _ in workers.run(sum_up, chunks):
            yield size

    done = 0
    with Workers(threads) as workers:
        for part in slices(len(order), window_size):
            for count in trace_window(workers, order[part]):
                yield done + count
            done += count
    return result


def _leave_out(sums: NDArray[np.float64], point: NDArray[np.intp], kept: NDArray[np.bool_], most: NDArray) -> None:
    """In ``sums`` (n, places, 5 and more) of those ``point`` (k,), let the places ``kept`` (k, places) stand for all;
    where none is, all stay. ``most`` (places, 5) is what they sum up to where all is open."""
    kept = kept | ~kept.any(axis=1, keepdims=True)
    share = np.einsum("kp,pw->kw", kept.astype(np.float64), most[:, :2]) / most[:, :2].sum(axis=0)
    by = np.repeat(share[:, :1], sums.shape[2], axis=1)
    by[:, 1:5] = share[:, 1:]  # alpha, and the mean direction, which has its weights
    sums[point] *= kept[:, :, None] / by[:, None]


def _buffers(shape: tuple[int, ...]) -> tuple[NDArray[np.float32], NDArray[np.float64]]:
    """For rays (2, ..., 3), origins and directions, and for the visibility of each, flat."""
    rays = math.prod(shape) // 6
    # For 4 MB and more numpy asks Linux for huge pages, which spare Embree's tree its place in the TLB.
    memory = np.empty(max(2**23, 32 * rays), np.uint8)
    return memory[: 24 * rays].view(np.float32).reshape(shape), memory[-8 * rays :].view(np.float64)


def _triples(vectors: NDArray[np.float32]) -> NDArray[np.void]:
    """Vectors (..., 3) as (...) elements: numpy copies those in one go."""
    return vectors.view(np.dtype((np.void, 12)))[..., 0]
