# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of all bounces on the surfaces around what is baked: a radiosity cache, to be gathered from its points.

Rays from some of the points find the cells (:mod:`.cells`) that light can come from. Rays from each of these link them
to one another, and to coarser cells for what only cells see (:mod:`.cell_rays`); sums over the links give the light of
each bounce (:mod:`.bounces`). "Final gathering" then takes one more bounce at every point (Reichert 1992; Christensen
1999, "Faster Photon Map Global Illumination"), so that cells may be coarse: what a point gets from them is a mean over
many.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .albedo import Albedo
from .bounces import Links
from .cell_rays import CellRays, FoundLinks, Met, Pieces, seen_from
from .cells import CellKeys, Cells, Grid, find_in
from .faces import Faces
from .multibounce import TAIL_ALBEDO
from .rays import Obscurance, Occluders
from .sample_points import SurfacePoints
from .workers import Workers, mapped

# Cells that the points see: about one for so many rays of the bake, within bounds. Coarse ones are half as many.
RAYS_PER_CELL = 256
FEWEST_CELLS, MOST_CELLS = 2**13, 2**17
# Side of the large cells, in sides of those that points see.
LARGE_CELL = 8.0
# Hits that the size of cells is chosen by, for each that is wanted.
HITS_PER_CELL = 4
# Nearer than this part of a cell's side its light is not that of the hit, unless more hits than SHARE are so near.
NEAR, NEAR_SHARE = 0.5, 0.1
# Where in the time of all the three rounds of rays begin and end, as far as that can be told before.
ROUNDS = (0.0, 0.13), (0.2, 0.53), (0.64, 0.9)
# Light is stored in steps of this, so that sums with the pattern's weights stay exact (sampling.Pattern).
STEP = 2.0**-12


@dataclass(frozen=True)
class LightCache:
    """Light that n cells send back, as parts of the unoccluded irradiance.

    cells   those that points see, then those that only cells see, then large ones with the means of both, for hits
            between them
    light   (3, n + 1) float64, multiples of STEP in [0, 1]; last the mean of all cells, for hits in none.
            Without ``albedo``: F0, F1 and, at albedo TAIL_ALBEDO, the light of all bounces, off white surfaces.
            With it: red, green and blue of all bounces
    near    distance below which hits do not take a cell's light, in the units that Embree sees
    albedo  base colours of the occluders' triangles, or None
    """

    cells: Sequence[Cells]
    light: NDArray[np.float64]
    near: float
    albedo: Albedo | None = None

    def find(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int32]:
        """Cell (k,) of hits on ``side`` (k,) of triangles at ``positions`` (k, 3); NONE where there is none."""
        return find_in(self.cells, side, positions)

    def sent_by(
        self, direct: NDArray, gathered: NDArray, triangle: NDArray, u: NDArray, v: NDArray
    ) -> NDArray[np.float64]:
        """The light (3, k) that hits send back, in place of a cell's, which see ``direct`` light (k,) and have
        ``gathered`` (3, k) from cells; on ``triangle`` (k,), where its corners have the weights ``u`` and ``v`` (k,).
        """
        if self.albedo is None:
            sent = np.stack((direct, gathered[0], direct + TAIL_ALBEDO * gathered[2]))
        else:
            sent = self.albedo.at(triangle, u, v).T * (direct + gathered)
        return np.rint(sent / STEP) * STEP


def cells_wanted(rays: int) -> int:
    """How many cells the points of a bake that traces so many ``rays`` are to see."""
    return int(np.clip(rays // RAYS_PER_CELL, FEWEST_CELLS, MOST_CELLS))


def build_light_cache(
    occluders: Occluders,
    probes: SurfacePoints,
    rays: int,
    *,
    extent: float,
    albedo: Albedo | None = None,
    obscurance: Obscurance | None = None,
    seed: int = 0,
    threads: int | None = None,
) -> Generator[float, None, LightCache]:
    """The cache for a bake that traces so many ``rays``, from points like ``probes``; yields the fraction done.

    extent  as for :func:`core.visibility.trace_visibility`
    albedo  base colours of the occluders' triangles: the cache is then of red, green and blue light

    Memory does not follow the points or rays: while it is built, about 3 kB for each of at most MOST_CELLS cells and 41
    bytes a triangle, of which 24 stay. Closing the generator stops after the blocks in flight.
    """
    obscurance = obscurance or Obscurance()
    wanted = cells_wanted(rays)
    centre, reach = _box(occluders, probes)
    with Workers(threads) as workers:
        faces = Faces.of(occluders, workers)
        trace = CellRays(occluders, extent, obscurance, seed, workers)
        met = yield from mapped(seen_from(trace, probes, wanted), partial(_between, *ROUNDS[0]))
        near = float(np.quantile(met.distance, NEAR_SHARE)) if len(met) else 0.0

        grid = _grid(faces, centre, reach, met, wanted)
        near, large_grid = min(near, NEAR * grid.side), replace(grid, side=LARGE_CELL * grid.side)
        pieces = Pieces.of(met, CellKeys(faces, grid).of_hits(met.side, met.position), first=0)
        cells = [Cells(faces, grid, pieces.key, workers)]
        links, met = yield from mapped(trace.linked(pieces, cells), partial(_between, *ROUNDS[1]))

        # What only cells see; what these see beyond is left out.
        grid = _grid(faces, centre, reach, met, wanted // 2)
        further = Pieces.of(met, CellKeys(faces, grid).of_hits(met.side, met.position), first=len(pieces.key))
        cells.append(Cells(faces, grid, further.key, workers))
        links.target.reshape(-1)[met.ray] = find_in(cells, met.side, met.position)
        further_links, _ = yield from mapped(trace.linked(further, cells), partial(_between, *ROUNDS[2]))

        both = pieces, further
        colours = None if albedo is None else np.concatenate([_colours(each, albedo) for each in both])
        light = _light(links.joined(further_links), colours)
        key, means = _means(CellKeys(faces, large_grid), both, light)
        cells.append(Cells(faces, large_grid, key, workers))
    overall = light.mean(axis=1, keepdims=True) if light.size else np.zeros((3, 1))
    light = np.rint(np.concatenate((light, means, overall), axis=1) / STEP) * STEP
    return LightCache(cells, light, near, albedo)


def _between(begin: float, end: float, done: float) -> float:
    return begin + (end - begin) * done


def _box(occluders: Occluders, probes: SurfacePoints) -> tuple[NDArray[np.float64], float]:
    """Centre (3,) of the box about ``probes`` and half its longest side, in the units that Embree sees."""
    at = (probes.positions - occluders.centre) * occluders.scale
    low, high = at.min(axis=0), at.max(axis=0)
    return 0.5 * (low + high), max(0.5 * float((high - low).max()), 1e-6)


def _grid(faces: Faces, centre: NDArray, reach: float, met: Met, wanted: int) -> Grid:
    """The finest grid that sorts the hits ``met`` into no more cells than are about ``wanted``."""
    # So many hits, chosen evenly, meet nearly all cells if these are seen alike, and most of them if not.
    some = met[:: max(1, len(met) // (HITS_PER_CELL * wanted))]
    few = (1.0 - np.exp(-HITS_PER_CELL)) * wanted
    finest, coarsest = np.log2(reach) - 12.0, np.log2(reach)
    for _ in range(8):
        middle = 0.5 * (finest + coarsest)
        keys = CellKeys(faces, Grid(centre, reach, 2.0**middle)).of_hits(some.side, some.position)
        if len(np.unique(keys)) > few:
            finest = middle
        else:
            coarsest = middle
    return Grid(centre, reach, 2.0**coarsest)


def _colours(pieces: Pieces, albedo: Albedo) -> NDArray[np.float64]:
    """Mean base colours (n, 3) of the cells ``pieces``."""
    met = pieces.met
    return pieces.means(albedo.at(met.side >> 1, met.u, met.v)) if len(met) else np.empty((0, 3))


def _light(found: FoundLinks, colours: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """The three fields (3, n) of :attr:`LightCache.light` for cells with the links ``found``, and where there are any,
    base ``colours`` (n, 3)."""
    # Rays that end in no cell see what the cell's others see.
    blocked = found.weight.sum(axis=1)
    linked = np.where(found.target >= 0, found.weight, 0.0).sum(axis=1)
    more = np.divide(blocked, linked, out=np.zeros_like(blocked), where=linked > 0.0)
    links = Links(found.target, found.weight * more[:, None])
    if colours is None:
        return np.stack((found.sky, links @ found.sky, links.total(found.sky, TAIL_ALBEDO)))
    return (colours * links.total(np.repeat(found.sky[:, None], 3, axis=1), colours)).T


def _means(
    keys: CellKeys, pieces: Sequence[Pieces], light: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Larger cells' ``keys`` (m,), and the mean ``light`` (3, m) of the ``pieces`` in each, by how often they are met;
    a piece lies where its first hit does."""
    first = [each.met[each.start] for each in pieces]
    of_pieces = np.concatenate([keys.of_hits(met.side, met.position) for met in first])
    key, larger = np.unique(of_pieces, return_inverse=True)
    count = np.concatenate([each.count for each in pieces])
    sums = [np.bincount(larger, field * count, len(key)) for field in light]
    return key, np.stack(sums) / np.bincount(larger, count, len(key))
