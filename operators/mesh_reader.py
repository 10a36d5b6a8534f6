# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender meshes as numpy arrays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.surface import Surface, unit
from .report import BakeError


@dataclass(frozen=True)
class MeshTriangles:
    """What a mesh is drawn as, in object space. Reading copies; what is computed with it needs no Blender, so that
    another thread can.

    positions      (n, 3) float32
    corner_vertex  (c,) int32, vertex of each face corner
    triangles      (m, 3) int32, corners of each triangle
    """

    positions: NDArray[np.float32]
    corner_vertex: NDArray[np.int32]
    triangles: NDArray[np.int32]


@dataclass(frozen=True)
class MeshArrays(MeshTriangles):
    """And what a bake needs besides.

    face_start  (f,) int32, first corner of each face
    normals     (n, 3) or (c, 3) float32, of vertices or corners
    uv          (c, 2) float32, or None
    """

    face_start: NDArray[np.int32]
    normals: NDArray[np.float32]
    uv: NDArray[np.float32] | None = None

    def surface(self, matrix: NDArray) -> Surface:
        """In world space; ``normals`` are of corners. Raises BakeError for a ``matrix`` with zero scale."""
        return Surface(
            vertices=to_world(self.positions, matrix),
            corner_vertex=self.corner_vertex,
            corner_normals=unit(self.normals @ linear_inverse(matrix)),
            triangles=front_facing(self.triangles, matrix),
            face_start=self.face_start,
            face_size=np.diff(self.face_start, append=np.int32(len(self.corner_vertex))),
            corner_uv=None if self.uv is None else self.uv.astype(np.float64),
        )


@contextmanager
def evaluated_mesh(evaluated: bpy.types.Object) -> Iterator[bpy.types.Mesh | None]:
    """The triangulated mesh of an evaluated object (mesh, curve, text, ...), or None where it has none."""
    try:
        mesh = evaluated.to_mesh()
    except RuntimeError:
        mesh = None
    try:
        if mesh is not None:
            mesh.calc_loop_triangles()
        yield mesh
    finally:
        evaluated.to_mesh_clear()


def read(collection, attribute: str, width: int, dtype: type) -> NDArray:
    """``attribute`` of every element, as (n, width), or (n,) where ``width`` is 1."""
    values = np.empty(len(collection) * width, dtype)
    if len(values):
        collection.foreach_get(attribute, values)
    return values if width == 1 else values.reshape(-1, width)


def read_positions(mesh: bpy.types.Mesh) -> NDArray[np.float32]:
    """Vertex positions (n, 3), object space."""
    return _read_attribute(mesh, "position", "vector", 3, np.float32)


def read_corner_vertices(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """The vertex (c,) of each face corner."""
    return _read_attribute(mesh, ".corner_vert", "value", 1, np.int32)


def _read_attribute(mesh: bpy.types.Mesh, name: str, prop: str, width: int, dtype: type) -> NDArray:
    """An attribute is copied as it lies in memory; the properties of vertices and loops that show the same are asked
    for one by one."""
    attribute = mesh.attributes.get(name)  # none where the mesh has no such element
    return read(attribute.data if attribute else (), prop, width, dtype)


def read_triangles(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """Corners (m, 3) of the triangles that the faces are drawn as."""
    if _all_triangles(mesh):
        return np.arange(len(mesh.loops), dtype=np.int32).reshape(-1, 3)
    return read(mesh.loop_triangles, "loops", 3, np.int32)


def read_face_starts(mesh: bpy.types.Mesh) -> NDArray[np.int32]:
    """The first corner (f,) of each face."""
    if _all_triangles(mesh):
        return np.arange(0, len(mesh.loops), 3, dtype=np.int32)
    return read(mesh.polygons, "loop_start", 1, np.int32)


def _all_triangles(mesh: bpy.types.Mesh) -> bool:
    """Whether there is nothing to read, as Blender gives triangles and faces one by one: no face has fewer corners."""
    return len(mesh.loops) == 3 * len(mesh.polygons)


def to_world(points: NDArray, matrix: NDArray) -> NDArray[np.float64]:
    """``points`` (n, 3) through a 4x4 ``matrix``, in float64: precision survives far from the origin.

    What is not finite stays so, without a word.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        return points.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]


def linear_inverse(matrix: NDArray) -> NDArray[np.float64]:
    """Inverse (3, 3) of the linear part of a 4x4 ``matrix``: world directions to object space, and normals to the
    world.

    Raises BakeError for a scale of zero.
    """
    linear = matrix[:3, :3]
    # The volume of the transformed unit cube, against that of the box with the same edges: 0 where one vanishes or
    # lies in the plane of the others, whatever the unit.
    if not abs(np.linalg.det(linear)) > 1e-6 * np.prod(np.linalg.norm(linear, axis=0)):
        raise BakeError("has a scale of zero: set its scale")
    return np.linalg.inv(linear)


def front_facing(triangles: NDArray[np.int32], matrix: NDArray) -> NDArray[np.int32]:
    """``triangles`` (m, 3) turned over where ``matrix`` mirrors, so that they keep their front."""
    return triangles[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else triangles


def read_mesh_triangles(mesh: bpy.types.Mesh) -> MeshTriangles:
    return MeshTriangles(read_positions(mesh), read_corner_vertices(mesh), read_triangles(mesh))


def read_mesh(mesh: bpy.types.Mesh, domain: str = "CORNER", uv_map: str | None = None) -> MeshArrays:
    """``mesh`` with the normals of its ``domain``, "POINT" or "CORNER"; ``uv_map`` must exist."""
    normals = mesh.vertex_normals if domain == "POINT" else mesh.corner_normals
    return MeshArrays(
        positions=read_positions(mesh),
        corner_vertex=read_corner_vertices(mesh),
        triangles=read_triangles(mesh),
        face_start=read_face_starts(mesh),
        normals=read(normals, "vector", 3, np.float32),
        uv=None if uv_map is None else read(mesh.uv_layers[uv_map].uv, "vector", 2, np.float32),
    )
