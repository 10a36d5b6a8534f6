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

from .faces import BACK_OF, Faces
from .key_table import KeyTable
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
FACING_SHIFT = 3 * AXIS_BITS
LEVEL_SHIFT = FACING_SHIFT + FACING_BITS
FACES_PER_PART = 2**15

NONE, IN_GRID = -1, -2  # in place of a cell or its key


@dataclass(frozen=True)
class Grid:
    """Cells of ``side`` within ``reach`` of ``centre`` (largest coordinate), twice as large with each doubling of the
    distance. All in the units that Embree sees."""

    centre: NDArray[np.float64]
    reach: float
    side: float

    def keys(self, positions: NDArray) -> NDArray[np.int64]:
        """Key (k,) of the cells at ``positions`` (k, 3), the bits of their facing left 0."""
        # Off the origin by parts of a cell that no wall of a scene made to measure lies at.
        axes = [positions[:, axis] - (self.centre[axis] - shift * self.side) for axis, shift in enumerate(_SHIFTS)]
        away = np.maximum(np.maximum(np.abs(axes[0]), np.abs(axes[1])), np.abs(axes[2]))
        level = np.clip(np.frexp(away / self.reach)[1], 0, 2**LEVEL_BITS - 1)
        per_side = np.ldexp(1.0 / self.side, -level)
        key = level.astype(np.int64) << FACING_BITS
        for axis in axes:
            key <<= AXIS_BITS
            key |= np.floor(axis * per_side).astype(np.int64) & (2**AXIS_BITS - 1)
        return key

    def keys_on(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int64]:
        """Key (k,) of the cells at ``positions`` (k, 3) that no triangle shares with another: these are hashed."""
        return OWN_GRID | ((self.keys(positions) + side * SPREAD) & (OWN_GRID - 1))


_SHIFTS = (0.377, 0.618, 0.231)


class CellKeys:
    """Keys of hits on ``faces``: those that are equal lie in one cell of the ``grid``."""

    def __init__(self, faces: Faces, grid: Grid):
        self._faces, self._grid = faces, grid

    def of_hits(self, side: NDArray[np.integer], positions: NDArray) -> NDArray[np.int64]:
        """Key (k,) of each hit on ``side`` (k,) of a triangle (:func:`side_of`) at ``positions`` (k, 3)."""
        key = np.where(side & 1, *reversed(self.of_faces(side >> 1)))
        large = np.flatnonzero(key == IN_GRID)
        key[large] = self._grid.keys_on(side[large], positions[large])
        return key

    def of_faces(self, face: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The keys (k,) that all hits on the fronts of the triangles ``face`` (k,) have, and those on their backs;
        IN_GRID where it depends on their position."""
        place = self._grid.keys(self._faces.middle.take(face, axis=0))
        cells_long = np.ldexp(self._faces.longest.take(face) / self._grid.side, -(place >> LEVEL_SHIFT))
        is_own, is_large, facing = cells_long > TINY, cells_long > LARGE, self._faces.facing.take(face)

        def keys(behind: int, facing: NDArray[np.int8]) -> NDArray[np.int64]:
            key = place | (facing.astype(np.int64) << FACING_SHIFT)
            np.copyto(key, OWN_CELL | (2 * face + behind), where=is_own)
            key[is_large] = IN_GRID
            return key

        return keys(0, facing), keys(1, BACK_OF - facing)


class Cells:
    """The cells of ``keys`` (n,), all different, to be found by hits on ``faces``. Memory: 8 bytes a triangle."""

    def __init__(self, faces: Faces, grid: Grid, keys: NDArray[np.int64], workers: Workers):
        self._table, self._grid, self._count = KeyTable(keys), grid, len(keys)
        cell = np.empty((len(faces), 2), np.int32)
        of_faces = CellKeys(faces, grid).of_faces

        def fill(part: slice) -> None:
            for behind, key in enumerate(of_faces(np.arange(part.start, part.stop))):
                cell[part, behind] = np.where(key == IN_GRID, np.int32(IN_GRID), self._table.find(key))

        workers.map(fill, slices(len(faces), FACES_PER_PART))
        self._cell = cell.reshape(-1)

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
