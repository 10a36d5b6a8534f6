# SPDX-License-Identifier: GPL-3.0-or-later
"""Which texels a UV layout touches, and which point of the surface each of them shows.

Conservative: every texel whose square a UV triangle touches gets a point. Where the texel's centre lies in a triangle
that point is under the centre; at island borders it is the nearest point of the island, so that bilinear filtering
never picks up background. The work is two expansions without a loop over triangles: triangles into the rows they
cross, rows into the texels of their span.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .surface import inset_barycentric

# Texels expanded at once, about 100 MB of temporaries.
TEXELS_PER_CHUNK = 2**19


@dataclass(frozen=True)
class Texels:
    """k texels of an image and the surface point under each.

    texel        (k,) int64, row * width + column, row 0 at v = 0; ascending
    triangle     (k,) int64
    barycentric  (k, 3) float64, positive, sums to 1
    """

    texel: NDArray[np.int64]
    triangle: NDArray[np.int64]
    barycentric: NDArray[np.float64]


def rasterise(triangle_uv: NDArray, width: int, height: int, rows: tuple[int, int] | None = None) -> Texels:
    """Texels in image ``rows`` [first, last) that ``triangle_uv`` (m, 3, 2) touches, one surface point each.

    Only the tile [0, 1]^2 is filled. Where triangles overlap, the first that holds the texel's centre wins. Triangles
    without UV area, or with NaN coordinates, own nothing.
    """
    first, last = rows or (0, height)
    corners = np.asarray(triangle_uv, np.float64) * (width, height)
    ids = _drawable(corners, width, first, last)
    to_weights = _to_weights(corners)
    count = (last - first) * width
    owner = np.full(count, -1, np.int64)
    weights = np.zeros((count, 3))
    distance = np.full(count, np.inf)
    for triangle, row, low, high in _spans(corners, ids, width, first, last):
        # Where layouts overlap, most spans hold no texel that is still open: pass over them before expanding.
        still_open = np.concatenate(((0,), np.cumsum(distance > 0.0)))
        start = (row - first) * width
        needed = still_open[start + high] > still_open[start + low]
        part, column = _expand(low[needed], high[needed])
        triangle, row = triangle[needed][part], row[needed][part]

        texel = (row - first) * width + column
        to_centre = np.stack((column + 0.5, row + 0.5), axis=1) - corners[triangle, 0]
        at = _barycentric(to_centre, to_weights[triangle])
        under = at.min(axis=1) >= 0.0

        # Backwards, so that the first triangle over a centre is the one that stays.
        best = np.flatnonzero(under & (distance[texel] > 0.0))[::-1]
        owner[texel[best]], weights[texel[best]], distance[texel[best]] = triangle[best], at[best], 0.0

        rim = np.flatnonzero(~under & (distance[texel] > 0.0))
        away, at = _closest_on_edges(to_centre[rim], corners[triangle[rim]])
        # Nearest first, then lowest triangle: the first of each texel in this order is its best here.
        order = np.lexsort((triangle[rim], away, texel[rim]))
        order = order[np.diff(texel[rim[order]], prepend=-1) > 0]
        order = order[away[order] < distance[texel[rim[order]]]]
        best = texel[rim[order]]
        owner[best], weights[best], distance[best] = triangle[rim[order]], at[order], away[order]
    hit = np.flatnonzero(owner >= 0)
    return Texels(hit + first * width, owner[hit], inset_barycentric(weights[hit]))


def bands(width: int, height: int, texels: int = 2**20) -> Iterator[tuple[int, int]]:
    """Row ranges [first, last) of at most ``texels`` texels (at least one row), so that memory does not follow the
    image."""
    step = max(1, texels // width)
    for first in range(0, height, step):
        yield first, min(first + step, height)


def _drawable(corners: NDArray, width: int, first: int, last: int) -> NDArray[np.intp]:
    """Triangles with area that reach into the rows and the tile."""
    (x0, y0), (x1, y1), (x2, y2) = np.moveaxis(corners, (1, 2), (0, 1))
    area = np.abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0))
    low, high = corners.min(axis=1), corners.max(axis=1)
    inside = (high[:, 0] > 0) & (low[:, 0] < width) & (high[:, 1] > first) & (low[:, 1] < last)
    return np.flatnonzero(inside & (area > 1e-12))


def _spans(
    corners: NDArray, ids: NDArray, width: int, first: int, last: int
) -> Iterator[tuple[NDArray, NDArray, NDArray, NDArray]]:
    """Chunks of (triangle, row, low, high), each (k,) int64: the columns [low, high) that a triangle touches in a
    row."""
    y = corners[ids, :, 1]
    row_low = np.maximum(np.floor(y.min(axis=1)), first).astype(np.int64)
    row_high = np.minimum(np.ceil(y.max(axis=1)), last).astype(np.int64)
    part, row = _expand(row_low, row_high)
    triangle = ids[part]
    left, right = _extent_in_row(corners[triangle], row)
    low = np.clip(np.floor(left), 0, width).astype(np.int64)
    high = np.clip(np.ceil(right), 0, width).astype(np.int64)
    ends = np.cumsum(np.maximum(high - low, 0))
    start = 0
    while start < len(row):
        before = ends[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, before + TEXELS_PER_CHUNK, side="right")))
        yield triangle[start:stop], row[start:stop], low[start:stop], high[start:stop]
        start = stop


def _expand(low: NDArray, high: NDArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All integers of the ranges [low, high), and the index of the range each belongs to."""
    count = np.maximum(high - low, 0)
    part = np.repeat(np.arange(len(low)), count)
    offset = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    return part, low[part] + offset


def _extent_in_row(corners: NDArray, row: NDArray) -> tuple[NDArray, NDArray]:
    """Leftmost and rightmost x (k,) of each triangle (k, 3, 2) within its row [row, row + 1]."""
    left, right = np.full(len(row), np.inf), np.full(len(row), -np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        (px, py), (qx, qy) = corners[:, i].T, corners[:, j].T
        low = np.maximum(np.minimum(py, qy), row)
        high = np.minimum(np.maximum(py, qy), row + 1)
        crosses = low <= high
        rise = qy - py
        slope = np.divide(qx - px, rise, out=np.zeros_like(rise), where=rise != 0.0)
        for y in (low, high):
            x = np.where(rise != 0.0, px + (y - py) * slope, px)
            left = np.where(crosses, np.minimum(left, x), left)
            right = np.where(crosses, np.maximum(right, x), right)
        level = crosses & (rise == 0.0)
        left[level] = np.minimum(left, np.minimum(px, qx))[level]
        right[level] = np.maximum(right, np.maximum(px, qx))[level]
    return left, right


def _to_weights(triangles: NDArray) -> NDArray[np.float64]:
    """(m, 2, 2): takes the vector from a triangle's first corner to a point to that point's second and third weight."""
    ab, ac = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    inverse = np.stack((ac[:, 1], -ac[:, 0], -ab[:, 1], ab[:, 0]), axis=1).reshape(-1, 2, 2)
    return np.divide(inverse, area[:, None, None], out=np.zeros_like(inverse), where=area[:, None, None] != 0.0)


def _barycentric(to_points: NDArray, to_weights: NDArray) -> NDArray[np.float64]:
    """Barycentric coordinates (k, 3) of points given from their triangles' first corners."""
    v = to_points[:, 0] * to_weights[:, 0, 0] + to_points[:, 1] * to_weights[:, 0, 1]
    w = to_points[:, 0] * to_weights[:, 1, 0] + to_points[:, 1] * to_weights[:, 1, 1]
    return np.stack((1.0 - v - w, v, w), axis=1)


def _closest_on_edges(to_points: NDArray, triangles: NDArray) -> tuple[NDArray, NDArray]:
    """Squared distance (k,) to the outlines of ``triangles`` (k, 3, 2), and barycentrics (k, 3) of the nearest
    point."""
    distance, at = np.full(len(to_points), np.inf), np.zeros((len(to_points), 3))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        along = triangles[:, j] - triangles[:, i]
        to = to_points - (triangles[:, i] - triangles[:, 0])
        t = np.clip((to * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), 1e-300), 0.0, 1.0)
        away = ((to - t[:, None] * along) ** 2).sum(axis=1)
        closer = away < distance
        distance[closer] = away[closer]
        at[closer] = 0.0
        at[closer, i] = 1.0 - t[closer]
        at[closer, j] = t[closer]
    return distance, at
