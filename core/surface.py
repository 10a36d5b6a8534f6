# SPDX-License-Identifier: GPL-3.0-or-later
"""A triangulated surface, and points on it by barycentric coordinates."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Points that lie on an edge are moved inside by this fraction of the triangle. On the edge itself a floor's point also
# lies in the wall's plane, and rays into the wall would start behind it.
INSET = 1e-3


@dataclass(frozen=True)
class Surface:
    """World-space triangles of one mesh; "corner" is a vertex as one face sees it (Blender's loop).

    vertices        (n, 3) float64
    corner_vertex   (c,) int32, vertex of each corner
    corner_normals  (c, 3) float64, unit length: the shading normals, split at sharp edges
    corner_inset    (c, 3) float64, vector from each corner's vertex to its face's centre
    triangles       (m, 3) int32, corners of each triangle, counter-clockwise seen from the front
    corner_uv       (c, 2) float64 or None
    """

    vertices: NDArray[np.float64]
    corner_vertex: NDArray[np.int32]
    corner_normals: NDArray[np.float64]
    corner_inset: NDArray[np.float64]
    triangles: NDArray[np.int32]
    corner_uv: NDArray[np.float64] | None = None

    @property
    def vertex_triangles(self) -> NDArray[np.int32]:
        """(m, 3) vertices of each triangle."""
        return self.corner_vertex[self.triangles]

    @property
    def extent(self) -> float:
        """Longest side of the bounding box, world units."""
        return float(np.ptp(self.vertices, axis=0).max())

    def positions_at(self, triangle: NDArray[np.integer], barycentric: NDArray) -> NDArray[np.float64]:
        """Points (k, 3) at ``barycentric`` (k, 3) of triangles (k,)."""
        corners = self.vertices[self.corner_vertex[self.triangles[triangle]]]
        return np.einsum("kc,kcx->kx", barycentric, corners)

    def normals_at(self, triangle: NDArray[np.integer], barycentric: NDArray) -> NDArray[np.float64]:
        """Smooth unit normals (k, 3); the triangle's own where the corners' cancel out."""
        normals = np.einsum("kc,kcx->kx", barycentric, self.corner_normals[self.triangles[triangle]])
        length = np.linalg.norm(normals, axis=1)
        flat = np.flatnonzero(length < 1e-6)
        if len(flat):
            a, b, c = np.moveaxis(self.vertices[self.corner_vertex[self.triangles[triangle[flat]]]], 1, 0)
            normals[flat] = np.cross(b - a, c - a)
        return unit(normals)

    def split_vertices(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.intp]]:
        """One point for each different normal at a vertex: what the corners of flat and sharp faces need.

        Returns positions (k, 3), normals (k, 3), and each corner's index into them (c,). Corners that share a vertex
        and its normal share a point, so smooth regions stay smooth. Positions are inset into the faces of their
        corners.
        """
        steps = np.rint(self.corner_normals * 1e4).astype(np.int64)
        key = ((steps[:, 0] * 20011 + steps[:, 1]) * 20011 + steps[:, 2]) & (2**32 - 1)
        key |= self.corner_vertex.astype(np.int64) << 32
        _, first, split = np.unique(key, return_index=True, return_inverse=True)
        split = split.reshape(-1)
        count = np.bincount(split)
        inset = np.column_stack([np.bincount(split, weights=axis) for axis in self.corner_inset.T]) / count[:, None]
        return self.vertices[self.corner_vertex[first]] + INSET * inset, self.corner_normals[first], split


def unit(vectors: NDArray) -> NDArray[np.float64]:
    """``vectors`` (n, 3) of length 1; +z for those without a direction."""
    vectors = np.asarray(vectors, np.float64)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 1e-30, vectors / np.maximum(length, 1e-30), (0.0, 0.0, 1.0))


def inset_barycentric(barycentric: NDArray[np.float64]) -> NDArray[np.float64]:
    """``barycentric`` (k, 3) kept off the triangle's edges by :data:`INSET`."""
    return (1.0 - INSET) * barycentric + INSET / 3.0
