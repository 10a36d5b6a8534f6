# SPDX-License-Identifier: GPL-3.0-or-later
"""Selected to active: which objects are baked onto which, and their surfaces."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.projection import HighSurface
from ..core.surface import Surface, join
from .mesh_reader import MeshArrays, evaluated_mesh, read_corner_vertices, read_mesh, read_positions, to_world
from .occluder_reader import SURFACE_TYPES
from .report import BakeError
from .settings import BakeSettings

# Name_low, Name_low.001; Name_high, Name_high_screws, Name_high.001: letters may be of either case.
_LOW = re.compile(r"(.+)_low(?:\.\d+)?", re.IGNORECASE)
_HIGH = re.compile(r"(.+)_high(?:[._].*)?", re.IGNORECASE)

Sources = dict[bpy.types.Object, frozenset[bpy.types.Object]]


@dataclass(frozen=True)
class Projection:
    """The ``surface`` that a bake shows, made ready for its rays as ``high``, and ``cage`` positions (n, 3) of the low
    mesh's vertices, world space; None: rays follow the low normals."""

    surface: Surface
    high: HighSurface
    cage: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class ProjectionSource:
    """What a :class:`Projection` is made of: the ``meshes`` that it shows with their matrices (4, 4), and their
    ``names``, to be told; ``extrusion`` and ``reach`` as for :class:`core.projection.HighSurface`."""

    meshes: tuple[tuple[MeshArrays, NDArray[np.float64]], ...]
    names: str
    extrusion: float
    reach: float
    cage: NDArray[np.float64] | None

    def projection(self) -> Projection:
        """Needs no Blender. Raises BakeError."""
        surface = join([mesh.surface(matrix) for mesh, matrix in self.meshes])
        if not np.isfinite(surface.vertices).all():
            raise BakeError(
                f"is to show {self.names}, whose coordinates are not all finite numbers: delete or move those"
            )
        return Projection(surface, HighSurface(surface, self.extrusion, self.reach), self.cage)


def pairs(
    objects: list[bpy.types.Object], selected: Collection[bpy.types.Object], settings: BakeSettings
) -> Sources | None:
    """For each object to bake to, in order, those that are baked onto it; None where each is baked for itself.

    The first of ``objects`` is the active one. Raises BakeError where there is no pair.
    """
    if not settings.use_selected_to_active:
        return None
    candidates = [*objects, *(obj for obj in selected if obj not in objects)]
    candidates = [obj for obj in candidates if obj.type in SURFACE_TYPES]
    if not settings.use_match_names:
        others = frozenset(candidates[1:])
        if not others:
            raise BakeError(
                f"Selected to Active needs what to bake onto the active object '{objects[0].name}': select it too"
            )
        return {objects[0]: others}
    found: Sources = {}
    for obj in objects:
        if match := _LOW.fullmatch(obj.name):
            stem = match[1].lower()
            found[obj] = frozenset(
                other for other in candidates if (high := _HIGH.fullmatch(other.name)) and high[1].lower() == stem
            )
    if not found:
        raise BakeError(
            "Match Names needs objects called 'Name_low' and 'Name_high': rename those to bake, and select both"
        )
    return found


def read_projection(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    low: bpy.types.Mesh,
    sources: Collection[bpy.types.Object],
    settings: BakeSettings,
) -> ProjectionSource:
    """What a bake onto ``obj``, whose evaluated mesh is ``low``, shows. Raises BakeError."""
    if not sources:
        raise BakeError(f"has no partner: select an object called '{_LOW.fullmatch(obj.name)[1]}_high' too")
    depsgraph = context.evaluated_depsgraph_get()
    meshes = []
    for source in sorted(sources, key=lambda each: each.name):
        if not source.visible_get(view_layer=context.view_layer):
            raise BakeError(f"is to show '{source.name}', which is hidden in the viewport: show it first")
        evaluated = source.evaluated_get(depsgraph)
        with evaluated_mesh(evaluated) as mesh:
            if mesh is not None and mesh.polygons:
                meshes.append((read_mesh(mesh), np.array(evaluated.matrix_world, np.float64)))
    names = ", ".join(f"'{source.name}'" for source in sources)
    if not meshes:
        raise BakeError(f"is to show {names}, which has no faces: add some, or select another object")
    cage = _cage(depsgraph, low, settings.cage_object)
    return ProjectionSource(tuple(meshes), names, settings.cage_extrusion, settings.max_ray_distance or np.inf, cage)


def _cage(
    depsgraph: bpy.types.Depsgraph, low: bpy.types.Mesh, cage: bpy.types.Object | None
) -> NDArray[np.float64] | None:
    if cage is None:
        return None
    evaluated = cage.evaluated_get(depsgraph)
    with evaluated_mesh(evaluated) as mesh:
        if mesh is None or not np.array_equal(read_corner_vertices(mesh), read_corner_vertices(low)):
            raise BakeError(
                f"needs a cage with the same faces, but those of '{cage.name}' differ: make the cage from a copy of it"
            )
        positions = to_world(read_positions(mesh), np.array(evaluated.matrix_world, np.float64))
    if not np.isfinite(positions).all():
        raise BakeError(f"has the cage '{cage.name}' with coordinates that are not finite: delete or move those")
    return positions
