# SPDX-License-Identifier: GPL-3.0-or-later
"""What places around an object and inside its hull see of it, by rays towards all of it.

    Omega = integral of V dw         M = (1/pi) * integral of V w dw,   V = 1 where a ray meets the object

Rays fill a cone evenly: a spherical Fibonacci set (Keinert et al. 2015, "Spherical Fibonacci Mapping") turned at random
about the cone's axis at each place.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rays import Obscurance, Occluders
from .sampling import GOLDEN_RATIO, frames, turns
from .workers import Workers, slices

# Rays in flight a thread. Fixed, because results must not depend on the machine.
RAYS_PER_BLOCK = 2**15
# A place is inside something solid where more rays than the first part are blocked, and of these more than the second
# part meet a back. Both: before a sheet's back a place is free, and where meshes intersect some fronts face inwards.
MOST_BLOCKED, MOST_BEHIND = 0.95, 0.5


@dataclass(frozen=True)
class Seen:
    """Of n places. Omega (n,) float64 in [0, 4pi]; M (n, 3) float64, length at most 1."""

    Omega: NDArray[np.float64]
    M: NDArray[np.float64]


class ConePattern:
    """``samples`` directions that fill a cone evenly, about +z, for cones of any half angle."""

    def __init__(self, samples: int):
        if samples < 1:
            raise ValueError(f"samples must be at least 1, not {samples}")
        index = np.arange(samples)
        self._u = ((index + 0.5) / samples).astype(np.float32)
        azimuth = 2.0 * np.pi * np.mod(index / GOLDEN_RATIO, 1.0)
        self._circle = np.stack((np.cos(azimuth), np.sin(azimuth)), axis=-1).astype(np.float32)

    def __len__(self) -> int:
        return len(self._u)

    def directions(self, frame: NDArray[np.float32], cosine: NDArray[np.float64]) -> NDArray[np.float32]:
        """(p, samples, 3) float32, about the z axes of ``frame`` (p, 3, 3), in cones of half angle arccos ``cosine``
        (p,). Elevations are the midpoints of equal slices of the solid angle."""
        height = (1.0 - cosine).astype(np.float32)[:, None] * self._u  # 1 - cos theta
        local = np.empty((*height.shape, 3), np.float32)
        np.multiply(self._circle, np.sqrt(height * (2.0 - height))[..., None], out=local[..., :2])
        np.subtract(1.0, height, out=local[..., 2])
        return local @ frame


def seen_in_cones(
    occluders: Occluders,
    positions: NDArray[np.float64],
    axes: NDArray[np.float64],
    cosines: NDArray[np.float64],
    samples: int,
    seed: int,
    workers: Workers,
) -> Generator[float, None, Seen]:
    """What ``positions`` (n, 3) see, by ``samples`` rays each about unit ``axes`` (n, 3) in cones of half angle arccos
    ``cosines`` (n,) that hold the whole object. Yields the fraction done."""
    pattern, turn = ConePattern(samples), turns(np.arange(len(positions)), seed)
    seen = Seen(np.empty(len(positions)), np.empty((len(positions), 3)))

    def trace(part: slice) -> None:
        directions = pattern.directions(frames(axes[part].T, turn[part]), cosines[part])
        local = ((positions[part] - occluders.centre) * occluders.scale).astype(np.float32)
        origins = np.repeat(local, samples, axis=0)
        free = occluders.visibility(origins, directions.reshape(-1, 3), Obscurance())
        blocked = (1.0 - free).reshape(-1, 1, samples)
        cone = 2.0 * np.pi * (1.0 - cosines[part])
        seen.Omega[part] = cone * blocked.mean(axis=(1, 2))
        seen.M[part] = (cone / (np.pi * samples))[:, None] * (blocked @ directions)[:, 0]

    yield from workers.mapping(trace, slices(len(positions), max(1, RAYS_PER_BLOCK // samples)))
    return seen


@dataclass(frozen=True)
class SeenAround(Seen):
    """As :class:`Seen`, of places that may lie inside the object.

    A      (n,) float64 in [0, 1], the occlusion (1/pi) * integral of V max(0, n . w) dw for a normal
    solid  (n,) bool, where a place is inside something solid
    """

    A: NDArray[np.float64]
    solid: NDArray[np.bool_]


def seen_around(
    occluders: Occluders,
    positions: NDArray[np.float64],
    normals: NDArray[np.float64],
    samples: int,
    seed: int,
    workers: Workers,
) -> Generator[float, None, SeenAround]:
    """What ``positions`` (n, 3) with unit ``normals`` (n, 3) see all around them, by ``samples`` rays each. Yields the
    fraction done."""
    pattern, turn = ConePattern(samples), turns(np.arange(len(positions)), seed)
    count = len(positions)
    seen = SeenAround(np.empty(count), np.empty((count, 3)), np.empty(count), np.empty(count, bool))

    def trace(part: slice) -> None:
        directions = pattern.directions(frames(normals[part].T, turn[part]), np.full(len(turn[part]), -1.0))
        local = ((positions[part] - occluders.centre) * occluders.scale).astype(np.float32)
        hits = occluders.hits(np.repeat(local, samples, axis=0), directions.reshape(-1, 3), Obscurance())
        blocked = (1.0 - hits.visible).reshape(-1, 1, samples)
        share = blocked.mean(axis=(1, 2))
        seen.Omega[part] = 4.0 * np.pi * share
        seen.M[part] = 4.0 / samples * (blocked @ directions)[:, 0]
        cosine = np.einsum("psx,px->ps", directions, normals[part])
        seen.A[part] = np.minimum(4.0 / samples * np.einsum("ps,ps->p", blocked[:, 0], np.maximum(cosine, 0.0)), 1.0)
        behind = (hits.behind & (hits.visible < 1.0)).reshape(-1, samples).mean(axis=1)
        seen.solid[part] = (share > MOST_BLOCKED) & (behind > MOST_BEHIND * share)

    yield from workers.mapping(trace, slices(count, max(1, RAYS_PER_BLOCK // samples)))
    return seen
