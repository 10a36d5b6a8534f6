# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles as embreex takes them: in meshes of a bounded size, and the numbers that it then gives them.

It copies each number under Python's lock, about a second for a million triangles. Other threads, as the one that draws
a window, get on only between meshes.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .workers import slices

TRIANGLES_PER_MESH = 2**16


def mesh_parts(
    vertices: NDArray[np.float32], triangles: NDArray[np.int32]
) -> Iterator[tuple[NDArray[np.float64], NDArray[np.object_]]]:
    """The ``triangles`` (m, 3) in their order, TRIANGLES_PER_MESH at a time: of the ``vertices`` (n, 3) the (k, 3) that
    they need, and their corners (t,), each a tuple of three of these.

    embreex takes number after number out of them, from tuples and doubles sooner than from rows and single precision.
    """
    for part in slices(len(triangles), TRIANGLES_PER_MESH):
        first = triangles[part].min()
        local = triangles[part] - first
        used = np.zeros(local.max() + 1, bool)
        used[local] = True
        number = np.cumsum(used, dtype=np.int32) - 1
        corners = number[local].view("i4,i4,i4").reshape(-1)
        yield vertices[first : first + len(used)][used].astype(np.float64), corners.astype(object)


def triangle_numbers(found: dict[str, NDArray]) -> NDArray[np.int32]:
    """Which triangles Embree has ``found``, -1 where none: it counts those of each of the meshes anew."""
    return np.where(found["primID"] < 0, -1, found["primID"] + TRIANGLES_PER_MESH * found["geomID"])
