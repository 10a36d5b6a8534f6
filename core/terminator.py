# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rays start on a coarse mesh that is shaded smooth.

Smooth shading shows a curved surface where there are flat faces. Between the vertices of what bulges, the hemisphere
about the shading normal reaches below the face, and rays into that part are blocked by the mesh itself: dark bands, the
"shadow terminator". So rays start as far above the face as it takes for the whole of it to lie below that hemisphere,
as it lies below a curved surface's; but no higher than that surface, as the normals at the corners tell of it (Phong
tessellation: Boubekeur and Alexa 2008). Where that lies below the face, in what is hollow, nothing is lifted.

`make bench ARGS=terminator` compares this with leaving out the rays below the face, and with starting on the curved
surface itself, as in Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021.
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
    """Heights over the points of triangles with corners at ``positions`` (3 corners, 3 axes, m), with unit ``normals``
    (the same shape). Memory: 36 bytes a triangle."""

    def __init__(self, positions: NDArray[np.float64], normals: NDArray[np.float64]):
        # [i - 1][k] = (p_i - p_0) . n_k
        edges = positions[1:] - positions[0]
        self._rise = np.einsum("iam,kam->ikm", edges, normals).astype(np.float32)
        # 1 - n_j . n_k for the three pairs
        self._bend = np.stack([1.0 - (normals[j] * normals[j - 1]).sum(axis=0) for j in range(3)]).astype(np.float32)
        size = np.abs(edges).max(initial=0.0)
        self.is_flat = not (np.abs(self._rise).max(initial=0.0) > FLAT * size)

    def heights(
        self, triangle: NDArray[np.intp], v: NDArray, w: NDArray
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """For the points p with weights ``v`` and ``w`` of the second and third corner: how far the highest corner
        rises over the plane on the shading normal n at p, the largest (p_i - p) . n; and how far the curved surface
        does over p, the sum of w_i (p_i - p) . n_i. All of one shape, in the units of the positions."""
        v, w = v.astype(np.float32), w.astype(np.float32)
        weights = 1.0 - v - w, v, w
        rise = [[each.take(triangle) for each in row] for row in self._rise]
        point = [rise[0][k] * v + rise[1][k] * w for k in range(3)]
        # |u n_0 + v n_1 + w n_2|^2 = 1 - 2 times the sum over pairs of weights (1 - n_j . n_k)
        bend = sum(self._bend[j].take(triangle) * weights[j] * weights[j - 1] for j in range(3))
        mean = sum(weights[k] * point[k] for k in range(3))
        second, third = (sum(weights[k] * row[k] for k in range(3)) for row in rise)
        highest = np.maximum(np.maximum(second, third), 0.0) - mean
        highest /= np.sqrt(np.maximum(1.0 - 2.0 * bend, 1e-6))
        return highest, v * rise[0][1] + w * rise[1][2] - mean


class Polygons:
    """The corners of faces of more than four, which stand out beyond their triangles.

    corner_positions  (c, 3) float64, of a surface's corners
    face_start        (f,) int, first corner of each face
    face_size         (f,) int, number of its corners
    first_corner      (m,) int, one corner of each triangle
    """

    def __init__(self, corner_positions, face_start, face_size, first_corner):
        many = np.flatnonzero(face_size > 4)
        self._count = np.minimum(face_size[many], MOST_CORNERS)
        self._start = np.cumsum(self._count) - self._count
        which, part = expand(np.zeros_like(self._count), self._count)
        self._positions = corner_positions[face_start[many][part] + which * face_size[many][part] // self._count[part]]
        face = np.searchsorted(face_start, first_corner, side="right") - 1
        number = np.full(len(face_start), -1)
        number[many] = np.arange(len(many))
        self._polygon = number[face]

    def __bool__(self) -> bool:
        """Whether there is any such face."""
        return len(self._count) > 0

    def raise_highest(self, highest: NDArray[np.float32], triangle: NDArray[np.intp], positions, normals) -> None:
        """Raise ``highest`` (...) of :meth:`Terminator.heights` in place where a polygon of which ``triangle`` (...)
        is a part has higher corners. ``positions`` and unit ``normals`` (3, ...) of the points."""
        polygon = self._polygon.take(triangle)
        chosen = np.nonzero(polygon >= 0)
        if not len(chosen[0]):
            return
        at, normal = (each[(slice(None), *chosen)].T for each in (positions, normals))
        count = self._count.take(polygon[chosen])
        corner, point = expand(self._start.take(polygon[chosen]), count)
        height = np.einsum("cx,cx->c", self._positions[corner] - at[point], normal[point])
        highest[chosen] = np.maximum(highest[chosen], np.maximum.reduceat(height, np.cumsum(count) - count))
