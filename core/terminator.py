# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start on a coarse mesh that is shaded smooth.

Smooth shading shows a curved surface where there are flat faces. Between the vertices of what bulges, the hemisphere
about the shading normal reaches below the face, and rays into that part are blocked by the mesh itself: dark bands, the
"shadow terminator". So rays start as far above the face as it takes for the whole of it to lie below that hemisphere,
as it lies below a curved surface's. In what is hollow the face lies above the hemisphere rightly; there nothing is
lifted. That is told apart by the planes that the normals at the corners stand on (Hanika, "Hacking the Shadow
Terminator", Ray Tracing Gems II, 2021, which lifts by their distances themselves).

`make bench ARGS=terminator` compares this with Hanika's lift and with leaving out the rays below the face.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .scan_conversion import expand

# Of an n-gon's corners so many are looked at, evenly along its outline.
MOST_CORNERS = 32
# Lifts smaller than this part of the surface's largest triangle do not show.
FLAT = 1e-6


class Terminator:
    """The lifts of the points of triangles with corners at ``positions`` (3 corners, 3 axes, m), with unit ``normals``
    (the same shape). Memory: 36 bytes a triangle."""

    def __init__(self, positions: NDArray[np.float64], normals: NDArray[np.float64]):
        # [i - 1][k] = (p_i - p_0) . n_k
        edges = positions[1:] - positions[0]
        self._rise = np.einsum("iam,kam->ikm", edges, normals).astype(np.float32)
        # 1 - n_j . n_k for the three pairs
        self._bend = np.stack([1.0 - (normals[j] * normals[j - 1]).sum(axis=0) for j in range(3)]).astype(np.float32)
        size = np.abs(edges).max(initial=0.0)
        self.is_flat = not (np.abs(self._rise).max(initial=0.0) > FLAT * size)

    def lift(self, triangle: NDArray[np.intp], v: NDArray, w: NDArray) -> NDArray[np.float64]:
        """How far along their interpolated normals the points with weights ``v`` and ``w`` of the second and third
        corner start above their triangles; all of one shape, >= 0, in the units of the positions.

        Over the corners i, the largest height of p_i over the plane on the shading normal at the point, but no more
        than its own plane's height over the point: the largest min((p_i - p) . n, (p_i - p) . n_i).
        """
        weights = 1.0 - v - w, v, w
        rise = [[each.take(triangle) for each in row] for row in self._rise]
        point = [rise[0][k] * v + rise[1][k] * w for k in range(3)]
        # |u n_0 + v n_1 + w n_2|^2 = 1 - 2 times the sum over pairs of weights (1 - n_j . n_k)
        bend = sum(self._bend[j].take(triangle) * weights[j] * weights[j - 1] for j in range(3))
        length = np.sqrt(np.maximum(1.0 - 2.0 * bend, 1e-6))
        mean = sum(weights[k] * point[k] for k in range(3))
        lift = np.zeros(np.shape(v))
        for i in range(3):
            own = rise[i - 1][i] if i else 0.0
            along = sum(weights[k] * rise[i - 1][k] for k in range(3)) if i else 0.0
            np.maximum(lift, np.minimum((along - mean) / length, own - point[i]), out=lift)
        return lift


class Polygons:
    """The same for faces of more than four corners, which stand out beyond their triangles.

    corner_positions, corner_normals  (c, 3) float64 of a surface's corners
    face_start, face_size             (f,) int, first corner of each face, and their number
    first_corner                      (m,) int, one corner of each triangle
    """

    def __init__(self, corner_positions, corner_normals, face_start, face_size, first_corner):
        many = np.flatnonzero(face_size > 4)
        self._count = np.minimum(face_size[many], MOST_CORNERS)
        self._start = np.cumsum(self._count) - self._count
        which, part = expand(np.zeros_like(self._count), self._count)
        corner = face_start[many][part] + which * face_size[many][part] // self._count[part]
        self._positions, self._normals = corner_positions[corner], corner_normals[corner]
        face = np.searchsorted(face_start, first_corner, side="right") - 1
        number = np.full(len(face_start), -1)
        number[many] = np.arange(len(many))
        self._polygon = number[face]

    def __bool__(self) -> bool:
        """Whether there is any such face."""
        return len(self._count) > 0

    def raise_lift(self, lift: NDArray[np.float64], triangle: NDArray[np.intp], positions, normals) -> None:
        """Raise ``lift`` (...) in place where points at ``positions`` with unit ``normals``, each (3, ...), on
        ``triangle`` (...) need more because of their polygon's other corners."""
        polygon = self._polygon.take(triangle)
        chosen = np.nonzero(polygon >= 0)
        if not len(chosen[0]):
            return
        polygon = polygon[chosen]
        at, normal = (each[(slice(None), *chosen)].T for each in (positions, normals))
        corner, point = expand(self._start.take(polygon), self._count.take(polygon))
        way = self._positions[corner] - at[point]
        height = np.minimum(
            np.einsum("cx,cx->c", way, normal[point]), np.einsum("cx,cx->c", way, self._normals[corner])
        )
        ends = np.cumsum(self._count.take(polygon))
        lift[chosen] = np.maximum(lift[chosen], np.maximum.reduceat(height, ends - self._count.take(polygon)))
