# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the occluders' triangles lie, which way they face, how large they are: what their cells follow from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rays import Occluders
from .workers import Workers, slices

BACK_OF = np.int8(26)  # facing of a face's back and front together
TRIANGLES_PER_PART = 2**15


@dataclass(frozen=True)
class Faces:
    """The m triangles of the occluders and, last, their infinite floor; 17 bytes each. In the units that Embree sees.

    middle   (m + 1, 3) float32, mean of the corners
    facing   (m + 1,) int8, of the front (:func:`facing_of`)
    longest  (m + 1,) float32, length of the longest edge; inf of the floor
    """

    middle: NDArray[np.float32]
    facing: NDArray[np.int8]
    longest: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.facing)

    @classmethod
    def of(cls, occluders: Occluders, workers: Workers) -> Faces:
        triangles, vertices, count = occluders.triangles, occluders.vertices, len(occluders.triangles)
        faces = cls(np.zeros((count + 1, 3), np.float32), np.zeros(count + 1, np.int8), np.empty(count + 1, np.float32))
        faces.longest[count] = np.inf

        def fill(part: slice) -> None:
            a, b, c = (vertices.take(corner, axis=0) for corner in triangles[part].T)
            faces.middle[part] = (a + b + c) / np.float32(3.0)
            faces.facing[part] = facing_of(np.cross(b - a, c - a))
            edges = [np.square(p - q).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))]
            faces.longest[part] = np.sqrt(np.max(edges, axis=0))

        workers.map(fill, slices(count, TRIANGLES_PER_PART))
        return faces


def facing_of(normals: NDArray) -> NDArray[np.int8]:
    """The nearest (k,) of 26 directions, 0 to 26 without 13, to ``normals`` (k, 3) of any length: those to the
    neighbours of a cube among 27."""
    x, y, z = (np.ascontiguousarray(axis) for axis in normals.T)
    largest = np.maximum(np.maximum(np.abs(x), np.abs(y)), np.maximum(np.abs(z), np.finfo(x.dtype).tiny))
    steps = [np.rint(axis / largest).astype(np.int8) for axis in (x, y, z)]
    return (9 * steps[0] + 3 * steps[1] + steps[2] + 13).astype(np.int8)
