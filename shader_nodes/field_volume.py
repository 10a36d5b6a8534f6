# SPDX-License-Identifier: GPL-3.0-or-later
"""What is blocked at the nodes of a grid within the convex hull, as one picture, and its look-up by shaders.

The grid's slices of equal z stand as tiles in two rows, COLUMNS to each: in the left half of the picture the moment M
as red, green and blue, at the same place in the right half Omega. In a tile x runs to the right and y up, and a border
repeats the outermost values. Below and above there is an empty row (:mod:`shader_nodes.environment`). A shader mixes
the two slices about a place, so the values are continuous throughout.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.ao_field import FieldVolume
from ..core.field_inside import NODES
from .environment import direction_of, texture
from .expression import Expression, Graph, maximum, minimum
from .field_atlas import BORDER
from .functions import components, floor

COLUMNS, ROWS = NODES // 2, 4
_SIDE = NODES + 2 * BORDER


def volume_pixels(volume: FieldVolume) -> NDArray[np.float32]:
    """Pixels (ROWS side, 2 COLUMNS side, 4), bottom row first. Alpha is 1."""
    pixels = np.zeros((ROWS * _SIDE, 2 * COLUMNS * _SIDE, 4), np.float32)
    pixels[..., 3] = 1.0
    around = ((BORDER, BORDER), (BORDER, BORDER), (0, 0))
    for index in range(NODES):
        tile = np.pad(volume.values[:, :, index].swapaxes(0, 1), around, mode="edge")
        row, column = (1 + index // COLUMNS) * _SIDE, index % COLUMNS * _SIDE
        pixels[row : row + _SIDE, column : column + _SIDE, :3] = tile[..., :3]
        column += COLUMNS * _SIDE
        pixels[row : row + _SIDE, column : column + _SIDE, 0] = tile[..., 3]
    return pixels


def look_up(graph: Graph, x: Expression, low: Expression, size: Expression) -> tuple[Expression, Expression]:
    """M and Omega at ``x``, from the field's centre, in a box from ``low`` of ``size``; outside, as at its side.

    The textures are called "Volume 1" to "Volume 4".
    """
    with graph.frame("the volume: between which of its nodes x lies"):
        place = (minimum(maximum((x - low) / size, 0), 1) * (NODES - 1)).named("place")
        px, py, pz = components(place, "column", "row", "height")
        below = minimum(floor(pz), NODES - 2).named("slice")
        above = (pz - below).named("part")
        across, upwards = ((each + (BORDER + 0.5)) / _SIDE for each in (px, py))
    found = []
    for which in (0, 1):
        with graph.frame("the slice above" if which else "the slice below"):
            index = below + which
            row = floor(index / COLUMNS).named("tile row")
            right, up = (index - COLUMNS * row) + across, (1 + row) + upwards
            x_, y_, z_ = direction_of(right, up, 2 * COLUMNS, ROWS)
            moment = texture(graph, f"Volume {2 * which + 1}", x_, y_, z_)
            found.append((moment, texture(graph, f"Volume {2 * which + 2}", -x_, -y_, z_)))
    with graph.frame("M and Omega, mixed from both slices"):
        moment, omega = (first + above * (second - first) for first, second in zip(*found, strict=True))
        solid_angle, _, _ = components(omega, "Omega inside", "unused", "unused")
        return moment.named("M"), solid_angle
