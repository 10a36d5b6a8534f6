# SPDX-License-Identifier: GPL-3.0-or-later
"""What blocks rays: the evaluated scene with its modifiers and instances, as one set of triangles."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from .mesh_reader import MeshTriangles, evaluated_mesh, front_facing, read_mesh_triangles, to_world

# Objects that evaluate to faces.
SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


@dataclass(frozen=True)
class PlacedMesh:
    """The ``mesh`` of an object called ``name``, or of an instance that it makes, which ``matrix`` (4, 4) places in the
    world."""

    name: str
    mesh: MeshTriangles
    matrix: NDArray[np.float64]

    def in_world(self) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.bool_] | None]:
        """Vertices (n, 3), zero where they are not finite; triangles (m, 3) of them, counter-clockwise seen from the
        front, none with coordinates that are not finite; and which of the mesh's triangles these are, None: all."""
        points = to_world(self.mesh.positions, self.matrix)
        triangles, kept = front_facing(self.mesh.corner_vertex[self.mesh.triangles], self.matrix), None
        finite = np.isfinite(points).all(axis=1)
        if not finite.all():
            kept = finite[triangles].all(axis=1)
            triangles = triangles[kept]
            points[~finite] = 0.0
        return points, triangles, kept


@dataclass(frozen=True)
class Blocker:
    """One object or instance that blocks rays.

    evaluated  what has the mesh; good until the next one is asked for, as all of Blender's instances
    key        the same for instances of one mesh, which has the same materials
    placed     its mesh, which stays good
    """

    evaluated: bpy.types.Object
    key: tuple[int, int]
    placed: PlacedMesh


def blockers(
    depsgraph: bpy.types.Depsgraph,
    owners: Collection[bpy.types.Object],
    known: Mapping[bpy.types.Object, MeshTriangles] | None = None,
) -> Iterator[Blocker]:
    """The objects ``owners`` and the instances they make (collections, geometry nodes, particles), in the order that
    triangles of rays are numbered by. ``known`` are evaluated meshes that were read already, of objects themselves."""
    local: dict[tuple[int, int], MeshTriangles] = {}
    rendered: dict[tuple[bpy.types.Object, bpy.types.Object], bool] = {}
    for instance in depsgraph.object_instances:
        evaluated = instance.object
        original = evaluated.original
        owner = instance.parent.original if instance.is_instance else original
        if owner not in owners or evaluated.type not in SURFACE_TYPES:
            continue
        if not instance.show_self:
            continue
        if instance.is_instance:
            pair = (original, owner)
            if pair not in rendered:
                rendered[pair] = _instance_rendered(*pair)
            if not rendered[pair]:
                continue
        # Instances of one mesh are read once.
        key = (original.as_pointer(), evaluated.data.as_pointer() if evaluated.data else 0)
        if key not in local:
            read = None if instance.is_instance else (known or {}).get(original)
            local[key] = read or _read_local(evaluated)
        matrix = np.array(instance.matrix_world, np.float64)
        yield Blocker(evaluated, key, PlacedMesh(owner.name, local[key], matrix))


def read_occluders(
    depsgraph: bpy.types.Depsgraph, owners: Collection[bpy.types.Object]
) -> tuple[NDArray[np.float64], NDArray[np.int32], list[str]]:
    """The :func:`blockers`, :func:`together`."""
    return together([blocker.placed for blocker in blockers(depsgraph, owners)])


def together(placed: Sequence[PlacedMesh]) -> tuple[NDArray[np.float64], NDArray[np.int32], list[str]]:
    """Vertices (n, 3) in world space, triangles (m, 3), and warnings. Triangles with NaN or infinite coordinates are
    left out with a warning. Needs no Blender."""
    vertices, triangles, warnings, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [], 0
    for each in placed:
        points, of_points, kept = each.in_world()
        if kept is not None:
            warnings.append(f"'{each.name}' has vertices without finite coordinates: their faces block no light")
        vertices.append(points)
        triangles.append(of_points + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.int32), warnings


def _instance_rendered(source: bpy.types.Object, owner: bpy.types.Object) -> bool:
    """Whether renders show the instances of ``source`` that ``owner`` makes, and their shadows.

    An object that is disabled in renders is left out of collections and of instancing on vertices and faces. Geometry
    nodes that name the object itself show it all the same: so artists keep what they scatter.
    """
    if not source.visible_shadow:
        return False
    if not source.hide_render or owner.instance_type != "NONE":
        return not source.hide_render
    users = bpy.data.user_map(subset={source})[source]
    return any(user == owner or isinstance(user, bpy.types.GeometryNodeTree) for user in users)


def _read_local(evaluated: bpy.types.Object) -> MeshTriangles:
    with evaluated_mesh(evaluated) as mesh:
        if mesh is None:
            return MeshTriangles(np.empty((0, 3), np.float32), np.empty(0, np.int32), np.empty((0, 3), np.int32))
        return read_mesh_triangles(mesh)


def rendered_objects(view_layer: bpy.types.ViewLayer) -> set[bpy.types.Object]:
    """Objects that are visible in the viewport and enabled in renders, themselves and by a collection that holds
    them."""
    found: set[bpy.types.Object] = set()
    layers = [view_layer.layer_collection]
    while layers:
        layer = layers.pop()
        if layer.exclude or layer.collection.hide_render:
            continue
        layers.extend(layer.children)
        found.update(
            obj for obj in layer.collection.objects if not obj.hide_render and obj.visible_get(view_layer=view_layer)
        )
    return found
