# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes whose occlusion is known, as objects of the scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np


def add(name: str, data: bpy.types.ID | None, location: Sequence[float] = (0, 0, 0)) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, data)
    obj.location = location
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj


def add_mesh(name: str, vertices, faces, smooth: bool = True, **where) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], [list(face) for face in faces])
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.update()
    return add(name, mesh, **where)


def plate(name: str = "Plate", half: float = 1.0, steps: int = 4, **where) -> bpy.types.Object:
    """A smooth square of 2 ``half`` at z = 0, facing up, of ``steps``^2 quads; its UV map fills the tile."""
    t = np.linspace(-half, half, steps + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(t, t))
    low = (np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)).ravel()
    obj = add_mesh(
        name,
        np.column_stack((x, y, np.zeros(len(x)))),
        np.column_stack((low, low + 1, low + steps + 2, low + steps + 1)),
        **where,
    )
    add_uv_map(obj.data, (positions(obj)[:, :2] / half + 1) / 2)
    return obj


def box(name: str = "Box", low=(-1, -1, -1), high=(1, 1, 1), inward: bool = False, smooth: bool = False, **where):
    """An axis-aligned box of six quads; flat, like Blender's cube."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face[::-1] for face in faces] if inward else faces
    return add_mesh(name, np.where(corners, high, low), faces, smooth, **where)


def suzanne(name: str = "Suzanne", levels: int = 0, **where) -> bpy.types.Object:
    """Smooth, with its own UV map. 507 vertices, 7,958 after 2 ``levels`` of subdivision, 126k after 4."""
    bpy.ops.mesh.primitive_monkey_add(**where)
    obj = bpy.context.active_object
    obj.name = obj.data.name = name
    obj.data.shade_smooth()
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        apply_modifiers(obj)
    return obj


def apply_modifiers(obj: bpy.types.Object) -> None:
    depsgraph = bpy.context.evaluated_depsgraph_get()
    original = obj.data
    obj.data = bpy.data.meshes.new_from_object(obj.evaluated_get(depsgraph))
    obj.modifiers.clear()
    bpy.data.meshes.remove(original)


def add_uv_map(mesh: bpy.types.Mesh, vertex_uv, name: str = "UVMap") -> bpy.types.MeshUVLoopLayer:
    """A UV map with the same coordinates (n, 2) at every corner of a vertex."""
    layer = mesh.uv_layers.new(name=name)
    layer.uv.foreach_set("vector", np.asarray(vertex_uv, np.float32)[corner_vertices(mesh)].ravel())
    return layer


def positions(obj: bpy.types.Object) -> np.ndarray:
    """(n, 3) float64, object space."""
    return read(obj.data.vertices, "co", 3)


def corner_vertices(mesh: bpy.types.Mesh) -> np.ndarray:
    return read(mesh.loops, "vertex_index", 1, np.int32)


def read(collection, attribute: str, width: int, dtype=np.float32) -> np.ndarray:
    values = np.empty(len(collection) * width, dtype)
    collection.foreach_get(attribute, values)
    values = values.astype(np.float64) if dtype == np.float32 else values
    return values if width == 1 else values.reshape(-1, width)


def smooth_by_angle(obj: bpy.types.Object) -> None:
    """What Object > Shade Auto Smooth does. The operator itself loads its asset in the background in some versions."""
    for library in Path(bpy.utils.system_resource("DATAFILES", path="assets")).rglob("*.blend"):
        with bpy.data.libraries.load(str(library), link=True) as (there, here):
            here.node_groups = [name for name in there.node_groups if name == "Smooth by Angle"]
        if here.node_groups:
            obj.modifiers.new("Smooth by Angle", "NODES").node_group = here.node_groups[0]
            return
    raise LookupError("this Blender has no Smooth by Angle asset")
