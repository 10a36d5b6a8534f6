# SPDX-License-Identifier: GPL-3.0-or-later
"""Which texels a UV layout touches, and which points of the surface each of them shows.

A texel is sampled over its area, at places that stand on scanlines of their own (:mod:`.scan_conversion`), so that
triangles smaller than a texel count as well. Conservative: a texel that a UV triangle touches without holding one of
its places shows the point next to it (:mod:`.texel_rim`), so that bilinear filtering never picks up background.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .scan_conversion import Trapezoids, owners, reach, trapezoids
from .texel_rim import rim
from .workers import Workers

# What a caller holds at once: 12 to 20 bytes each in Texels, and twice that while they are put together.
PLACES_PER_BAND = 2**22
# What one thread works on: about 40 MB of temporaries. Smaller pieces leave more of the time to Python's lock.
PLACES_PER_TASK = 2**18
# More threads than this wait for Python's lock.
MOST_THREADS = 8


@dataclass(frozen=True)
class Texels:
    """k texels of an image and the surface points at the K places of each.

    texel     (k,) int64, row * width + column, row 0 at v = 0; ascending
    triangle  (k, K) int32
    weights   (k, K, 2) float32, barycentric weights of that triangle's second and third corner, >= 0, sum <= 1
    """

    texel: NDArray[np.int64]
    triangle: NDArray[np.int32]
    weights: NDArray[np.float32]

    def __getitem__(self, part: slice) -> Texels:
        """A slice of the texels."""
        return Texels(self.texel[part], self.triangle[part], self.weights[part])


def rasterise(
    triangle_uv: NDArray,
    width: int,
    height: int,
    places: int = 1,
    rows: tuple[int, int] | None = None,
    threads: int | None = None,
) -> Texels:
    """Texels in image ``rows`` [first, last) that ``triangle_uv`` (m, 3, 2) touches, ``places`` surface points each.

    Only the tile [0, 1]^2 is filled. Where triangles overlap at a place, the first wins. Places outside the surface
    repeat those of their texel that are inside. Triangles without UV area, or with coordinates that are not finite, own
    nothing. ``threads`` defaults to the processors there are; the result does not depend on it, nor on ``rows``.
    """
    first, last = rows or (0, height)
    layout = _prepare(triangle_uv, width, height, places, first, last)
    tasks = [(first + low, first + high) for low, high in bands(width, last - first, places, PLACES_PER_TASK)]
    with Workers(min(threads or os.cpu_count() or 1, MOST_THREADS)) as workers:
        parts = workers.map(layout.texels, tasks)
    return Texels(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def bands(width: int, height: int, places: int = 1, limit: int = PLACES_PER_BAND) -> Iterator[tuple[int, int]]:
    """Row ranges [first, last) of at most ``limit`` places (at least one row), so that memory does not follow the
    image."""
    step = max(1, limit // (width * places))
    for first in range(0, height, step):
        yield first, min(first + step, height)


def place_pattern(places: int) -> NDArray[np.float64]:
    """Places (K, 2) in the unit square, ascending in y, each alone in its column and its row of a K x K grid.

    The columns are the ranks of the multiples of the golden ratio: a Fibonacci lattice where K is a Fibonacci number.
    """
    order = np.argsort(np.arange(places) * ((np.sqrt(5.0) - 1.0) / 2.0) % 1.0)
    pattern = np.empty((places, 2))
    pattern[order, 0] = pattern[:, 1] = (np.arange(places) + 0.5) / places
    return pattern


@dataclass(frozen=True)
class _Layout:
    """The triangles that reach into some rows, in texels.

    index       (m,) int32, ascending
    x, y        (3, m) float64, their corners
    boxes       (4, m) int32, rows [low, high) and columns [start, end) that they reach
    to_weights  (2, 3, m) float64: the point (x, y) has second and third weight [0] x + [1] y + [2]
    """

    width: int
    pattern: NDArray[np.float64]
    index: NDArray[np.int32]
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    boxes: NDArray[np.int32]
    to_weights: NDArray[np.float64]
    trapezoids: Trapezoids

    def texels(self, rows: tuple[int, int]) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]:
        """The fields of :class:`Texels` for ``rows`` [first, last)."""
        first, width, places = rows[0], self.width, len(self.pattern)
        owner = owners(self.trapezoids, rows, width, self.pattern[:, 0])
        held = owner >= 0
        covered, full = held.any(axis=1), held.all(axis=1).reshape(-1)
        rim_texel, rim_triangle, rim_weights = rim(self.x, self.y, self.boxes, ~covered, first)
        covered = covered.reshape(-1)
        covered[rim_texel] = True

        texel = np.flatnonzero(covered)
        triangle = owner.transpose(0, 2, 1).reshape(-1, places).take(texel, axis=0)
        at_rim = np.searchsorted(texel, rim_texel)
        triangle[at_rim] = rim_triangle[:, None]
        row, column = np.divmod(texel, width)
        x, y = column[:, None] + self.pattern[:, 0], (row + first)[:, None] + self.pattern[:, 1]
        partly = np.flatnonzero(~full.take(texel))
        place = _inside(triangle.take(partly, axis=0) >= 0)
        triangle[partly] = np.take_along_axis(triangle.take(partly, axis=0), place, axis=1)
        x[partly] = column[partly, None] + self.pattern[place, 0]
        y[partly] = (row + first)[partly, None] + self.pattern[place, 1]
        weights = self._weights(triangle, x, y)
        weights[at_rim] = rim_weights[:, None]
        return texel + first * width, self.index.take(triangle), weights

    def _weights(self, triangle: NDArray, x: NDArray, y: NDArray) -> NDArray[np.float32]:
        """Weights (k, K, 2) of the points ``x``, ``y`` (k, K) in the triangles (k, K) that hold them."""
        weights = np.empty((*triangle.shape, 2), np.float32)
        triangle = triangle.astype(np.intp)
        below = np.float32(1.0)
        for i, (along_x, along_y, constant) in enumerate(self.to_weights):
            weight, term = along_x.take(triangle), along_y.take(triangle)
            weight *= x
            term *= y
            weight += term
            weight += constant.take(triangle)
            # Rounding may leave a point on an edge just outside.
            weights[:, :, i] = np.minimum(np.maximum(weight, 0.0, out=weight), below, out=weight)
            below = 1.0 - weights[:, :, 0]
        return weights


def _prepare(triangle_uv: NDArray, width: int, height: int, places: int, first: int, last: int) -> _Layout:
    """The triangles with area that reach into the tile's rows [first, last)."""
    uv = np.asarray(triangle_uv, np.float64).reshape(-1, 3, 2)
    y = np.multiply(uv[:, :, 1].T, height, order="C")
    near = np.flatnonzero((y.max(axis=0) > first) & (y.min(axis=0) < last))
    x, y = np.multiply(uv[near, :, 0].T, width, order="C"), y.take(near, axis=1)
    with np.errstate(invalid="ignore", over="ignore"):
        area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])
    inside = (x.max(axis=0) > 0.0) & (x.min(axis=0) < width)
    kept = np.flatnonzero(inside & (np.abs(area) > 1e-12) & np.isfinite(area))
    x, y, area = x.take(kept, axis=1), y.take(kept, axis=1), area.take(kept)
    second = np.stack((y[2] - y[0], x[0] - x[2])) / area
    third = np.stack((y[0] - y[1], x[1] - x[0])) / area
    to_weights = np.array([(*along, -(along[0] * x[0] + along[1] * y[0])) for along in (second, third)])
    return _Layout(
        width,
        place_pattern(places),
        near.take(kept).astype(np.int32),
        x,
        y,
        np.stack((*reach(y, first, last), *reach(x, 0, width))),
        to_weights,
        trapezoids(x, y * places, width, first * places, last * places),
    )


def _inside(held: NDArray[np.bool_]) -> NDArray[np.intp]:
    """For each place (k, K), itself where ``held``, else one that is, each of a texel's as often as the others."""
    place = np.tile(np.arange(held.shape[1]), (len(held), 1))
    count = held.sum(axis=1)
    of, to_fill = np.nonzero(~held)
    turn = np.arange(len(of)) - np.searchsorted(of, of)
    place[of, to_fill] = place[held].take((np.cumsum(count) - count).take(of) + turn % count.take(of))
    return place
