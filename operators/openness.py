# SPDX-License-Identifier: GPL-3.0-or-later
"""How open the surfaces are that block light, from the baked F0: what ``Multibounce AO Curve`` asks of an artist.

Areas are those of the mesh that was baked, without its modifiers, in world space.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.multibounce import surface_openness
from ..core.sample_points import spread
from .images import recorded_images
from .mesh_reader import read, read_corner_vertices, read_positions, read_triangles, to_world
from .names import MULTIBOUNCE_AO, PROPERTY, RADIOSITY

# Places on a mesh at which its image is read.
PLACES = 2**16

# k_A of points, and the area that each stands for; both (n,).
Weighted = tuple[NDArray[np.float64], NDArray[np.float64]]


def baked_openness(objects: Iterable[bpy.types.Object]) -> float | None:
    """:func:`core.multibounce.surface_openness` of all ``objects`` together; None where none has a bake to read."""
    found = [each for each in map(_baked, objects) if each is not None and each[1].sum() > 0.0]
    if not found:
        return None
    return surface_openness(*(np.concatenate(each) for each in zip(*found, strict=True)))


def f0_of(values: NDArray, record) -> NDArray:
    """F0 of what a bake with this ``record`` left, (..., 4)."""
    return values[..., 3 if record["bounces"] == "RADIOSITY" else 0]


def _baked(obj: bpy.types.Object) -> Weighted | None:
    record = obj.get(PROPERTY)
    if obj.type != "MESH" or record is None or "target" not in record:
        return None
    mesh, matrix = obj.data, np.array(obj.matrix_world, np.float64)
    mesh.calc_loop_triangles()
    triangles, corner_vertex = read_triangles(mesh), read_corner_vertices(mesh)
    a, b, c = np.moveaxis(to_world(read_positions(mesh), matrix)[corner_vertex[triangles]], 1, 0)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    channel = RADIOSITY if record["bounces"] == "RADIOSITY" else MULTIBOUNCE_AO
    if record["target"] == "VERTEX":
        return _of_attribute(mesh, mesh.attributes.get(channel), record, triangles, corner_vertex, areas)
    return _of_image(mesh, recorded_images(obj).get(channel), record, triangles, areas)


def _of_attribute(
    mesh: bpy.types.Mesh,
    attribute: bpy.types.Attribute | None,
    record,
    triangles: NDArray[np.int32],
    corner_vertex: NDArray[np.int32],
    areas: NDArray[np.float64],
) -> Weighted | None:
    """Each corner stands for a third of its triangles, each vertex for its corners."""
    if attribute is None or attribute.data_type != "FLOAT_COLOR" or attribute.domain not in {"POINT", "CORNER"}:
        return None
    k_a = f0_of(read(attribute.data, "color", 4, np.float32), record)
    area = np.bincount(triangles.ravel(), np.repeat(areas / 3.0, 3), minlength=len(corner_vertex))
    if attribute.domain == "POINT":
        area = np.bincount(corner_vertex, area, minlength=len(mesh.vertices))
    return k_a.astype(np.float64), area


def _of_image(
    mesh: bpy.types.Mesh,
    image: bpy.types.Image | None,
    record,
    triangles: NDArray[np.int32],
    areas: NDArray[np.float64],
) -> Weighted | None:
    """The texels under places spread evenly over the mesh: what no face covers has no say."""
    layer = mesh.uv_layers.get(record["uv_map"])
    if image is None or layer is None or not (image.size[0] * image.size[1] and image.channels == 4 and areas.sum()):
        return None
    triangle, v, w = spread(areas, PLACES)
    a, b, c = np.moveaxis(read(layer.uv, "vector", 2, np.float32)[triangles[triangle]].astype(np.float64), 1, 0)
    uv = np.nan_to_num(a + v[:, None] * (b - a) + w[:, None] * (c - a))
    width, height = image.size
    column, row = (np.clip(each * size, 0, size - 1).astype(int) for each, size in zip(uv.T, image.size, strict=True))
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    k_a = f0_of(pixels.reshape(height, width, 4)[row, column], record)
    return k_a.astype(np.float64), np.full(PLACES, areas.sum() / PLACES)
