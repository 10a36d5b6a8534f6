# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate shader nodes on arrays: one quad, one pixel and one Cycles sample for each element of a grid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import bpy
import numpy as np

# Blender renders no picture that is smaller.
_SMALLEST = 4


def render_grid(
    values: Mapping[str, np.ndarray],
    connect: Callable[[bpy.types.ShaderNodeTree, dict[str, bpy.types.NodeSocket]], bpy.types.NodeSocket],
    folder: Path,
) -> np.ndarray:
    """What a shader makes of ``values``: (rows, columns) floats or (rows, columns, 3) colours, stored as float32.

    ``connect(tree, sockets)`` adds nodes to a material's tree and returns the output socket to look at; ``sockets``
    has an output socket of the same name for each of ``values``. Returns (rows, columns, 3) float32. Works in a scene
    of its own and takes it away again.
    """
    rows, columns = next(iter(values.values())).shape[:2]
    missing = [(0, max(0, _SMALLEST - rows)), (0, max(0, _SMALLEST - columns)), (0, 0)]
    values = {name: np.pad(array, missing[: array.ndim], mode="edge") for name, array in values.items()}
    height, width = next(iter(values.values())).shape[:2]

    scene = bpy.data.scenes.new("Grid")
    material = _material(values, connect)
    grid = _add(scene, _quads(values, height, width))
    grid.data.materials.append(material)
    camera = _add(scene, bpy.data.cameras.new("Grid"))
    camera.data.type = "ORTHO"
    camera.data.ortho_scale = max(width, height)
    camera.location = (width / 2, height / 2, 1)
    scene.camera = camera
    try:
        _render(scene, width, height, folder / "grid.exr")
        pixels = _read(folder / "grid.exr", width, height)
    finally:
        bpy.data.batch_remove([scene, grid, camera, grid.data, camera.data, material])
    return pixels[:rows, :columns]


def _add(scene: bpy.types.Scene, data: bpy.types.Mesh | bpy.types.Camera) -> bpy.types.Object:
    thing = bpy.data.objects.new("Grid", data)
    scene.collection.objects.link(thing)
    return thing


def _material(values, connect) -> bpy.types.Material:
    material = bpy.data.materials.new("Grid")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5.0
    tree = material.node_tree
    tree.nodes.clear()
    sockets = {}
    for name, array in values.items():
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        sockets[name] = node.outputs["Fac" if array.ndim == 2 else "Vector"]
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(connect(tree, sockets), emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    material.cycles.emission_sampling = "NONE"
    return material


def _quads(values, height: int, width: int) -> bpy.types.Mesh:
    row, column = (index.ravel() for index in np.mgrid[:height, :width])
    x = column[:, None] + (0, 1, 1, 0)
    y = row[:, None] + (0, 0, 1, 1)
    count = height * width
    mesh = bpy.data.meshes.new("Grid")
    mesh.vertices.add(4 * count)
    mesh.vertices.foreach_set("co", np.stack([x, y, np.zeros_like(x)], axis=-1).astype(np.float32).ravel())
    mesh.loops.add(4 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(4 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * count, 4, dtype=np.int32))
    for name, array in values.items():
        kind, key = ("FLOAT", "value") if array.ndim == 2 else ("FLOAT_VECTOR", "vector")
        data = mesh.attributes.new(name, kind, "FACE").data
        data.foreach_set(key, np.ascontiguousarray(array, np.float32).ravel())
    mesh.update()
    return mesh


def _render(scene: bpy.types.Scene, width: int, height: int, path: Path) -> None:
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = width, height, 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.samples = 1
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.max_bounces = 0
    # the one sample at the middle of its pixel: Cycles would scatter it over the neighbours
    cycles.pixel_filter_type = "BLACKMAN_HARRIS"
    cycles.filter_width = 0.01
    render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)


def _read(path: Path, width: int, height: int) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[..., :3]
