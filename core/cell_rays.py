# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays that find the cells of the light cache, and rays from cells that link them."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .cells import NONE, Cells, find_in, side_of
from .morton import morton_order
from .rays import Obscurance, Occluders
from .sample_points import SurfacePoints
from .sampling import carried_frames, deal, frames, hemisphere_pattern, turns
from .workers import Workers, slices

PROBE_RAYS = 16  # for each cell that is wanted
# Rays of a cell, from several places of it, and patterns that cells take in turn.
CELL_RAYS, CELL_PLACES, PATTERNS = 24, 8, 16
RAYS_PER_BLOCK = 2**15
# Probes and cells turn the pattern by numbers of their own.
PROBE_SEED, CELL_SEED = 0x5EED0001, 0x5EED0002


@dataclass(frozen=True)
class Met:
    """What k rays met that were blocked.

    ray       (k,) int64, which of all rays it was
    position  (k, 3) float32, in the units that Embree sees
    normal    (k, 3) float32, unit length, of the side that is met
    side      (k,) int64, that side (:func:`.cells.side_of`)
    u, v      (k,) float32, weights of that triangle's second and third corner
    distance  (k,) float32, in the units that Embree sees
    """

    ray: NDArray[np.int64]
    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    side: NDArray[np.int64]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    distance: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.side)

    def __getitem__(self, index) -> Met:
        return _each(Met, lambda name: getattr(self, name)[index])


@dataclass(frozen=True)
class FoundLinks:
    """What n cells see: the sky's light, sky (n,); the cell that each ray meets, target (n, R) int32, NONE where it is
    the sky or no known cell; and what part of that cell's light it brings, weight (n, R)."""

    sky: NDArray[np.float64]
    target: NDArray[np.int32]
    weight: NDArray[np.float64]

    def joined(self, more: FoundLinks) -> FoundLinks:
        """These cells, then ``more``."""
        return _joined(FoundLinks, (self, more))


@dataclass(frozen=True)
class Pieces:
    """n cells and the hits in them: cell ``first`` + i has the key (n,) and the count (n,) hits of ``met`` from its
    start (n,) on."""

    key: NDArray[np.int64]
    met: Met
    start: NDArray[np.intp]
    count: NDArray[np.intp]
    first: int

    @classmethod
    def of(cls, met: Met, key: NDArray[np.int64], first: int) -> Pieces:
        """The cells of the hits ``met`` (k,), which have the ``key`` (k,)."""
        order = np.argsort(key, kind="stable")
        met = met[order]
        key, start, count = np.unique(key[order], return_index=True, return_counts=True)
        # Along a curve, so that rays traced together meet the same part of the tree.
        along = morton_order(met.position[start])
        return cls(key[along], met, start[along], count[along], first)

    def means(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Means (n, 3) over each cell's hits of ``values`` (k, 3) of the hits ``met``."""
        sums = np.add.reduceat(values, np.sort(self.start), axis=0)[np.argsort(np.argsort(self.start))]
        return sums / self.count[:, None]

    def starts(self, part: slice) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and normals (3, CELL_PLACES, b) of hits all over each of the cells of ``part``."""
        index = self.start[part] + np.arange(CELL_PLACES)[:, None] * self.count[part] // CELL_PLACES
        return tuple(np.moveaxis(each[index], 2, 0).astype(np.float64) for each in (self.met.position, self.met.normal))


@dataclass(frozen=True)
class CellRays:
    """How rays are traced: against what, off a surface of what size, for which blockers, with which seed, by whom."""

    occluders: Occluders
    extent: float
    obscurance: Obscurance
    seed: int
    workers: Workers

    def met(self, origins: NDArray[np.float32], directions: NDArray[np.float32], first: int) -> tuple[NDArray, Met]:
        """Visibility (r,) of rays (r, 3), numbered from ``first`` on, and what those that are blocked meet."""
        hits = self.occluders.hits(origins, directions, self.obscurance)
        ray = np.flatnonzero(hits.triangle >= 0)
        distance = hits.distance[ray].astype(np.float32)
        position = origins[ray] + distance[:, None] * directions[ray]
        side = side_of(hits.triangle[ray], hits.behind[ray])
        return hits.visible, Met(first + ray, position, hits.normals(ray), side, hits.u[ray], hits.v[ray], distance)

    def linked(self, pieces: Pieces, cells: Sequence[Cells]) -> Generator[float, None, tuple[FoundLinks, Met]]:
        """The links of ``pieces`` to ``cells``, and the hits that lie in none: their ``ray`` is an index into the links
        as one array. Yields the fraction done."""
        patterns = [hemisphere_pattern(CELL_RAYS, shift=(index + 0.5) / PATTERNS) for index in range(PATTERNS)]
        dealt = [deal(pattern, CELL_PLACES) for pattern in patterns]
        directions = np.stack([each for each, _ in dealt]).astype(np.float32)
        weights = np.stack([each[:, :, 0].reshape(-1) for _, each in dealt])
        rays = weights.shape[1]

        def trace(part: slice) -> tuple[FoundLinks, Met]:
            number = pieces.first + np.arange(part.start, part.stop)
            positions, normals = pieces.starts(part)
            frame = carried_frames(normals, turns(number, self.seed ^ CELL_SEED))
            frame = np.ascontiguousarray(np.moveaxis(frame, 3, 0))
            turned = np.matmul(directions[number % PATTERNS], frame).reshape(-1, 3)
            start = self.occluders.off_surface(positions, normals, self.extent).T.astype(np.float32, order="C")
            origins = np.repeat(start.reshape(-1, 3), directions.shape[2], axis=0)
            visible, met = self.met(origins, turned, first=part.start * rays)
            target = np.full(len(origins), NONE, np.int32)
            known = find_in(cells, met.side, met.position)
            target[met.ray - part.start * rays] = known
            weight, visible = weights[number % PATTERNS], visible.reshape(-1, rays)
            sky = (visible * weight).sum(axis=1)
            return FoundLinks(sky, target.reshape(-1, rays), (1.0 - visible) * weight), met[known == NONE]

        if not len(pieces.key):
            return FoundLinks(np.empty(0), np.empty((0, rays), np.int32), np.empty((0, rays))), pieces.met
        parts = yield from self.workers.mapping(trace, slices(len(pieces.key), max(1, RAYS_PER_BLOCK // rays)))
        return tuple(
            _joined(kind, each) for kind, each in zip((FoundLinks, Met), zip(*parts, strict=True), strict=True)
        )


def seen_from(trace: CellRays, probes: SurfacePoints, wanted: int) -> Generator[float, None, Met]:
    """What about PROBE_RAYS rays for each of the ``wanted`` cells meet, from all over the ``probes``; yields the
    fraction done."""
    order = probes.order()
    order = order[:: max(1, len(order) // wanted)]
    rays = int(np.clip(PROBE_RAYS * wanted // max(1, len(order)), PROBE_RAYS, 1024))
    local = hemisphere_pattern(rays, "cosine").directions.astype(np.float32)

    def seen(part: slice) -> Met:
        positions, normals, *_ = probes.at(order[part])
        frame = frames(normals[:, 0], turns(order[part], trace.seed ^ PROBE_SEED))
        directions = np.matmul(local, frame).reshape(-1, 3)
        start = trace.occluders.origins(positions, normals, trace.extent)[:, 0].T.astype(np.float32)
        _, met = trace.met(np.repeat(start, rays, axis=0), directions, first=part.start * rays)
        return met

    parts = slices(len(order), max(1, RAYS_PER_BLOCK // rays))
    return _joined(Met, (yield from trace.workers.mapping(seen, parts)))


def _each(kind, field):
    """``kind`` with what ``field`` says of each name."""
    return kind(*(field(name) for name in kind.__dataclass_fields__))


def _joined(kind, parts):
    """One ``kind`` of the arrays of several, one after another."""
    return _each(kind, lambda name: np.concatenate([getattr(part, name) for part in parts]))
