# SPDX-License-Identifier: GPL-3.0-or-later
"""What rays of a bake gather from the light cache."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .cells import NONE, side_of
from .light_cache import LightCache
from .rays import Obscurance, Occluders
from .sampling import frames, turns

# Rays from a hit whose cell cannot stand for it.
SECOND_RAYS = 2
TURN_SEED, HEIGHT_SEED = 0x5EED0003, 0x5EED0004


def gather(
    occluders: Occluders,
    cache: LightCache,
    obscurance: Obscurance,
    origins: NDArray[np.float32],
    directions: NDArray[np.float32],
    number: NDArray[np.integer],
    seed: int,
    visible: NDArray[np.float64],
    light: NDArray[np.float64],
    *,
    extent: float,
) -> None:
    """Fill ``visible`` (r,), V of each ray (r, 3), and ``light`` (3, r), what it meets sends back (LightCache.light).

    number  (r,) what the rays are called, whoever traces them and when: it draws the rays from their hits
    """
    hits = occluders.hits(origins, directions, obscurance)
    visible[:] = hits.visible
    blocked = np.flatnonzero(hits.triangle >= 0)
    distance = hits.distance.take(blocked)
    positions = origins.take(blocked, axis=0) + distance.astype(np.float32)[:, None] * directions.take(blocked, axis=0)
    side = side_of(hits.triangle.take(blocked), hits.behind.take(blocked))
    cell = cache.find(side, positions)
    # Near a corner light changes within a cell: there one bounce more is traced instead.
    again = np.flatnonzero((cell == NONE) | (distance < cache.near))
    ray = blocked.take(again)
    normals = hits.normals(ray).astype(np.float64).T
    surface = hits.triangle.take(ray), hits.u.take(ray), hits.v.take(ray)
    second = _second_gather(
        occluders, cache, obscurance, positions[again], normals, surface, number.take(ray), seed, extent
    )
    light.fill(0.0)
    for field, known, traced in zip(light, cache.light, second, strict=True):
        values = known.take(cell)
        values[again] = traced
        if obscurance.needs_distance:
            values *= 1.0 - visible.take(blocked)
        field[blocked] = values


def _second_gather(
    occluders, cache: LightCache, obscurance, positions, normals, surface, number, seed: int, extent: float
) -> NDArray[np.float64]:
    """Light (3, k) that ``positions`` (k, 3) with unit ``normals`` (3, k) send back, from two cosine-weighted rays,
    opposite in azimuth and in the disk's radius."""
    angle, radius2 = turns(number, seed ^ TURN_SEED), turns(number, seed ^ HEIGHT_SEED) / (2.0 * np.pi)
    frame = frames(normals, angle)
    x = np.stack((np.sqrt(radius2), -np.sqrt(1.0 - radius2)), axis=1).astype(np.float32)
    z = np.sqrt(1.0 - x * x)
    directions = (x[:, :, None] * frame[:, None, 0] + z[:, :, None] * frame[:, None, 2]).reshape(-1, 3)
    start = occluders.off_surface(positions.T, normals, extent).T.astype(np.float32)
    origins = np.repeat(start, SECOND_RAYS, axis=0)
    hits = occluders.hits(origins, directions, obscurance)
    blocked = np.flatnonzero(hits.triangle >= 0)
    met = origins[blocked] + hits.distance[blocked].astype(np.float32)[:, None] * directions[blocked]
    cell = cache.find(side_of(hits.triangle[blocked], hits.behind[blocked]), met)

    def mean(values: NDArray) -> NDArray[np.float64]:
        return values.reshape(-1, SECOND_RAYS).mean(axis=1)

    def sent(field: int) -> NDArray[np.float64]:
        values = np.zeros(len(origins))
        values[blocked] = cache.light[field].take(cell) * (1.0 - hits.visible[blocked])
        return mean(values)

    gathered = np.stack([sent(field) for field in range(len(cache.light))])
    return cache.sent_by(mean(hits.visible), gathered, *surface)
