# SPDX-License-Identifier: GPL-3.0-or-later
"""Twenty bounces of light between the points of a surface, each a sum over all that its rays see.

The reference that curves of AO are fitted to and that the bake's cache is judged by. Points link to the points that
their blocked rays end on (:mod:`.bounces`); at albedo 1 every bounce is one product with these links (Patapom,
"Improved Ambient Occlusion", Collecting Data). Each ray either finds the sky or is a link, and weights sum to 1, so
F_0 and a point's links sum to exactly 1: no energy is lost or made.

Memory: 5 bytes a ray and 12 a blocked one; there are at most MOST_RAYS.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .bounces import Links
from .height_map import HeightMap
from .rays import Obscurance, Occluders
from .sample_points import CornerTable, SurfacePoints, spread_points
from .sampling import frames, hemisphere_pattern, turns
from .surroundings import Ball, surrounding_points
from .workers import Workers, slices

MOST_RAYS = 2**26
RAYS_PER_BLOCK = 2**15
# What a turn of the normal by one radian counts against distance, in the mean distance between points: enough that no
# hit takes the light of the other side of a sheet.
FACING = 4.0


@dataclass(frozen=True)
class Simulation:
    """What n points see. ``alpha`` (n,) float64 uniform visibility; ``bounces`` (N + 1, n) float64, F_0 = k_A and the
    bounces after it at albedo 1, as fractions of the unoccluded irradiance."""

    alpha: NDArray[np.float64]
    bounces: NDArray[np.float64]

    def irradiance(self, albedo: ArrayLike) -> NDArray[np.float64]:
        """E/E0 after all bounces, in [F_0, 1]: (n,), or with more axes for ``albedo`` of shape (..., 1) or (..., n), in
        [0, 1].

        Bounces past the last go on as the last two do, but never so long that at albedo 1 all sum past 1.
        """
        *earlier, before, last = self.bounces
        left = 1.0 - self.bounces.sum(axis=0)
        ratio = np.divide(last, before, out=np.zeros_like(last), where=before > 0.0)
        most = np.divide(left, left + last, out=np.zeros_like(last), where=(last > 0.0) & (left > 0.0))
        ratio = np.minimum(ratio, most)
        rho = np.asarray(albedo, np.float64)
        light = last / (1.0 - rho * ratio)
        for bounce in (before, *reversed(earlier)):
            light = bounce + rho * light
        return light


def simulate_mesh(
    occluders: Occluders,
    corners: CornerTable,
    *,
    points: int,
    samples: int,
    bounces: int = 20,
    extent: float,
    seed: int = 0,
    threads: int | None = None,
) -> Generator[float, None, Simulation]:
    """Simulate a mesh from ``points`` spread evenly over its area, ``samples`` rays each; yields the fraction done.

    occluders  first the triangles of ``corners``, in their order, then what stands around them; perhaps a floor
    extent     as for :func:`core.visibility.trace_visibility`
    seed       turns the rays; equal seeds give equal bits, whatever the number of threads

    The result is of the points on the front. Backs of faces have points too, where light comes off them: sheets and
    sealed parts keep their two sides apart. A hit links to the nearest point that faces as it does. What stands around
    has points of its own, as many as the mesh at most (:mod:`.surroundings`).

    Raises ValueError for a mesh without area, occluders that do not have its triangles, fewer than one bounce, point or
    sample, and above MOST_RAYS, where each of ``points`` counts for two, or for four if anything stands around.
    """
    areas = corners.areas()
    own = len(areas)
    if own > len(occluders.triangles):
        raise ValueError("the occluders of a mesh begin with its own triangles, in their order")
    if not areas.sum() > 0.0:
        raise ValueError("bounces need a surface: the mesh has no faces with an area")
    alone = own == len(occluders.triangles) and occluders.ground_height is None
    _check(points, samples, bounces, (2 if alone else 4) * points * samples)

    front, spacing = spread_points(corners, points), float(np.sqrt(areas.sum() / points))
    sheets = [_Sheets(front, spacing)]
    if not alone:
        ball = Ball.about(front.positions)
        sheets.append(_Sheets(*surrounding_points(occluders, own, ball, spacing, points), ball))
    sides = SurfacePoints(
        *(np.concatenate([getattr(each.points, name) for each in sheets]) for name in ("positions", "normals"))
    )

    def point_at(triangle: NDArray, positions: NDArray, normals: NDArray) -> NDArray[np.intp]:
        found, first = np.full(len(triangle), -1), 0
        for each, chosen in zip(sheets, (triangle < own, triangle >= own), strict=False):
            if len(each.points):
                found[chosen] = first + each.nearest(positions[chosen], normals[chosen])
            first += len(each.points)
        return found

    alpha, direct, links = yield from trace_links(
        occluders, sides, point_at, wanted=points, samples=samples, extent=extent, seed=seed, threads=threads
    )
    return Simulation(alpha[:points], links.series(direct, bounces)[:, :points])


class _Sheets:
    """The points of a surface on its front, then on its back, about ``spacing`` apart once the ``ball`` has drawn them
    in; found by where they are and how they face."""

    def __init__(self, front: SurfacePoints, spacing: float, ball: Ball | None = None):
        from scipy.spatial import cKDTree

        self.points = SurfacePoints(np.tile(front.positions, (2, 1)), np.concatenate((front.normals, -front.normals)))
        self._facing, self._ball = FACING * spacing, ball
        self._tree = cKDTree(self._place(self.points.positions, self.points.normals))

    def _place(self, positions: NDArray, normals: NDArray) -> NDArray[np.float64]:
        at = positions if self._ball is None else self._ball.drawn_in(positions)
        return np.column_stack((at, self._facing * normals))

    def nearest(self, positions: NDArray, normals: NDArray) -> NDArray[np.intp]:
        return self._tree.query(self._place(positions, normals))[1]


def simulate_height_map(
    height_map: HeightMap, *, samples: int, bounces: int = 20, seed: int = 0, threads: int | None = None
) -> Generator[float, None, Simulation]:
    """Simulate a height map from each of its pixels, row by row, with ``samples`` rays; yields the fraction done.

    A hit on any of the tiles links to the pixel of the middle one that it repeats. ``seed`` as for
    :func:`simulate_mesh`. Raises ValueError for fewer than one bounce or sample, and above MOST_RAYS.
    """
    _check(len(height_map), samples, bounces, len(height_map) * samples)
    alpha, direct, links = yield from trace_links(
        height_map.occluders(),
        height_map.points(),
        lambda triangle, positions, normals: height_map.pixels_at(positions),
        wanted=len(height_map),
        samples=samples,
        extent=height_map.extent,
        seed=seed,
        threads=threads,
    )
    return Simulation(alpha, links.series(direct, bounces))


def trace_links(
    occluders: Occluders,
    points: SurfacePoints,
    point_at: Callable[[NDArray, NDArray, NDArray], NDArray[np.integer]],
    *,
    wanted: int,
    samples: int,
    extent: float,
    seed: int,
    threads: int | None,
) -> Generator[float, None, tuple[NDArray[np.float64], NDArray[np.float64], Links]]:
    """alpha (n,), direct light F_0 (n,) and links of n ``points``; yields the fraction done.

    point_at  the points (k,) that stand for hits on triangles (k,), as :class:`core.rays.Hits` numbers them, at world
              positions (k, 3), on sides with unit normals (k, 3); -1: none does
    wanted    the first so many points are traced, then those that light comes from; others have no light and no links

    Closing the generator stops after the blocks in flight.
    """
    pattern = hemisphere_pattern(samples)
    local, weights = pattern.directions.astype(np.float32), np.column_stack((pattern.uniform, pattern.cosine))
    target = np.full((len(points), samples), -1, np.int32)
    seen = np.zeros((len(points), 2))
    block = max(1, RAYS_PER_BLOCK // samples)

    def trace(chosen: NDArray[np.intp]) -> int:
        positions, normals, *_ = points.at(chosen)
        frame = frames(normals[:, 0], turns(points.number(chosen), seed))
        directions = np.matmul(local, frame).reshape(-1, 3)
        start = occluders.origins(positions, normals, extent)[:, 0].T.astype(np.float32)
        origins = np.repeat(start, samples, axis=0)
        hits = occluders.hits(origins, directions, Obscurance())
        blocked = np.flatnonzero(hits.triangle >= 0)
        at = origins[blocked] + hits.distance[blocked, None] * directions[blocked]
        found = np.full(len(origins), -1, np.int32)
        world = at / occluders.scale + occluders.centre
        found[blocked] = point_at(hits.triangle[blocked], world, hits.normals(blocked))
        target[chosen] = found.reshape(len(chosen), samples)
        seen[chosen] = hits.visible.reshape(len(chosen), samples) @ weights
        return len(chosen)

    order = points.order()
    known, done = np.zeros(len(points), bool), 0
    missing = np.arange(len(points)) < wanted
    with Workers(threads) as workers:
        while missing.any():
            chosen = order[missing[order]]
            for count in workers.run(trace, [chosen[part] for part in slices(len(chosen), block)]):
                yield (done + count) / len(points)
            done += len(chosen)
            known |= missing
            # One more place for -1, the sky.
            lit = np.zeros(len(points) + 1, bool)
            for part in slices(len(chosen), block):
                lit[target[chosen[part]]] = True
            missing = lit[:-1] & ~known
    links = Links(target, np.broadcast_to(pattern.cosine, target.shape))
    return seen[:, 0], seen[:, 1], links


def _check(points: int, samples: int, bounces: int, rays: int) -> None:
    if min(points, samples, bounces) < 1:
        raise ValueError(f"one point, sample and bounce or more are needed, not {points}, {samples} and {bounces}")
    if rays > MOST_RAYS:
        raise ValueError(
            f"{rays} rays pass the {MOST_RAYS} that memory is meant for: "
            f"use at most {max(1, MOST_RAYS * samples // rays)} samples, or fewer points or pixels"
        )
