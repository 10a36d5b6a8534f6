# SPDX-License-Identifier: GPL-3.0-or-later
"""The same bake by the extension and by Cycles, as operators, from the call to the stored attribute or image."""

from __future__ import annotations

import contextlib
import importlib
import io
from functools import partial
from types import ModuleType

import bpy
import numpy as np
from enable_extension import PACKAGE
from meshes import empty_scene, select, suzanne
from numpy.typing import NDArray
from timing import seconds

from demo.quiet import quiet

AO, CONE, CYCLES = "Multibounce AO", "Bent Cone", "Cycles"
MARGIN = 16


def by_the_extension(
    obj: bpy.types.Object,
    samples: int,
    *,
    target: str = "VERTEX",
    resolution: int = 1024,
    bounces: str = "FITTED",
    seed: int = 0,
    margin: int = MARGIN,
    threads: int | None = None,
) -> float:
    """Seconds of `bpy.ops.multibounce_ao.bake()`, or of the job it drives where ``threads`` are given."""
    scene = bpy.context.scene
    settings = scene.multibounce_ao
    settings.target, settings.samples, settings.resolution, settings.seed = target, samples, resolution, seed
    settings.bounces, settings.use_material_nodes, settings.margin = bounces, False, margin
    select(obj)
    call = bpy.ops.multibounce_ao.bake
    if threads is not None:
        job, progress = _operators("bake_job"), _operators("progress")
        chosen = _operators("settings").BakeSettings.of(scene)
        call = partial(progress.drive, job.bake(bpy.context, [obj], chosen, threads), lambda _: None)
    with quiet(), contextlib.redirect_stderr(io.StringIO()):
        return seconds(call)


def _operators(module: str) -> ModuleType:
    return importlib.import_module(f"{PACKAGE}.operators.{module}")


def by_cycles(
    obj: bpy.types.Object, samples: int, *, target: str = "VERTEX", domain: str = "", resolution: int = 1024
) -> float:
    """Seconds of Cycles' AO bake on ``obj``: to vertex colours, or to a float image.

    Vertex colours are those of ``domain``, by default of the extension's own. Cycles traces every face corner, also
    where they share a value, and takes their mean for a vertex: an artist waits for that.
    """
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.light_settings.distance = 1e5
    scene.render.bake.margin, scene.render.bake.margin_type = MARGIN, "ADJACENT_FACES"
    select(obj)
    bake = partial(_to_vertices, obj, domain or domain_of(obj))
    if target == "TEXTURE":
        bake = partial(_to_image, obj, resolution)
    with quiet():
        return seconds(bake)


def domain_of(obj: bpy.types.Object) -> str:
    """The domain of the extension's own attributes."""
    return "POINT" if obj.data.normals_domain == "POINT" else "CORNER"


def _to_vertices(obj: bpy.types.Object, domain: str) -> None:
    attributes = obj.data.color_attributes
    if CYCLES in attributes and attributes[CYCLES].domain != domain:
        attributes.remove(attributes[CYCLES])
    if CYCLES not in attributes:
        attributes.new(CYCLES, "FLOAT_COLOR", domain)
    attributes.active_color = attributes[CYCLES]
    bpy.ops.object.bake(type="AO", target="VERTEX_COLORS")


def _to_image(obj: bpy.types.Object, resolution: int) -> None:
    image = bpy.data.images.get(CYCLES)
    if image is None or image.size[0] != resolution:
        if image is not None:
            bpy.data.images.remove(image)
        image = bpy.data.images.new(CYCLES, resolution, resolution, float_buffer=True, is_data=True)
    if not obj.data.materials:
        obj.data.materials.append(bpy.data.materials.new("Bake"))
    for material in obj.data.materials:
        material.use_nodes = True
        nodes = material.node_tree.nodes
        node = nodes.get(CYCLES) or nodes.new("ShaderNodeTexImage")
        node.name, node.image = CYCLES, image
        nodes.active = node
    bpy.ops.object.bake(type="AO", target="IMAGE_TEXTURES")


def colours(obj: bpy.types.Object, name: str) -> NDArray[np.float64]:
    """An attribute's R and A, (n, 2)."""
    data = obj.data.attributes[name].data
    values = np.empty(4 * len(data), np.float32)
    data.foreach_get("color", values)
    return values.reshape(-1, 4)[:, (0, 3)].astype(np.float64)


def pixels(name: str) -> NDArray[np.float64]:
    """An image's red, (height, width), the lowest row first."""
    image = bpy.data.images[name]
    values = np.empty(4 * image.size[0] * image.size[1], np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)[:, :, 0].astype(np.float64)


def warm_up() -> None:
    """Small bakes that load what all later ones need."""
    empty_scene()
    obj = suzanne(0)
    for target in ("VERTEX", "TEXTURE"):
        by_the_extension(obj, 1, target=target, resolution=64)
        by_cycles(obj, 1, target=target, resolution=64)
