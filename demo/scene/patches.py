# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches of coloured surface as arrays, and the one way they become mesh objects."""

from dataclasses import dataclass

import bpy
import numpy as np

COLOUR_ATTRIBUTE = "Colour"


@dataclass
class Patch:
    """Vertices (n, 3) in metres, linear colours (n, 3), polygons as arrays (m, 3) or (m, 4), uvs (n, 2) or None."""

    vertices: np.ndarray
    colours: np.ndarray
    polygons: list[np.ndarray]
    uvs: np.ndarray | None = None


def grid_quads(rows: int, columns: int) -> np.ndarray:
    """Quads (m, 4) over vertices numbered row by row, counter-clockwise when columns go right and rows go up."""
    index = np.arange(rows * columns).reshape(rows, columns)
    return np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)


def closed_ring_quads(rows: int, columns: int) -> np.ndarray:
    """As `grid_quads`, with the last column joined to the first."""
    index = np.arange(rows * columns).reshape(rows, columns)
    right = np.roll(index, -1, axis=1)
    return np.stack([index[:-1], right[:-1], right[1:], index[1:]], axis=-1).reshape(-1, 4)


def merged(patches: list[Patch]) -> Patch:
    """One patch out of several; uvs only where all have them."""
    sizes = np.array([len(p.vertices) for p in patches])
    starts = np.cumsum(sizes) - sizes
    return Patch(
        np.concatenate([p.vertices for p in patches]),
        np.concatenate([p.colours for p in patches]),
        [polygons + start for p, start in zip(patches, starts, strict=True) for polygons in p.polygons],
        None if any(p.uvs is None for p in patches) else np.concatenate([p.uvs for p in patches]),
    )


def without_unused_vertices(patch: Patch) -> Patch:
    used = np.zeros(len(patch.vertices), bool)
    for polygons in patch.polygons:
        used[polygons] = True
    renumbered = np.cumsum(used) - 1
    return Patch(
        patch.vertices[used],
        patch.colours[used],
        [renumbered[polygons] for polygons in patch.polygons],
        None if patch.uvs is None else patch.uvs[used],
    )


def add_mesh(name: str, patch: Patch, smooth: bool = True) -> bpy.types.Mesh:
    """A mesh with a point colour attribute, and a UV map where the patch has uvs."""
    mesh = bpy.data.meshes.new(name)
    corners = np.concatenate([polygons.ravel() for polygons in patch.polygons]).astype(np.int32)
    sizes = np.concatenate([np.full(len(polygons), polygons.shape[1]) for polygons in patch.polygons])
    mesh.vertices.add(len(patch.vertices))
    mesh.vertices.foreach_set("co", patch.vertices.astype(np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", corners)
    mesh.polygons.add(len(sizes))
    mesh.polygons.foreach_set("loop_start", (np.cumsum(sizes) - sizes).astype(np.int32))
    mesh.update(calc_edges=True)
    if patch.uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.uv.foreach_set("vector", patch.uvs[corners].astype(np.float32).ravel())
    colours = np.ones((len(patch.vertices), 4), np.float32)
    colours[:, :3] = np.clip(patch.colours, 0.1, 0.85)
    attribute = mesh.attributes.new(COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    attribute.data.foreach_set("color", colours.ravel())
    if smooth:
        mesh.shade_smooth()
    else:
        mesh.shade_flat()
    return mesh


def add_object(name: str, patch: Patch, material: bpy.types.Material, smooth: bool = True) -> bpy.types.Object:
    """A mesh object of the patch, linked to the scene's collection."""
    scene_object = bpy.data.objects.new(name, add_mesh(name, patch, smooth))
    scene_object.data.materials.append(material)
    bpy.context.scene.collection.objects.link(scene_object)
    return scene_object
