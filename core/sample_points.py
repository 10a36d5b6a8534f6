# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start: points at vertices, or places spread over the area of texels.

Both answer the ray loop alike. A point has K places on the surface that share its rays evenly: a vertex one, a texel as
many as it takes to stand for its area. Positions and normals come a block at a time, axis first, so that numpy runs
along the points and memory does not follow the image.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from .morton import morton_order
from .rasterise import Texels
from .surface import INSET, Surface
from .terminator import Polygons, Terminator

# Side of the square of texels that is traced together: most of its texels lie on one piece of the surface.
TILE = 32
# Points all over a surface from which the light around it is found.
PROBES = 2**16
# The root of x^3 = x + 1, on which the R2 sequence rests (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
# Sequences").
PLASTIC = 1.32471795724474602596


class Start(NamedTuple):
    """Where the rays of some points start, at all their places.

    positions, normals  (3, places, b) float64, world space; unit normals
    lift                (places, b) float, how far along those normals (:mod:`core.terminator`); None: nowhere
    missing             (places, b) bool, places that have no surface; None: all have
    """

    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    lift: NDArray[np.floating] | None = None
    missing: NDArray[np.bool_] | None = None


class SamplePoints(Protocol):
    """n points of a surface, each with ``places`` positions that share its rays."""

    places: int

    def __len__(self) -> int: ...

    def order(self) -> NDArray[np.intp]:
        """All points, (n,), so that neighbours in the list are neighbours on the surface."""

    def number(self, block: NDArray[np.intp]) -> NDArray[np.integer]:
        """What the points (b,) are called, whoever traces them and with which others: it turns their pattern."""

    def at(self, block: NDArray[np.intp]) -> Start:
        """Where the rays of the points (b,) start."""


class SurfacePoints:
    """One place a point.

    positions, normals  (n, 3) float, world space; normals of unit length
    lift                (n,) float, how far along the normals rays start, or None
    """

    places = 1

    def __init__(self, positions: NDArray, normals: NDArray, lift: NDArray | None = None):
        self.positions = np.asarray(positions, np.float64)
        self.normals = np.asarray(normals, np.float64)
        self._lift = lift

    def __len__(self) -> int:
        return len(self.positions)

    def order(self) -> NDArray[np.intp]:
        return morton_order(self.positions)

    def number(self, block: NDArray[np.intp]) -> NDArray[np.intp]:
        return block

    def at(self, block: NDArray[np.intp]) -> Start:
        lift = None if self._lift is None else self._lift[None, block]
        return Start(self.positions[block].T[:, None], self.normals[block].T[:, None], lift)


class ChosenPoints:
    """Some ``points``, those that the numbers ``chosen`` (k,) name, in that order."""

    def __init__(self, points: SamplePoints, chosen: NDArray[np.intp]):
        self._points, self._chosen = points, chosen
        self.places = points.places

    def __len__(self) -> int:
        return len(self._chosen)

    def order(self) -> NDArray[np.intp]:
        return np.arange(len(self._chosen))

    def number(self, block: NDArray[np.intp]) -> NDArray[np.integer]:
        return self._points.number(self._chosen[block])

    def at(self, block: NDArray[np.intp]) -> Start:
        return self._points.at(self._chosen[block])


class TexelPoints:
    """The ``texels`` of an image of ``width``, on a surface whose triangles they name."""

    def __init__(self, corners: CornerTable, texels: Texels, width: int):
        self._corners, self._texels, self._width = corners, texels, width
        self.places = texels.triangle.shape[1]

    def __len__(self) -> int:
        return len(self._texels.texel)

    def order(self) -> NDArray[np.intp]:
        row, column = np.divmod(self._texels.texel, self._width)
        tile = (row // TILE) * -(-self._width // TILE) + column // TILE
        # 16 bits where they do: numpy then sorts by radix.
        return np.argsort((tile - tile.min(initial=0)).astype(np.min_scalar_type(tile.max(initial=0))), kind="stable")

    def number(self, block: NDArray[np.intp]) -> NDArray[np.integer]:
        return self._texels.texel[block]

    def at(self, block: NDArray[np.intp]) -> Start:
        v, w = self._texels.weights[block].T.astype(np.float64, order="C")
        return self._corners.start(self._texels.triangle[block].T.astype(np.intp, order="C"), v, w)


def spread_points(corners: CornerTable, count: int) -> SurfacePoints:
    """``count`` points spread evenly over the area of a surface, as :func:`spread` does."""
    positions, normals = corners.at(*spread(corners.areas(), count))
    return SurfacePoints(positions.T, normals.T)


def spread(areas: NDArray[np.float64], count: int) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """``count`` points spread evenly over triangles with these ``areas`` (m,): the triangle of each (count,), and the
    weights of its second and third corner.

    Triangles get theirs by equal steps of area, and in a triangle they follow Roberts' R2 sequence, folded over the
    diagonal of the unit square.
    """
    index = np.arange(count)
    area = np.cumsum(areas)
    triangle = np.searchsorted(area, (index + 0.5) / max(count, 1) * area[-1], side="right").clip(0, len(area) - 1)
    v, w = (0.5 + np.outer(1.0 / PLASTIC ** np.array((1.0, 2.0)), index)) % 1.0
    over = v + w > 1.0
    v[over], w[over] = 1.0 - v[over], 1.0 - w[over]
    return triangle, v, w


def texel_places(samples: int) -> int:
    """How many places of a texel share its ``samples`` rays: as many as each has rays, from 1 to 16.

    Where triangles are smaller than texels, places count for more than rays (`make bench ARGS=texel_error`).
    """
    return max(1, min(16, math.isqrt(samples)))


class CornerTable:
    """Positions and normals of the triangles' corners of a :class:`Surface`, laid out to be looked up fast.

    Each (3 corners, 3 axes, m) float64.
    """

    def __init__(self, surface: Surface):
        self._positions = _corners_first(surface.vertices[surface.vertex_triangles])
        self._normals = _corners_first(surface.corner_normals[surface.triangles])
        self._terminator = Terminator(self._positions, self._normals)
        corners = surface.vertices[surface.corner_vertex]
        self._polygons = Polygons(corners, surface.face_start, surface.face_size, surface.triangles[:, 0])

    def areas(self) -> NDArray[np.float64]:
        """Of the triangles, (m,)."""
        a, b, c = self._positions
        return 0.5 * np.sqrt(np.square(np.cross(b - a, c - a, axis=0)).sum(axis=0))

    def at(
        self, triangle: NDArray[np.integer], v: NDArray[np.float64], w: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions and unit normals, each (3, ...), at the barycentric weights ``v`` and ``w`` of the second and third
        corner, kept off the triangles' edges by :data:`INSET`. All arguments have one shape (...)."""
        return self._at(triangle.astype(np.intp, copy=False), _inset(v), _inset(w))

    def start(self, triangle: NDArray[np.integer], v: NDArray[np.float64], w: NDArray[np.float64]) -> Start:
        """Where rays from the points of :meth:`at` start."""
        triangle, v, w = triangle.astype(np.intp, copy=False), _inset(v), _inset(w)
        positions, normals = self._at(triangle, v, w)
        if self._terminator.is_flat:
            return Start(positions, normals)
        highest, most = self._terminator.heights(triangle, v, w)
        if self._polygons:
            self._polygons.raise_highest(highest, triangle, positions, normals)
        return Start(positions, normals, np.maximum(np.minimum(highest, most, out=highest), 0.0, out=highest))

    def _at(self, triangle, v, w) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        u = 1.0 - v - w
        positions = self._interpolate(self._positions, triangle, u, v, w)
        normals = self._interpolate(self._normals, triangle, u, v, w)
        length = np.sqrt(np.square(normals).sum(axis=0))
        flat = length < 1e-6
        if flat.any():
            # Where the corners' normals cancel out: the triangle's own.
            a, b, c = (np.stack([axis[triangle[flat]] for axis in corner]) for corner in self._positions)
            normals[:, flat] = np.cross(b - a, c - a, axis=0)
            length = np.sqrt(np.square(normals).sum(axis=0))
        normals /= np.maximum(length, 1e-30)
        normals[2][length < 1e-30] = 1.0
        return positions, normals

    @staticmethod
    def _interpolate(table, triangle, u, v, w) -> NDArray[np.float64]:
        (a, b, c), result = table, np.empty((3, *triangle.shape))
        for axis in range(3):
            np.multiply(a[axis].take(triangle), u, out=result[axis])
            result[axis] += b[axis].take(triangle) * v
            result[axis] += c[axis].take(triangle) * w
        return result


def _inset(weight: NDArray[np.float64]) -> NDArray[np.float64]:
    return (1.0 - INSET) * weight + INSET / 3.0


def _corners_first(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m, 3 corners, 3 axes) as (3 corners, 3 axes, m)."""
    return np.ascontiguousarray(np.moveaxis(corners, 0, 2))
