# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines, dots, areas and text as pixels.

All but areas is made of segments with round ends, also letters: a pixel is covered by what is left of its distance to
the nearest segment, which is smooth at every size.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from .stroke_font import CAP_HEIGHT, text_strokes

INK = "#333333"
"""Colour of text."""

# Segments are cut into pieces no longer than so many pixels, each of which then looks at few pixels around it.
PIECE = 8.0


class Canvas:
    """An opaque white image (height, width), drawn on from back to front. Positions are in pixels from its top left."""

    def __init__(self, width: int, height: int):
        self._pixels = np.ones((height, width, 3), np.float32)

    def rgba(self) -> NDArray[np.float32]:
        """The image so far, (height, width, 4) in [0, 1], bottom row first."""
        alpha = np.ones((*self._pixels.shape[:2], 1), np.float32)
        return np.concatenate((self._pixels, alpha), axis=2)[::-1]

    def draw(
        self,
        segments: NDArray[np.float64],
        colour: str,
        width: float,
        opacity: float = 1.0,
        frame: tuple[float, float, float, float] | None = None,
    ) -> None:
        """Draw ``segments`` (n, 2 ends, 2) with round ends, as one shape: they do not show where they overlap.

        ``frame`` is left, top, right and bottom of what may be drawn on; default all. Memory follows the length of the
        segments, also outside of it.
        """
        first, last = _pieces(segments)
        # Each piece gets a square of pixels that holds it with its round ends.
        reach = 0.5 * width + 0.5
        side = math.ceil(PIECE + 2.0 * reach) + 1
        corner = np.floor(np.minimum(first, last) - reach).astype(np.intp)
        column = corner[:, 0, None, None] + np.arange(side)
        row = corner[:, 1, None, None] + np.arange(side)[:, None]
        cover = np.clip(reach - _distance(column + 0.5, row + 0.5, first, last), 0.0, min(1.0, width))
        left, top, right, bottom = np.rint(frame or (0, 0, *self._pixels.shape[1::-1]))
        inside = (cover > 0.0) & (column >= left) & (column < right) & (row >= top) & (row < bottom)
        if inside.any():
            column, row = (each[inside] for each in np.broadcast_arrays(column, row))
            box = slice(row.min(), row.max() + 1), slice(column.min(), column.max() + 1)
            shape = np.zeros([part.stop - part.start for part in box])
            np.maximum.at(shape, (row - box[0].start, column - box[1].start), cover[inside])
            self._blend(box, shape, colour, opacity)

    def area(self, points: NDArray[np.float64], bottom: float, colour: str, opacity: float) -> None:
        """Fill from ``points`` (n, 2), left to right, down to ``bottom``: a column a point, half way to its neighbours,
        and for the outer ones from where they are."""
        height, width = self._pixels.shape[:2]
        x, y = points.T
        edges = np.concatenate((x[:1], 0.5 * (x[:-1] + x[1:]), x[-1:]))
        # Heights of the left and the right edge of each pixel's column, as the mean over it.
        filled = np.concatenate(([0.0], np.cumsum(np.maximum(bottom - y, 0.0) * np.diff(edges))))
        level = bottom - np.diff(np.interp(np.arange(width + 1), edges, filled))
        rows = np.arange(height)[:, None]
        cover = np.clip(np.minimum(rows + 1, bottom) - np.maximum(rows, level), 0.0, 1.0)
        self._blend((slice(None), slice(None)), cover, colour, opacity)

    def text(self, text: str, at: tuple[float, float], size: float, align: float = 0.0, upwards: bool = False) -> None:
        """Write one line whose baseline passes ``at``, which is its start (``align`` 0), middle (0.5) or end (1).

        ``size`` in pixels a grid unit of the font. ``upwards``: turned a quarter to the left.
        """
        strokes, length = text_strokes(text)
        strokes = (strokes - (align * length, CAP_HEIGHT)) * size
        if upwards:
            strokes = np.stack((strokes[..., 1], -strokes[..., 0]), axis=-1)
        self.draw(strokes + at, INK, max(1.0, 0.9 * size))

    def _blend(self, box: tuple[slice, slice], cover: NDArray, colour: str, opacity: float) -> None:
        """Paint the pixels of ``box``, as far as each is covered."""
        paint = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0
        self._pixels[box] += opacity * cover[..., None] * (paint - self._pixels[box])


def _pieces(segments: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """First and last points (k, 2) of ``segments`` (n, 2, 2) cut into equal pieces no longer than PIECE."""
    start, way = segments[:, 0], segments[:, 1] - segments[:, 0]
    count = np.maximum(np.ceil(np.sqrt(np.square(way).sum(axis=1)) / PIECE).astype(np.intp), 1)
    of = np.repeat(np.arange(len(segments)), count)
    step = (np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count))[:, None]
    share = way[of] / count[of, None]
    return start[of] + step * share, start[of] + (step + 1) * share


def _distance(x: NDArray, y: NDArray, first: NDArray[np.float64], last: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance (k, ...) of points (``x``, ``y``), each (k, ...), to the segments from ``first`` to ``last`` (k, 2)."""
    along_x, along_y = (axis[:, None, None] for axis in (last - first).T)
    x, y = (value - axis[:, None, None] for value, axis in zip((x, y), first.T, strict=True))
    squared = np.maximum(along_x**2 + along_y**2, np.finfo(np.float64).tiny)
    t = np.clip((x * along_x + y * along_y) / squared, 0.0, 1.0)
    return np.hypot(x - t * along_x, y - t * along_y)
