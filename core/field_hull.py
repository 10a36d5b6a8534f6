# SPDX-License-Identifier: GPL-3.0-or-later
"""The convex hull of an object, seen from a centre inside it: where its ambient occlusion field begins."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .workers import Workers, slices

# Least thickness of the hull, as a fraction of the object's size. A sheet has no volume, and a field around it needs
# one: it begins this much off its sides.
THINNEST = 0.02
# Directions times facets that are looked at together: 32 MB a thread.
PRODUCTS_PER_PART = 2**22


@dataclass(frozen=True)
class Hull:
    """Of the triangles' corners. Object-space metres.

    centre  (3,) float64, the hull's centre of mass, so inside it
    radius  of the sphere about the centre that holds the object
    planes  (f, 3) float64: x from the centre is inside where planes @ x <= 1
    facets  (g, 3, 3) float64, from the centre: the corners of triangles that make up its surface
    """

    centre: NDArray[np.float64]
    radius: float
    planes: NDArray[np.float64]
    facets: NDArray[np.float64]

    @classmethod
    def of(cls, vertices: NDArray, triangles: NDArray) -> Hull:
        """The hull of those ``vertices`` (n, 3) that ``triangles`` (m, 3) use; flat ones are made THINNEST thick.

        Raises ValueError where there are no triangles, a vertex is not finite, or all lie in one place or on a line.
        """
        from scipy.spatial import ConvexHull

        triangles = np.asarray(triangles, np.intp).reshape(-1, 3)
        points = np.asarray(vertices, np.float64)[np.unique(triangles)]
        if not len(points):
            raise ValueError("an AO field needs an object with faces")
        if not np.isfinite(points).all():
            raise ValueError("an AO field needs vertices with finite coordinates")
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        size = float(np.ptp(points, axis=0).max())
        # Coordinates far from the origin leave few digits for the shape.
        if not size > 1e-12 * max(1.0, np.abs(points).max()):
            raise ValueError("an AO field needs an object with a size: its faces are all in one place")
        points = (points - middle) / size
        points = _thickened(points)
        hull = ConvexHull(points)
        corners = points[hull.simplices]
        # Centre of mass by the tetrahedra from the box's middle to the facets.
        volume = np.abs(np.linalg.det(corners))
        centre = (volume[:, None] * corners.sum(axis=1) / 4.0).sum(axis=0) / volume.sum()
        offset = -(hull.equations[:, 3] + hull.equations[:, :3] @ centre)
        # What rounding of the coordinates leaves is taken off, the sign of a zero too: on it the rays' tangents turn.
        planes = np.unique(np.round(hull.equations[:, :3] / offset[:, None], 12) + 0.0, axis=0)
        facets = (corners - centre) * size
        radius = float(np.linalg.norm(facets, axis=2).max())
        return cls(middle + size * centre, radius, planes / size, facets)

    @property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Least and largest coordinates of the hull, each (3,), from the centre."""
        return self.facets.min(axis=(0, 1)), self.facets.max(axis=(0, 1))

    def places_inside(self, count: int, seed: int) -> NDArray[np.float64]:
        """Random places (count, 3) from the centre, evenly over the volume."""
        random = np.random.default_rng(seed)
        volume = np.abs(np.linalg.det(self.facets))
        facet = self.facets[random.choice(len(volume), count, p=volume / volume.sum())]
        # Even over the facet (its triangle folded from a parallelogram), and from the centre to it.
        u, v = random.random((2, count, 1))
        u, v = np.where(u + v > 1.0, (1.0 - u, 1.0 - v), (u, v))
        on_facet = facet[:, 0] + u * (facet[:, 1] - facet[:, 0]) + v * (facet[:, 2] - facet[:, 0])
        return random.random((count, 1)) ** (1.0 / 3.0) * on_facet

    def distances(
        self, directions: NDArray, workers: Workers
    ) -> Generator[float, None, tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """r0 (k,), from the centre to the hull along unit ``directions`` (k, 3), and the outward unit normal (k, 3) of
        the plane there. Yields the fraction done."""
        most, plane = np.empty(len(directions)), np.empty(len(directions), np.intp)

        def look(part: slice) -> None:
            towards = directions[part] @ self.planes.T
            plane[part] = towards.argmax(axis=1)
            most[part] = towards.max(axis=1)

        yield from workers.mapping(look, slices(len(directions), max(1, PRODUCTS_PER_PART // len(self.planes))))
        normals = self.planes[plane]
        return 1.0 / most, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _thickened(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """``points`` (n, 3) of size 1, twice and apart where they lie in a plane or nearly so."""
    axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]
    along = points @ axes.T
    thickness = np.ptp(along, axis=0)
    order = np.argsort(thickness)
    if len(points) < 3 or thickness[order[1]] < 1e-9:
        raise ValueError("an AO field needs an object with an area: its faces lie on a line")
    thinnest = order[0]
    missing = THINNEST - thickness[thinnest]
    if missing <= 0.0:
        return points
    return np.concatenate((points - 0.5 * missing * axes[thinnest], points + 0.5 * missing * axes[thinnest]))
