# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps of an AO field as one picture for shaders, which Cycles and EEVEE look up without a seam.

They are looked up by Environment Texture nodes (:mod:`shader_nodes.environment`), which have no alpha: the twelve
numbers of a direction stand in four bands beside each other, three to each. In a band three columns of faces, those of
x, y and z, stand in two rows, negative under positive. Each face is n x n texels and a border that repeats its
outermost ones, so that rounding never mixes in a neighbour; texels are nodes that lie on the edges of the cube
(:mod:`core.cubemap`). Below and above there is an empty row of faces.

On the picture s runs to the right and t up: y and z on the faces of x, x and z on those of y, x and y on those of z,
each divided by the largest of the three coordinates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.ao_field import AOField
from ..core.cubemap import FACES

BANDS = 4
COLUMNS, ROWS = 3, 4
BORDER = 1


def atlas_pixels(field: AOField) -> NDArray[np.float32]:
    """Pixels (4 (n + 2), 12 (n + 2), 4), bottom row first, of a field of resolution n.

    The bands: a, b, c; a_m, b_m, c_m; C0; r0, d, e. Alpha is 1.
    """
    bands = (
        np.stack((field.a, field.b, field.c), axis=-1),
        np.stack((field.a_m, field.b_m, field.c_m), axis=-1),
        field.c0,
        np.stack((field.r0, field.d, field.e), axis=-1),
    )
    side = field.resolution + 2 * BORDER
    pixels = np.zeros((ROWS * side, BANDS * COLUMNS * side, 4), np.float32)
    pixels[..., 3] = 1.0
    for band, maps in enumerate(bands):
        for face in range(len(FACES)):
            row, column = (2 - face % 2) * side, (COLUMNS * band + face // 2) * side
            pixels[row : row + side, column : column + side, :3] = _bordered(_upright(maps[face], face))
    return pixels


def _upright(texels: NDArray, face: int) -> NDArray:
    """One face (n, n, 3) of :mod:`core.cubemap`, by t and s."""
    (_, _), (right, right_sign), (down, down_sign) = FACES[face]
    texels = texels[::down_sign, ::right_sign]
    return texels if right < down else texels.swapaxes(0, 1)


def _bordered(texels: NDArray) -> NDArray:
    return np.pad(texels, ((BORDER, BORDER), (BORDER, BORDER), (0, 0)), mode="edge")
