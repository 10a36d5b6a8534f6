# SPDX-License-Identifier: GPL-3.0-or-later
"""Scan conversion: which triangle lies at each of a regular set of points.

The points stand on scanlines, one a column. A triangle cut at its middle corner is two trapezoids; on every scanline a
trapezoid holds the interval between its left and its right edge, and these intervals are all that is expanded. Edges
belong to the triangle on their right, and neighbours compute the same crossings, so that a point on a shared edge has
exactly one owner.

Foley, van Dam, Feiner and Hughes, Computer Graphics: Principles and Practice, 2nd ed. 1990, section 3.6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Rows of triangles looked at together.
ROWS_PER_BATCH = 2**17


@dataclass(frozen=True)
class Trapezoids:
    """Triangles cut at their middle corner, in ascending order of triangle.

    triangle     (t,) int32
    low, high    (t,) int32, their scanlines [low, high), never empty
    left, right  (2, t) float64, x of the edge at scanline 0 and its step to the next
    start, end   (t,) int32, the columns [start, end) that the triangle reaches
    """

    triangle: NDArray[np.int32]
    low: NDArray[np.int32]
    high: NDArray[np.int32]
    left: NDArray[np.float64]
    right: NDArray[np.float64]
    start: NDArray[np.int32]
    end: NDArray[np.int32]


def trapezoids(x: NDArray[np.float64], y: NDArray[np.float64], width: int, first: int, last: int) -> Trapezoids:
    """Cut triangles with corners ``x``, ``y`` (3, m); scanline s lies at y = s + 0.5, only [first, last) count."""
    start, end = reach(x, 0, width)
    (x0, x1, x2), (y0, y1, y2) = by_height(x, y)
    # The first scanline at or above each corner: a number of the corner alone, so that neighbours agree on it.
    s0, s1, s2 = np.ceil(y0 - 0.5), np.ceil(y1 - 0.5), np.ceil(y2 - 0.5)
    middle_is_right = (x1 - x0) * (y2 - y0) > (x2 - x0) * (y1 - y0)
    long = _edge(x0, y0, x2, y2, s0 < s2)
    parts = []
    for short, low, high in ((_edge(x0, y0, x1, y1, s0 < s1), s0, s1), (_edge(x1, y1, x2, y2, s1 < s2), s1, s2)):
        left, right = np.where(middle_is_right, long, short), np.where(middle_is_right, short, long)
        parts.append((np.clip(low, first, last), np.clip(high, first, last), left, right))
    # Lower and upper part of a triangle side by side: (..., m, 2).
    low, high, left, right = (np.stack(pair, axis=-1) for pair in zip(*parts, strict=True))
    low, high = low.reshape(-1).astype(np.int32), high.reshape(-1).astype(np.int32)
    used = np.flatnonzero(low < high)
    triangle = used // 2
    return Trapezoids(
        triangle.astype(np.int32),
        low.take(used),
        high.take(used),
        left.reshape(2, -1).take(used, axis=1),
        right.reshape(2, -1).take(used, axis=1),
        start.take(triangle),
        end.take(triangle),
    )


def owners(cut: Trapezoids, rows: tuple[int, int], width: int, offset: NDArray[np.float64]) -> NDArray[np.int32]:
    """The lowest triangle at each point of the image ``rows`` [first, last), or -1: (last - first, K, width).

    Each row has K scanlines, on which the points stand at x = column + ``offset`` (K,).
    """
    places = len(offset)
    first, last = rows[0] * places, rows[1] * places
    owner = np.full((last - first) * width, -1, np.int32)
    chosen = np.flatnonzero((cut.low < last) & (cut.high > first))
    low, high = np.maximum(cut.low.take(chosen), first), np.minimum(cut.high.take(chosen), last)
    waiting = np.stack((low - first, high - first, cut.start.take(chosen), cut.end.take(chosen), chosen))
    offset = np.tile(offset, rows[1] - rows[0])
    is_open = None
    while waiting.size:
        if is_open is not None:
            # Where layouts overlap, most triangles find every point taken: pass over them before expanding.
            sums = summed_area(is_open.reshape(-1, places, width).any(axis=1))
            low, high, start, end = waiting[:4]
            waiting = waiting.take(
                np.flatnonzero(in_boxes(sums, low // places, -(-high // places), start, end)), axis=1
            )
        now, waiting = next_batch(waiting, len(owner))
        point, length, triangle = _runs(cut, now, first, width, offset)
        if is_open is not None:
            before = running_sum(is_open)
            some = np.flatnonzero(before.take(point + length) > before.take(point))
            point, length, triangle = point.take(some), length.take(some), triangle.take(some)
        # Backwards, so that of triangles over a point the lowest is the one that stays.
        point, part = expand(point[::-1], length[::-1])
        triangle = triangle[::-1].take(part)
        if is_open is not None:
            free = np.flatnonzero(is_open.take(point))
            point, triangle = point.take(free), triangle.take(free)
        owner[point] = triangle
        if waiting.size:
            is_open = owner < 0
    return owner.reshape(-1, places, width)


def by_height(x: NDArray, y: NDArray) -> tuple[NDArray, NDArray]:
    """Corners (3, m) in ascending order of y."""
    x, y = x.copy(), y.copy()
    for i, j in ((0, 1), (1, 2), (0, 1)):
        swap = y[i] > y[j]
        for a in (x, y):
            a[i], a[j] = np.where(swap, a[j], a[i]), np.where(swap, a[i], a[j])
    return x, y


def reach(corners: NDArray[np.float64], first: int, last: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The unit cells [start, end) within [first, last) that triangles' ``corners`` (3, m) on one axis span."""
    start, end = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
    return np.clip(start, first, last).astype(np.int32), np.clip(end, first, last).astype(np.int32)


def expand(start: NDArray, length: NDArray) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """All integers of the ranges [start, start + length), none of them empty, and the range that each belongs to.

    Running sums of steps: faster than numpy.repeat, and without Python's lock.
    """
    if not len(start):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    ends = np.cumsum(length, dtype=np.int64)
    number, part = np.ones(ends[-1], np.int64), np.zeros(ends[-1], np.int64)
    number[0] = start[0]
    number[ends[:-1]] = start[1:] - start[:-1] - length[:-1] + 1
    part[ends[:-1]] = 1
    return np.cumsum(number, out=number), np.cumsum(part, out=part)


def next_batch(waiting: NDArray, points: int) -> tuple[NDArray, NDArray]:
    """``waiting`` (5, k), boxes of rows [low, high) and columns [start, end) and whose they are, as the ones to expand
    together now and the rest: at least one, else at most 2 ``points`` on :data:`ROWS_PER_BATCH` rows."""
    low, high, start, end = waiting[:4]
    rows = high - low
    by_rows = np.searchsorted(np.cumsum(rows), ROWS_PER_BATCH, side="right")
    by_points = np.searchsorted(np.cumsum(rows * (end - start)), 2 * points, side="right")
    count = max(1, min(by_rows, by_points))
    return waiting[:, :count], waiting[:, count:]


def running_sum(values: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Number (n + 1,) of true values before each of ``values``, and of all."""
    sums = np.zeros(values.size + 1, np.int32)
    sums[1:] = values.reshape(-1)
    return np.cumsum(sums, out=sums)


def summed_area(values: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Number (h + 1, w + 1) of true ``values`` (h, w) below and left: Crow, Summed-Area Tables for Texture Mapping,
    SIGGRAPH 1984."""
    sums = np.zeros((values.shape[0] + 1, values.shape[1] + 1), np.int32)
    sums[1:, 1:] = values
    np.cumsum(sums, axis=1, out=sums)
    return np.cumsum(sums, axis=0, out=sums)


def in_boxes(sums: NDArray[np.int32], low: NDArray, high: NDArray, start: NDArray, end: NDArray) -> NDArray[np.int32]:
    """Number (k,) of true values in rows [low, high) and columns [start, end), from their :func:`summed_area`."""
    stride = sums.shape[1]
    sums, low, high = sums.reshape(-1), low * stride, high * stride
    return sums.take(high + end) - sums.take(high + start) - sums.take(low + end) + sums.take(low + start)


def _edge(x0: NDArray, y0: NDArray, x1: NDArray, y1: NDArray, crosses: NDArray[np.bool_]) -> NDArray[np.float64]:
    """x at scanline 0 and step (2, m) of the edges from (x0, y0) up to (x1, y1) that cross scanlines.

    From the two ends alone, so that both neighbours find the same crossings.
    """
    step = np.divide(x1 - x0, y1 - y0, out=np.zeros_like(x0), where=crosses)
    return np.stack((x0 + (0.5 - y0) * step, step))


def _runs(
    cut: Trapezoids, boxes: NDArray[np.int64], first: int, width: int, offset: NDArray
) -> tuple[NDArray[np.int64], NDArray[np.int32], NDArray[np.int32]]:
    """Runs of points on the scanlines of ``boxes`` that lie in their trapezoids: first point, length and triangle."""
    low, high, _, _, chosen = boxes
    scanline, part = expand(low, high - low)
    height, shift = (scanline + first).astype(np.float64), offset.take(scanline)
    ends = []
    for at, step in (cut.left, cut.right):
        x = step.take(chosen).take(part)
        x *= height
        x += at.take(chosen).take(part)
        x -= shift
        np.ceil(x, out=x)
        np.maximum(x, 0.0, out=x)
        np.minimum(x, width, out=x)
        ends.append(x.astype(np.int32))
    length = ends[1] - ends[0]
    some = np.flatnonzero(length > 0)
    point = (scanline * width + ends[0]).take(some)
    return point, length.take(some), cut.triangle.take(chosen).take(part.take(some))
