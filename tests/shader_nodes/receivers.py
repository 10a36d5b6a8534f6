# SPDX-License-Identifier: GPL-3.0-or-later
"""Shaders looked at anywhere in space: one small plate a pixel, at any height and tilt, seen from straight above."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np


@dataclass(frozen=True)
class Plates:
    """Plates of a square grid about the origin.

    heights  (rows, columns)
    slopes   (rows, columns, 2), of the height along x and y
    spacing  of the grid
    """

    heights: np.ndarray
    slopes: np.ndarray
    spacing: float

    @classmethod
    def random(cls, rng: np.random.Generator, size: int, extent: float) -> Plates:
        """Anywhere in a cube of ``extent`` about the origin, at any tilt up to nearly upright."""
        tilt, turn = np.tan(rng.uniform(0, 1.5, (size, size))), rng.uniform(0, 2 * np.pi, (size, size))
        slopes = np.stack((tilt * np.cos(turn), tilt * np.sin(turn)), axis=-1)
        return cls(rng.uniform(-extent / 2, extent / 2, (size, size)), slopes, extent / size)

    @classmethod
    def flat(cls, size: int, extent: float, height: float) -> Plates:
        return cls(np.full((size, size), height), np.zeros((size, size, 2)), extent / size)

    def positions(self) -> np.ndarray:
        """World places (k, 3) of the middles, row after row from below."""
        x, y = self._middles()
        return np.stack((x, y, np.float32(self.heights)), axis=-1).reshape(-1, 3)

    def normals(self) -> np.ndarray:
        """Unit world normals (k, 3)."""
        normal = np.concatenate((-self.slopes, np.ones((*self.heights.shape, 1))), axis=-1)
        return (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).reshape(-1, 3)

    def mesh(self) -> bpy.types.Mesh:
        x, y = self._middles()
        side = 0.5 * self.spacing * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        z = self.heights[..., None] + self.slopes @ side.T
        corners = np.stack((x[..., None] + side[:, 0], y[..., None] + side[:, 1], z), axis=-1)
        count = self.heights.size
        mesh = bpy.data.meshes.new("Plates")
        mesh.vertices.add(4 * count)
        mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
        mesh.loops.add(4 * count)
        mesh.loops.foreach_set("vertex_index", np.arange(4 * count, dtype=np.int32))
        mesh.polygons.add(count)
        mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * count, 4, dtype=np.int32))
        mesh.update()
        return mesh

    def _middles(self) -> tuple[np.ndarray, np.ndarray]:
        rows, columns = self.heights.shape
        y, x = np.meshgrid(*(self.spacing * (np.arange(n) - (n - 1) / 2) for n in (rows, columns)), indexing="ij")
        return x, y


Connect = Callable[[bpy.types.ShaderNodeTree], bpy.types.NodeSocket]


def render_plates(plates: Plates, connect: Connect, folder: Path, engine: str = "CYCLES", frame: int = 1) -> np.ndarray:
    """What the output socket that ``connect(tree)`` returns gives at the middle of each plate, (k,) float32."""
    with _stage(plates, connect, engine) as scene:
        scene.frame_set(frame)
        scene.render.filepath = str(folder / "plates.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
    image = bpy.data.images.load(str(folder / "plates.exr"))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(plates.heights.size * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(-1, 4)[:, 0]


@contextmanager
def _stage(plates: Plates, connect: Connect, engine: str):
    scene = bpy.data.scenes.new("Plates")
    material = bpy.data.materials.new("Plates")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5.0
    tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(connect(tree), emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    mesh = plates.mesh()
    mesh.materials.append(material)
    rows, columns = plates.heights.shape
    camera = bpy.data.cameras.new("Plates")
    camera.type = "ORTHO"
    camera.ortho_scale = plates.spacing * max(rows, columns)
    above = 2 * np.abs(plates.heights).max() + camera.ortho_scale * (1 + np.abs(plates.slopes).max())
    camera.clip_start, camera.clip_end = 0.1, 2 * above
    objects = [bpy.data.objects.new("Plates", data) for data in (mesh, camera)]
    objects[1].location.z = above
    for thing in objects:
        scene.collection.objects.link(thing)
    scene.camera = objects[1]
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = columns, rows, 100
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    if engine == "CYCLES":
        _cycles(scene)
        material.cycles.emission_sampling = "NONE"
    else:
        _eevee(scene)
    try:
        yield scene
    finally:
        bpy.data.batch_remove([scene, *objects, mesh, camera, material])


def _cycles(scene: bpy.types.Scene) -> None:
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.max_bounces = "CPU", 1, 0
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # the one sample at the middle of its pixel: Cycles would scatter it over the neighbours
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01


def _eevee(scene: bpy.types.Scene) -> None:
    scene.render.engine = "BLENDER_EEVEE" if bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"
    scene.eevee.taa_render_samples = 1
    scene.render.filter_size = 0.0
