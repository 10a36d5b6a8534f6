# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes that are baked: three that this file makes, and the OBJ files that BENCH_MESHES names ("a.obj b.obj")."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray


def empty_scene() -> None:
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def object_of(name: str, vertices: NDArray, quads: NDArray) -> bpy.types.Object:
    """A smooth mesh object of ``vertices`` (n, 3) and ``quads`` (m, 4), selected and active."""
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", np.ascontiguousarray(vertices, np.float32).ravel())
    mesh.loops.add(quads.size)
    mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(quads, np.int32).ravel())
    mesh.polygons.add(len(quads))
    mesh.polygons.foreach_set("loop_start", np.arange(0, quads.size, quads.shape[1], dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_smooth()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(obj)
    select(obj)
    return obj


def select(obj: bpy.types.Object) -> None:
    for other in bpy.context.view_layer.objects:
        other.select_set(other == obj)
    bpy.context.view_layer.objects.active = obj


def nudge(obj: bpy.types.Object) -> None:
    """Move one vertex by a hair, so that nothing kept of an earlier bake still holds."""
    obj.data.vertices[0].co.z += 1e-6 * max(obj.dimensions)
    obj.data.update()
    bpy.context.view_layer.update()


def suzanne(levels: int = 4) -> bpy.types.Object:
    """Blender's monkey under ``levels`` of subdivision: 126k vertices at 4."""
    empty_scene()
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.active_object
    obj.data.shade_smooth()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    obj.data = bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    obj.modifiers.clear()
    return obj


def coral(subdivisions: int = 7) -> bpy.types.Object:
    """An organic shape like a scanned one: limbs, a body, and folds all over. 82k even triangles at 7."""
    empty_scene()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions)
    obj = bpy.context.active_object
    obj.name = obj.data.name = "Coral"
    p = np.empty((len(obj.data.vertices), 3), np.float32)
    obj.data.vertices.foreach_get("co", p.ravel())
    p = p.astype(np.float64)
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    index = np.arange(9)
    z = 1.0 - (2.0 * index + 1.0) / len(index)
    azimuth = index * np.pi * (3.0 - 5.0**0.5)
    limbs = np.column_stack((np.sqrt(1.0 - z * z) * np.cos(azimuth), np.sqrt(1.0 - z * z) * np.sin(azimuth), z))
    radius = 1.0 + (1.3 * np.exp(14.0 * (p @ limbs.T - 1.0))).sum(axis=1)
    warped = 9.0 * p + 2.0 * np.sin(5.0 * p[:, (1, 2, 0)])
    folds = np.sin(warped).prod(axis=1)
    radius += 0.45 * folds + 0.03 * np.sin(3.0 * warped).sum(axis=1)
    obj.data.vertices.foreach_set("co", (p * radius[:, None]).astype(np.float32).ravel())
    obj.data.shade_smooth()
    obj.data.update()
    return obj


def torus(triangles: int) -> bpy.types.Object:
    """A wavy torus of about ``triangles``, the same shape whatever their number, whose UVs fill the square."""
    empty_scene()
    side = round((triangles / 2) ** 0.5)
    u, v = (2.0 * np.pi * each.ravel() / side for each in np.indices((side, side)))
    tube = 0.45 + 0.12 * np.sin(5.0 * u + 2.0 * v) * np.sin(4.0 * v - 3.0 * u)
    ring = 1.0 + tube * np.cos(v)
    i, j = (each.ravel() for each in np.indices((side, side)))
    near = np.stack((i, i + 1, i + 1, i), axis=1), np.stack((j, j, j + 1, j + 1), axis=1)
    quads = near[0] % side * side + near[1] % side
    obj = object_of("Torus", np.column_stack((ring * np.cos(u), ring * np.sin(u), tube * np.sin(v))), quads)
    uvs = np.stack(near, axis=-1) / side
    obj.data.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs.astype(np.float32).ravel())
    return obj


def load(path: str) -> bpy.types.Object:
    """The objects of an OBJ file joined into one and shaded smooth, so that it has a value a vertex."""
    empty_scene()
    bpy.ops.wm.obj_import(filepath=path)
    parts = [obj for obj in bpy.context.selected_objects if obj.type == "MESH"]
    select(parts[0])
    for part in parts:
        part.select_set(True)
    if len(parts) > 1:
        bpy.ops.object.join()
    obj = bpy.context.active_object
    obj.data.shade_smooth()
    return obj


def unwrap(obj: bpy.types.Object) -> None:
    """UVs by Smart UV Project, as an artist in a hurry makes them."""
    select(obj)
    while obj.data.uv_layers:
        obj.data.uv_layers.remove(obj.data.uv_layers[0])
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.002)
    bpy.ops.object.mode_set(mode="OBJECT")


def added() -> dict[str, Callable[[], bpy.types.Object]]:
    """The meshes that BENCH_MESHES names, by their file's stem."""
    return {Path(path).stem: partial(load, path) for path in os.environ.get("BENCH_MESHES", "").split()}
