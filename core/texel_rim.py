# SPDX-License-Identifier: GPL-3.0-or-later
"""Texels that a UV layout touches but in which it holds no place: the rim of islands, and slivers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .scan_conversion import by_height, expand, in_boxes, next_batch, running_sum, summed_area


def rim(
    x: NDArray[np.float64], y: NDArray[np.float64], boxes: NDArray[np.int32], is_open: NDArray[np.bool_], first: int
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.float32]]:
    """Open texels (k,) that a triangle touches, ascending, with the triangle (k,) whose outline comes nearest to the
    texel's centre, and the second and third barycentric weight (k, 2) of the nearest point.

    ``is_open`` (h, w) has the image's rows from ``first``, and texels count from there too; triangles have corners
    ``x``, ``y`` (3, m) in texels of the image and ``boxes`` (4, m) of rows [low, high) and columns [start, end). Of
    triangles equally near the lowest wins.
    """
    height, width = is_open.shape
    sums, before, is_open = summed_area(is_open), running_sum(is_open), is_open.reshape(-1)
    chosen = np.flatnonzero((boxes[0] < first + height) & (boxes[1] > first))
    boxes = boxes.take(chosen, axis=1)
    boxes[:2] = np.clip(boxes[:2] - first, 0, height)
    waiting = np.stack((*boxes, chosen)).take(np.flatnonzero(in_boxes(sums, *boxes)), axis=1)
    found = np.full(is_open.size, -1, np.int32)
    distance = np.full(is_open.size, np.inf)
    weights = np.zeros((is_open.size, 2), np.float32)
    while waiting.size:
        (low, high, start, end, chosen), waiting = next_batch(waiting, is_open.size)
        row, part = expand(low, high - low)
        base = row * width
        needed = np.flatnonzero(before.take(base + end.take(part)) > before.take(base + start.take(part)))
        row, triangle = row.take(needed), chosen.take(part.take(needed))
        start, end = _touched(x.take(triangle, axis=1), y.take(triangle, axis=1), row + first, width)
        start, end = start + row * width, end + row * width
        needed = np.flatnonzero(before.take(end) > before.take(start))
        start = start.take(needed)
        texel, part = expand(start, end.take(needed) - start)
        touched = np.flatnonzero(is_open.take(texel))
        texel, triangle = texel.take(touched), triangle.take(needed).take(part.take(touched))
        row, column = np.divmod(texel, width)
        corners = x.take(triangle, axis=1), y.take(triangle, axis=1)
        away, at = _closest_on_outline(column + 0.5, row + (first + 0.5), *corners)
        # Nearest first, then lowest triangle: the first of each texel in this order is its best here.
        order = np.lexsort((triangle, away, texel))
        order = order[np.diff(texel[order], prepend=-1) > 0]
        order = order[away[order] < distance[texel[order]]]
        best = texel[order]
        found[best], distance[best], weights[best] = triangle[order], away[order], at[order]
    texel = np.flatnonzero(found >= 0)
    return texel, found[texel], weights[texel]


def _touched(x: NDArray, y: NDArray, row: NDArray, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Columns [start, end) that triangles with corners ``x``, ``y`` (3, k) touch in the texel rows (k,)."""
    (x0, x1, x2), (y0, y1, y2) = by_height(x, y)
    bottom, top = np.maximum(y0, row), np.minimum(y2, row + 1)
    # A convex outline reaches furthest at the row's two borders, or at a corner between them.
    ends = [np.where((y1 > bottom) & (y1 < top), x1, _crossing(x0, y0, x2, y2, bottom))]
    for level in (bottom, top):
        ends.append(_crossing(x0, y0, x2, y2, level))
        ends.append(np.where(level < y1, _crossing(x0, y0, x1, y1, level), _crossing(x1, y1, x2, y2, level)))
    start, end = np.floor(np.minimum.reduce(ends)), np.ceil(np.maximum.reduce(ends))
    return np.clip(start, 0, width).astype(np.int64), np.clip(end, 0, width).astype(np.int64)


def _crossing(x0: NDArray, y0: NDArray, x1: NDArray, y1: NDArray, level: NDArray) -> NDArray[np.float64]:
    """x of the edges from (x0, y0) up to (x1, y1) at ``level``, never beyond their ends."""
    rise = y1 - y0
    along = np.divide(level - y0, rise, out=np.zeros_like(rise), where=rise > 0.0)
    return np.clip(x0 + along * (x1 - x0), np.minimum(x0, x1), np.maximum(x0, x1))


def _closest_on_outline(
    px: NDArray, py: NDArray, x: NDArray, y: NDArray
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared distance (k,) from points to the outlines of triangles with corners ``x``, ``y`` (3, k), and the second
    and third weight (k, 2) of the nearest point."""
    distance, weights = np.full(len(px), np.inf), np.zeros((len(px), 3))
    for i, j in ((0, 1), (1, 2), (2, 0)):
        along_x, along_y = x[j] - x[i], y[j] - y[i]
        to_x, to_y = px - x[i], py - y[i]
        t = (to_x * along_x + to_y * along_y) / np.maximum(along_x * along_x + along_y * along_y, 1e-300)
        t = np.clip(t, 0.0, 1.0)
        away = (to_x - t * along_x) ** 2 + (to_y - t * along_y) ** 2
        closer = np.flatnonzero(away < distance)
        distance[closer] = away[closer]
        weights[closer] = 0.0
        weights[closer, i] = 1.0 - t[closer]
        weights[closer, j] = t[closer]
    return distance, weights[:, 1:]
