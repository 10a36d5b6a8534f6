# SPDX-License-Identifier: GPL-3.0-or-later
"""Which piece of the scene's surfaces a hit lies on: the cells of the light cache.

Cells follow area, not topology. A large triangle is cut by a grid in space, a triangle of about a cell's size is a cell
of its own, tiny ones share one with their neighbours that face the same way. The two sides of a face never share a
cell: one may see the sky, the other a closed room. Nor do large triangles: one may lie just above another. Further from
what is baked the grid is coarser, in powers of two, so that an endless floor or a landscape needs no more cells than
are seen. Cells exist where rays have met something; they are found by a hash of where they are (Binder et al. 2019,
"Massively Parallel Path Space Filtering").
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .key_table import KeyTable
from .rays import Occluders
from .workers import Workers, slices

# Longest edge of a triangle that is a cell of its own, in sides of a cell.
TINY, LARGE = 0.5, 2.0
# Bits of a grid key: position on each axis, facing, level. The next two mark what is in a triangle of its own: a cell,
# or a part of the grid.
AXIS_BITS, FACING_BITS, LEVEL_BITS = 17, 5, 5
OWN_CELL = np.int64(1 << (3 * AXIS_BITS + FACING_BITS + LEVEL_BITS))
OWN_GRID = 2 * OWN_CELL
# 2^62 times the golden ratio's fraction, odd: it spreads the numbers of triangles over the keys.
SPREAD = np.int64(0x278DDE6E5FD29E3D)
BACK_OF = np.int8(26)  # facing of a face's back and front together
LEVEL_SHIFT = 3 * AXIS_BITS + FACING_BITS
SIDES_PER_PART = 2**16

NONE, IN_GRID = -1, -2  # in place of a cell or its key


@dataclass(frozen=True)
class Grid:
    """Cells of ``side`` within ``reach`` of ``centre`` (largest coordinate), twice as large with each doubling of the
    distance. All in the units that Embree sees."""

    centre: NDArray[np.float64]
    reach: float
    side: float

    def keys(self, positions: NDArray, facing: NDArray[np.integer]) -> NDArray[np.int64]:
        """Key (k,) of the cells at ``positions`` (k, 3) that have the ``facing`` (k,)."""
        # Off the origin by parts of a cell that no wall of a scene made to measure lies at.
        axes = [positions[:, axis] - (self.centre[axis] - shift * self.side) for axis, shift in enumerate(_SHIFTS)]
        away = np.maximum(np.maximum(np.abs(axes[0]), np.abs(axes[1])), np.abs(axes[2]))
        level = np.clip(np.frexp(away / self.reach)[1], 0, 2**LEVEL_BITS - 1)
        per_side = np.ldexp(1.0 / self.side, -level)
        key = (level.astype(np.int64) << FACING_BITS) | facing
        for axis in axes:
            key <<= AXIS_BITS
            key |= np.floor(axis * per_side).astype(np.int64) & (2**AXIS_BITS - 1)
        return key

    def keys_on(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int64]:
        """Key (k,) of the cells at ``positions`` (k, 3) that no triangle shares with another: these are hashed."""
        return OWN_GRID | ((self.keys(positions, np.int64(0)) + side * SPREAD) & (OWN_GRID - 1))


_SHIFTS = (0.377, 0.618, 0.231)


def facing_of(normals: NDArray) -> NDArray[np.int8]:
    """The nearest (k,) of 26 directions, 0 to 26 without 13, to ``normals`` (k, 3) of any length: those to the
    neighbours of a cube among 27."""
    x, y, z = (np.ascontiguousarray(axis) for axis in normals.T)
    largest = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.maximum(np.abs(z), np.finfo(x.dtype).tiny))
    steps = [np.rint(axis / largest).astype(np.int8) for axis in (x, y, z)]
    return (9 * steps[0] + 3 * steps[1] + steps[2] + 13).astype(np.int8)


class CellKeys:
    """Keys of hits on ``occluders``: those that are equal lie in one cell of the ``grid``."""

    def __init__(self, occluders: Occluders, grid: Grid):
        self._triangles, self._vertices, self._grid = occluders.triangles, occluders.vertices, grid

    def of_hits(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int64]:
        """Key (k,) of each hit on ``side`` (k,) of a triangle (:func:`side_of`) at ``positions`` (k, 3)."""
        sides, inverse = np.unique(side, return_inverse=True)
        key = self.of_sides(sides)[inverse.reshape(-1)]
        large = np.flatnonzero(key == IN_GRID)
        key[large] = self._grid.keys_on(side[large], positions[large])
        return key

    def of_sides(self, side: NDArray[np.integer]) -> NDArray[np.int64]:
        """The key (k,) that all hits on a side of a triangle (:func:`side_of`) have; IN_GRID where it depends on their
        position."""
        triangle, behind = side >> 1, (side & 1).astype(bool)
        is_floor = triangle == len(self._triangles)
        if is_floor.all():
            return np.full(len(side), IN_GRID, np.int64)
        corners = self._triangles.take(np.where(is_floor, 0, triangle), axis=0)
        a, b, c = (self._vertices.take(corner, axis=0) for corner in corners.T)
        facing = facing_of(np.cross(b - a, c - a))
        key = self._grid.keys((a + b + c) / np.float32(3.0), np.where(behind, BACK_OF - facing, facing))
        longest = np.sqrt(np.max([np.square(p - q).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0))
        cells_long = np.ldexp(longest / self._grid.side, -(key >> LEVEL_SHIFT))
        key = np.where(cells_long > TINY, OWN_CELL | side, key)
        key[(cells_long > LARGE) | is_floor] = IN_GRID
        return key


class Cells:
    """The cells of ``keys`` (n,), all different, to be found by hits on ``occluders``. Memory: 8 bytes a triangle."""

    def __init__(self, occluders: Occluders, grid: Grid, keys: NDArray[np.int64], workers: Workers):
        self._keys, self._table, self._grid = CellKeys(occluders, grid), KeyTable(keys), grid
        self._count = len(keys)
        sides = 2 * (len(occluders.triangles) + 1)
        self._cell = np.empty(sides, np.int32)

        def fill(part: slice) -> None:
            key = self._keys.of_sides(np.arange(part.start, part.stop))
            cell = self._table.find(key)
            cell[key == IN_GRID] = IN_GRID
            self._cell[part] = cell

        workers.map(fill, slices(sides, SIDES_PER_PART))

    def __len__(self) -> int:
        return self._count

    def find(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int32]:
        """Cell (k,) of hits on ``side`` (k,) of a triangle at ``positions`` (k, 3); NONE where there is none."""
        cell = self._cell.take(side)
        large = np.flatnonzero(cell == IN_GRID)
        if len(large):
            cell[large] = self._table.find(self._grid.keys_on(side.take(large), positions.take(large, axis=0)))
        return cell


def find_in(levels: Sequence[Cells], side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int32]:
    """As :meth:`Cells.find`, in the first of ``levels`` that has the cell; cells are counted through all of them."""
    cell = np.full(len(side), NONE, np.int32)
    left, first = np.arange(len(side)), 0
    for cells in levels:
        found = cells.find(side.take(left), positions.take(left, axis=0))
        known = found != NONE
        cell[left[known]] = first + found[known]
        left, first = left[~known], first + len(cells)
        if not len(left):
            break
    return cell


def side_of(triangle: NDArray[np.integer], behind: NDArray[np.bool_]) -> NDArray[np.int64]:
    """What hits on one side of a triangle have in common: twice the ``triangle``, and one more for its back."""
    return 2 * triangle.astype(np.int64) + behind
