# SPDX-License-Identifier: GPL-3.0-or-later
"""The base colour (diffuse albedo, linear RGB) of every point of the surfaces that block light.

Triangles take their colours from sources: constants, colours at their corners, or images through UV coordinates at
their corners. Triangles that look alike, such as those of a mesh's instances, share a row of a source, so that a
triangle costs 4 bytes however it is coloured.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Extension = Literal["REPEAT", "EXTEND", "CLIP", "MIRROR"]

# What has no material, as Blender shows it; and the ground plane, which has none and is to tint nothing.
GREY = (0.8, 0.8, 0.8)


class Source(Protocol):
    """Rows of colours, one for each of ``len(source)`` different triangles."""

    def __len__(self) -> int: ...

    def at(self, row: NDArray[np.integer], weights: NDArray[np.float64]) -> NDArray[np.floating]:
        """Colours (k, 3) in ``row`` (k,), ``weights`` (k, 3) of the triangles' corners."""


@dataclass(frozen=True)
class Constants:
    """One colour a row: ``colours`` (n, 3)."""

    colours: NDArray[np.floating]

    def __len__(self) -> int:
        return len(self.colours)

    def at(self, row: NDArray[np.integer], weights: NDArray[np.float64]) -> NDArray[np.floating]:
        return self.colours[row]


@dataclass(frozen=True)
class CornerColours:
    """A colour at each corner, linear between them: ``colours`` (n, 3 corners, 3) float32."""

    colours: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.colours)

    def at(self, row: NDArray[np.integer], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return _between(self.colours, row, weights)


@dataclass(frozen=True)
class Texture:
    """An image as Blender's Image Texture node reads it with flat projection.

    pixels      (h, w, 3) float32, linear RGB, bottom row first
    extension   what lies outside of the unit square: REPEAT, MIRROR the image again, EXTEND its border, CLIP black
    is_closest  the pixel that a point lies in, instead of a bilinear mean of the four around it
    """

    pixels: NDArray[np.float32]
    extension: Extension = "REPEAT"
    is_closest: bool = False

    def at(self, uv: NDArray[np.floating]) -> NDArray[np.float64]:
        """Colours (k, 3) at ``uv`` (k, 2): (0, 0) is the image's lower left corner, as is what is not finite."""
        size = np.array(self.pixels.shape[1::-1])
        # Pixels are numbered far past any use of UVs, and short of where integers end.
        place = np.clip(np.where(np.isfinite(uv), uv, 0.0) * size, -(2.0**52), 2.0**52)
        if self.is_closest:
            return self._pixel(np.floor(place).astype(np.int64))
        # A pixel's colour is that of its middle.
        lowest = np.floor(place - 0.5)
        right, up = (place - 0.5 - lowest).T
        lowest = lowest.astype(np.int64)
        colour = np.zeros((len(uv), 3))
        for step, weight in (
            ((0, 0), (1.0 - right) * (1.0 - up)),
            ((1, 0), right * (1.0 - up)),
            ((0, 1), (1.0 - right) * up),
            ((1, 1), right * up),
        ):
            colour += weight[:, None] * self._pixel(lowest + step)
        return colour

    def _pixel(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        """Pixels of column and row ``index`` (k, 2), also outside of the image."""
        size = np.array(self.pixels.shape[1::-1])
        if self.extension == "REPEAT":
            inside = index % size
        elif self.extension == "MIRROR":
            inside = index % (2 * size)
            inside = np.minimum(inside, 2 * size - 1 - inside)
        else:
            inside = np.clip(index, 0, size - 1)
        pixels = self.pixels[inside[:, 1], inside[:, 0]].astype(np.float64)
        if self.extension == "CLIP":
            pixels[(inside != index).any(axis=1)] = 0.0
        return pixels


@dataclass(frozen=True)
class TextureColours:
    """A ``texture`` through UV coordinates ``corner_uv`` (n, 3 corners, 2) float32; its colours are multiplied by
    ``scale`` (3,), and ``offset`` (3,) is added."""

    texture: Texture
    corner_uv: NDArray[np.float32]
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __len__(self) -> int:
        return len(self.corner_uv)

    def at(self, row: NDArray[np.integer], weights: NDArray[np.float64]) -> NDArray[np.float64]:
        return self.texture.at(_between(self.corner_uv, row, weights)) * self.scale + self.offset


class Albedo:
    """The colours of m triangles, and of the ``ground`` plane, whose index is m.

    sources  what ``row`` counts through: the rows of the first, then those of the second, and so on
    row      (m,) int, of each triangle
    ground   (3,)

    Memory: 4 bytes a triangle beside the sources, which are kept as they are given.

    Raises ValueError for a row that no source has.
    """

    def __init__(
        self, sources: Sequence[Source], row: NDArray[np.integer], ground: tuple[float, float, float] = GREY
    ) -> None:
        self._sources = [*sources, Constants(np.array([ground]))]
        self._end = np.cumsum([len(source) for source in self._sources])
        last = self._end[-1] - 1
        if len(row) and not 0 <= np.min(row) <= np.max(row) < last:
            raise ValueError("each triangle needs a row of the sources")
        self._row = np.append(row, last).astype(np.int32)

    def __len__(self) -> int:
        """The number m of triangles, without the ground."""
        return len(self._row) - 1

    def at(
        self, triangle: NDArray[np.integer], v: NDArray[np.floating], w: NDArray[np.floating]
    ) -> NDArray[np.float64]:
        """Colours (k, 3) in [0, 1] of points on ``triangle`` (k,), 0 to m, with weights ``v`` and ``w`` (k,) of its
        second and third corner.

        What a source gives beyond that range, or as NaN, is brought into it. Safe to use from many threads.
        """
        triangle, v, w = np.asarray(triangle), np.asarray(v, np.float64), np.asarray(w, np.float64)
        weights = np.column_stack((1.0 - v - w, v, w))
        row = self._row[triangle]
        source = np.searchsorted(self._end, row, side="right")
        order = np.argsort(source, kind="stable")
        colours = np.empty((len(triangle), 3))
        for part in np.split(order, np.flatnonzero(np.diff(source[order])) + 1):
            if len(part):
                number = source[part[0]]
                first = self._end[number] - len(self._sources[number])
                colours[part] = self._sources[number].at(row[part] - first, weights[part])
        # fmax and fmin take the number where the other is NaN.
        return np.fmin(np.fmax(colours, 0.0), 1.0)


def _between(
    corners: NDArray[np.floating], row: NDArray[np.integer], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Values (k, x) of ``corners`` (n, 3, x), in ``row`` (k,), by ``weights`` (k, 3)."""
    # One term after the other: the sum, and so every bit of it, depends on no other hit of the call.
    values = corners[row]
    return sum(weights[:, corner, None] * values[:, corner] for corner in range(3))
