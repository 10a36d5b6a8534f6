# SPDX-License-Identifier: GPL-3.0-or-later
"""A triangulated surface, and points on it by barycentric coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Points that lie on an edge are moved inside by this fraction of the triangle. On the edge itself a floor's point also
# lies in the wall's plane, and rays into the wall would start behind it.
INSET = 1e-3
# Triangles of a face that bend by less, as a sine, are one plane.
FLAT = 1e-6


@dataclass(frozen=True)
class Surface:
    """World-space triangles of one mesh; "corner" is a vertex as one face sees it (Blender's loop).

    vertices        (n, 3) float64
    corner_vertex   (c,) int32, vertex of each corner
    corner_normals  (c, 3) float64, unit length: the shading normals, split at sharp edges
    triangles       (m, 3) int32, corners of each triangle, counter-clockwise seen from the front
    face_start      (f,) int32, first corner of each face; its others follow, along its outline
    face_size       (f,) int32, number of its corners
    corner_uv       (c, 2) float64 or None
    """

    vertices: NDArray[np.float64]
    corner_vertex: NDArray[np.int32]
    corner_normals: NDArray[np.float64]
    triangles: NDArray[np.int32]
    face_start: NDArray[np.int32]
    face_size: NDArray[np.int32]
    corner_uv: NDArray[np.float64] | None = None

    @property
    def vertex_triangles(self) -> NDArray[np.int32]:
        """(m, 3) vertices of each triangle."""
        return self.corner_vertex[self.triangles]

    @property
    def extent(self) -> float:
        """Longest side of the faces' bounding box, world units. Loose vertices do not count."""
        return extent_of(self.vertices, self.corner_vertex)

    def barycentric_at(self, triangle: NDArray[np.integer], points: NDArray) -> NDArray[np.float64]:
        """Barycentric coordinates (k, 3) of world ``points`` (k, 3) that lie on triangles (k,); those without area give
        all to their first corner."""
        a, b, c = np.moveaxis(self.vertices[self.corner_vertex[self.triangles[triangle]]], 1, 0)
        normal = np.cross(b - a, c - a)
        area = np.einsum("kx,kx->k", normal, normal)
        weights = np.column_stack(
            [np.einsum("kx,kx->k", np.cross(q - p, points - p), normal) for p, q in ((b, c), (c, a), (a, b))]
        )
        weights = np.divide(
            weights, area[:, None], out=np.tile((1.0, 0.0, 0.0), (len(a), 1)), where=area[:, None] > 0.0
        )
        weights = np.clip(weights, 0.0, 1.0)
        return weights / weights.sum(axis=1, keepdims=True)

    def split_vertices(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.intp]]:
        """One point for each different normal at a vertex: what the corners of flat and sharp faces need.

        Returns positions (k, 3), normals (k, 3), and each corner's index into them (c,). Corners that share a vertex
        and its normal share a point, so smooth regions stay smooth. Positions are inset into the faces of their
        corners, and lie below none of the triangles of these.
        """
        steps = np.rint(self.corner_normals * 1e4).astype(np.int64)
        key = ((steps[:, 0] * 20011 + steps[:, 1]) * 20011 + steps[:, 2]) & (2**32 - 1)
        key |= self.corner_vertex.astype(np.int64) << 32
        _, first, split = np.unique(key, return_index=True, return_inverse=True)
        split = split.reshape(-1)
        count = np.bincount(split)
        inwards = into_faces(self.vertices[self.corner_vertex], self.face_start, self.face_size)
        inwards += self._rise(inwards)[:, None] * self.corner_normals
        inset = np.column_stack([np.bincount(split, weights=axis) / count for axis in inwards.T])
        return self.vertices[self.corner_vertex[first]] + INSET * inset, self.corner_normals[first], split

    def _rise(self, inwards: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far (c,) along their normals the vectors ``inwards`` (c, 3) of the corners must go for no triangle of
        their face to be above them, where that face is not planar."""
        rise = np.zeros(len(inwards))
        if (self.face_size <= 3).all():
            return rise
        a, b, c = self.vertices[self.corner_vertex[self.triangles.T]]
        normal = unit(np.cross(b - a, c - a))
        for corner in self.triangles.T:
            below = -np.einsum("mx,mx->m", inwards[corner], normal)
            bent = np.flatnonzero(below > FLAT * lengths(inwards[corner]))
            facing = np.einsum("mx,mx->m", self.corner_normals[corner[bent]], normal[bent])
            np.maximum.at(rise, corner[bent], below[bent] / np.maximum(facing, 0.1))
        return rise


def extent_of(vertices: NDArray, used: NDArray[np.integer]) -> float:
    """Longest side of the bounding box of those ``vertices`` (n, 3) that the indices ``used`` name."""
    is_used = np.zeros(len(vertices), bool)
    is_used[used] = True
    return max(float(np.ptp(axis[is_used])) for axis in np.asarray(vertices).T)


def unit(vectors: NDArray) -> NDArray[np.float64]:
    """``vectors`` (n, 3) of length 1; +z for those without a direction."""
    vectors = np.asarray(vectors, np.float64)
    length = lengths(vectors)[:, None]
    return np.where(length > 1e-30, vectors / np.maximum(length, 1e-30), (0.0, 0.0, 1.0))


def lengths(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length (n,) of each of ``vectors`` (n, 3): numpy.linalg.norm along an axis is slower."""
    return np.sqrt(np.einsum("nx,nx->n", vectors, vectors))


def into_faces(
    corners: NDArray[np.float64], face_start: NDArray[np.int32], face_size: NDArray[np.int32]
) -> NDArray[np.float64]:
    """Vectors (c, 3) from ``corners`` (c, 3) into their faces, along the bisector, as long as half the shorter edge.

    With u the way to the next corner, w the way to the one before and n the face's normal, n x (u - w) points inwards
    also where the outline turns back, and where it is straight.
    """
    index = np.arange(len(corners))
    following, before = index + 1, index - 1
    following[face_start + face_size - 1] = face_start
    before[face_start] = face_start + face_size - 1
    # Axis first from here on, so that numpy runs along the corners.
    axes = np.ascontiguousarray(corners.T)
    ahead, back = axes[:, following] - axes, axes[:, before] - axes
    # Newell's normal, from the face's first corner so that it keeps its digits far from the origin.
    from_first = axes - np.repeat(axes[:, face_start], face_size, axis=1)
    normal = np.add.reduceat(np.cross(from_first, ahead, axis=0), face_start, axis=1)
    inwards = np.cross(np.repeat(normal, face_size, axis=1), _direction(ahead) - _direction(back), axis=0)
    shorter = np.sqrt(np.minimum(np.square(ahead).sum(axis=0), np.square(back).sum(axis=0)))
    return (0.5 * shorter * _direction(inwards)).T


def _direction(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """``vectors`` (3, n) at length 1, those of no length as they are."""
    length = np.sqrt(np.square(vectors).sum(axis=0))
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)


def join(surfaces: Sequence[Surface]) -> Surface:
    """All of ``surfaces`` (at least one) as one, without UVs."""
    vertices = np.cumsum([0, *(len(each.vertices) for each in surfaces)])
    corners = np.cumsum([0, *(len(each.corner_vertex) for each in surfaces)])

    def joined(field: str, first: NDArray | None = None) -> NDArray:
        parts = [getattr(each, field) for each in surfaces]
        if first is not None:
            parts = [(part + start).astype(np.int32) for part, start in zip(parts, first, strict=False)]
        return np.concatenate(parts)

    return Surface(
        vertices=joined("vertices"),
        corner_vertex=joined("corner_vertex", vertices),
        corner_normals=joined("corner_normals"),
        triangles=joined("triangles", corners),
        face_start=joined("face_start", corners),
        face_size=joined("face_size"),
    )
