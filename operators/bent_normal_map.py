# SPDX-License-Identifier: GPL-3.0-or-later
"""The bent normal map of a texture bake: the middle of what each texel sees, as other programs read normal maps."""

from __future__ import annotations

from dataclasses import dataclass

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.rasterise import Texels
from ..core.surface import unit
from ..core.tangent_space import Tangents, as_colours, at_texels, to_tangent_space
from .mesh_reader import front_facing, read, read_triangles
from .settings import BakeSettings

_CORNER = "multibounce_ao_corner"


@dataclass(frozen=True)
class BentNormalMap:
    """How the bent directions of one object become colours.

    triangles, normals, tangents  of its mesh, for :func:`core.tangent_space.at_texels`; no tangents in object space
    to_map   (3, 3), takes world directions to object space as the renderer takes normals from there: by the transpose
             of the object's linear transform. Under an uneven scale that differs from how directions go
    flip_y   DirectX' green
    """

    triangles: NDArray[np.int32]
    normals: NDArray[np.float32]
    tangents: Tangents | None
    to_map: NDArray[np.float64]
    flip_y: bool

    @property
    def is_tangent(self) -> bool:
        return self.tangents is not None

    def background(self) -> NDArray[np.float32]:
        """Colour (4,) of texels that show nothing: as Blender's bakes of normals, +z in tangent space, else black."""
        return np.array((0.5, 0.5, 1.0, 1.0) if self.is_tangent else (0.0, 0.0, 0.0, 1.0), np.float32)

    def colours(self, texels: Texels, bent: NDArray) -> NDArray[np.float32]:
        """Colours (k, 4) of ``texels`` with mean visible directions ``bent`` (k, 3), world axes; a texel that sees
        nothing shows its normal."""
        frames = at_texels(texels, self.triangles, self.normals, self.tangents)
        directions = bent.astype(np.float64) @ self.to_map.T
        directions = np.where(bent.any(axis=1, keepdims=True), directions, frames[:, -1])
        return as_colours(to_tangent_space(directions, frames) if self.is_tangent else unit(directions), self.flip_y)


def read_bent_normal_map(
    mesh: bpy.types.Mesh, matrix: NDArray, uv_map: str, settings: BakeSettings
) -> BentNormalMap | None:
    """What the map of an evaluated ``mesh`` at ``matrix`` (4, 4) needs; None where ``settings`` ask for no map."""
    if not settings.use_bent_normal_map:
        return None
    triangles = front_facing(read_triangles(mesh), matrix)
    normals, tangents = read(mesh.corner_normals, "vector", 3, np.float32), None
    if settings.bent_normal_space == "TANGENT":
        has_large_faces = read(mesh.polygons, "loop_total", 1, np.int32).max(initial=0) > 4
        tangents = _tangents_of_triangulated(mesh, normals, uv_map) if has_large_faces else _tangents(mesh, uv_map)
    return BentNormalMap(triangles, normals, tangents, matrix[:3, :3].T, settings.bent_normal_y == "NEG_Y")


def _tangents(mesh: bpy.types.Mesh, uv_map: str) -> Tangents:
    """Of a mesh of triangles and quads, by Blender's MikkTSpace."""
    mesh.calc_tangents(uvmap=uv_map)
    result = Tangents(read(mesh.loops, "tangent", 3, np.float32), read(mesh.loops, "bitangent_sign", 1, np.float32))
    mesh.free_tangents()
    return result


def _tangents_of_triangulated(mesh: bpy.types.Mesh, normals: NDArray[np.float32], uv_map: str) -> Tangents:
    """The same of a mesh with larger faces, which MikkTSpace does not know: from a copy of which those are cut into
    triangles."""
    copy = mesh.copy()
    try:
        copy.attributes.new(_CORNER, "INT", "CORNER").data.foreach_set("value", np.arange(len(normals), dtype=np.int32))
        cut = bmesh.new()
        cut.from_mesh(copy)
        bmesh.ops.triangulate(cut, faces=[face for face in cut.faces if len(face.verts) > 4])
        cut.to_mesh(copy)
        cut.free()
        corner = read(copy.attributes[_CORNER].data, "value", 1, np.int32)
        copy.normals_split_custom_set(normals[corner])
        tangents = _tangents(copy, uv_map)
    finally:
        bpy.data.meshes.remove(copy)
    # Each corner of a face is in one of its triangles at least.
    vectors, signs = np.empty_like(normals), np.empty(len(normals), np.float32)
    vectors[corner], signs[corner] = tangents.vectors, tangents.signs
    return Tangents(vectors, signs)
