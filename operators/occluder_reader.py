# SPDX-License-Identifier: GPL-3.0-or-later
"""What blocks rays: the evaluated scene with its modifiers and instances, as one set of triangles."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from .mesh_reader import evaluated_mesh, front_facing, read_corner_vertices, read_positions, read_triangles, to_world

# Objects that evaluate to faces.
SURFACE_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


@dataclass(frozen=True)
class Blocker:
    """One object or instance that blocks rays.

    owner      original object that it belongs to
    evaluated  what has the mesh; good until the next one is asked for, as all of Blender's instances
    key        the same for instances of one mesh, which has the same materials
    matrix     (4, 4) float64, to the world
    points     (n, 3) float64, vertices in world space; zero where they are not finite
    triangles  (m, 3) int32, counter-clockwise seen from the front; none with coordinates that are not finite
    kept       which of the mesh's triangles these are, bool; None: all
    """

    owner: bpy.types.Object
    evaluated: bpy.types.Object
    key: tuple[int, int]
    matrix: NDArray[np.float64]
    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    kept: NDArray[np.bool_] | None


def blockers(depsgraph: bpy.types.Depsgraph, owners: Collection[bpy.types.Object]) -> Iterator[Blocker]:
    """The objects ``owners`` and the instances they make (collections, geometry nodes, particles), in the order that
    triangles of rays are numbered by."""
    local: dict[tuple[int, int], tuple[NDArray, NDArray]] = {}
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
            local[key] = _read_local(evaluated)
        positions, triangles = local[key]
        matrix = np.array(instance.matrix_world, np.float64)
        points = to_world(positions, matrix)
        triangles, kept = front_facing(triangles, matrix), None
        finite = np.isfinite(points).all(axis=1)
        if not finite.all():
            kept = finite[triangles].all(axis=1)
            triangles = triangles[kept]
            points[~finite] = 0.0
        yield Blocker(owner, evaluated, key, matrix, points, triangles, kept)


def read_occluders(
    depsgraph: bpy.types.Depsgraph, owners: Collection[bpy.types.Object]
) -> tuple[NDArray[np.float64], NDArray[np.int32], list[str]]:
    """Triangles of the :func:`blockers`.

    Returns vertices (n, 3) in world space, triangles (m, 3), and warnings. Triangles with NaN or infinite coordinates
    are left out with a warning.
    """
    vertices, triangles, warnings, count = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [], 0
    for blocker in blockers(depsgraph, owners):
        if blocker.kept is not None:
            name = blocker.owner.name
            warnings.append(f"'{name}' has vertices without finite coordinates: their faces block no light")
        vertices.append(blocker.points)
        triangles.append(blocker.triangles + count)
        count += len(blocker.points)
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


def _read_local(evaluated: bpy.types.Object) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    with evaluated_mesh(evaluated) as mesh:
        if mesh is None:
            return np.empty((0, 3), np.float32), np.empty((0, 3), np.int32)
        return read_positions(mesh), read_corner_vertices(mesh)[read_triangles(mesh)]


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
