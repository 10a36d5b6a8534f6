# SPDX-License-Identifier: GPL-3.0-or-later
"""Cubemaps in the layout of OpenEXR's ``envmap`` attribute (ImfEnvmap.h, namespace CubeMap).

A map is an array (6, n, n, ...): face, row from the top, column from the left, as the image n wide and 6n high stores
it, its first row on top. Where a direction's largest coordinate has size 1, a face holds the other two:

    face  0: +X   1: -X   2: +Y   3: -Y   4: +Z   5: -Z
    right    +z      -z      +x      +x      -x      +x
    down     -y      -y      -z      +z      -y      -y

Texels are nodes, not cells: column i lies at 2i/(n - 1) - 1, so the outermost ones lie on the cube's edges and two
faces hold the same directions there, three at a corner. Given the same values there, bilinear lookup within each face
is continuous over the whole sphere, and neither a shader nor a filter needs more than one face.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Of each face: its axis, the axis to the right and the axis down, with their signs.
FACES = (
    ((0, 1), (2, 1), (1, -1)),
    ((0, -1), (2, -1), (1, -1)),
    ((1, 1), (0, 1), (2, -1)),
    ((1, -1), (0, 1), (2, 1)),
    ((2, 1), (0, -1), (1, -1)),
    ((2, -1), (0, 1), (1, -1)),
)


def nodes(n: int) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The different directions (m, 3), unit length, of a map of n texels a side, and which of them each texel holds
    (6, n, n). n at least 2; m = 6 (n - 1)^2 + 2."""
    along = 2 * np.arange(n) - (n - 1)
    lattice = np.empty((6, n, n, 3), np.int64)
    for face, ((axis, sign), (right, right_sign), (down, down_sign)) in enumerate(FACES):
        lattice[face, :, :, axis] = sign * (n - 1)
        lattice[face, :, :, right] = right_sign * along
        lattice[face, :, :, down] = down_sign * along[:, None]
    different, node = np.unique(lattice.reshape(-1, 3), axis=0, return_inverse=True)
    return different / np.linalg.norm(different, axis=1, keepdims=True), node.reshape(6, n, n)


def locate(directions: ArrayLike, n: int) -> tuple[NDArray[np.intp], NDArray[np.float64], NDArray[np.float64]]:
    """Face, column and row, in [0, n - 1] and not whole numbers, each (k,), of ``directions`` (k, 3) of any length.

    Of equal coordinates x comes before y before z; no direction at all is the middle of +X.
    """
    directions = np.asarray(directions, np.float64)
    axis = np.argmax(np.abs(directions), axis=1)  # the first of the largest
    index = np.arange(len(directions))
    largest = directions[index, axis]
    face = 2 * axis + (largest < 0.0)
    size = np.maximum(np.abs(largest), np.finfo(np.float64).tiny)
    table = np.array(FACES)[face]
    column, row = (
        0.5 * (n - 1) * (1.0 + sign * directions[index, other] / size) for other, sign in (table[:, 1].T, table[:, 2].T)
    )
    return face, column, row


def lookup(maps: NDArray, directions: ArrayLike) -> NDArray[np.float64]:
    """Bilinear values (k, ...) of ``maps`` (6, n, n, ...) in ``directions`` (k, 3), continuous over edges and corners
    where texels of the same direction have the same value."""
    n = maps.shape[1]
    face, column, row = locate(directions, n)
    left, top = (np.minimum(each.astype(np.intp), n - 2) for each in (column, row))
    more = (1,) * (maps.ndim - 3)
    s, t = (column - left).reshape(-1, *more), (row - top).reshape(-1, *more)
    above = (1.0 - s) * maps[face, top, left] + s * maps[face, top, left + 1]
    below = (1.0 - s) * maps[face, top + 1, left] + s * maps[face, top + 1, left + 1]
    return (1.0 - t) * above + t * below
