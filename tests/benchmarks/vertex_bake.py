# SPDX-License-Identifier: GPL-3.0-or-later
"""A vertex bake of a Suzanne of 126k vertices at 64 samples, against Cycles' AO bake to vertex colours.

Both are timed as operators in one process, from the call to the stored attribute, after a small bake that loads what
they need. Cycles traces every face corner, so it does four times the work: that is what an artist would wait for.
"""

from __future__ import annotations

import time

import bpy
import numpy as np
from enable_extension import enable_extension

SAMPLES = 64


def suzanne(levels: int) -> bpy.types.Object:
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.active_object
    obj.data.shade_smooth()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
    obj.data = bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    obj.modifiers.clear()
    return obj


def by_the_extension(obj: bpy.types.Object) -> tuple[float, np.ndarray]:
    """Seconds, and F0 of each vertex."""
    settings = bpy.context.scene.multibounce_ao
    settings.samples, settings.use_material_nodes = SAMPLES, False
    started = time.perf_counter()
    bpy.ops.multibounce_ao.bake()
    return time.perf_counter() - started, colours(obj, "Multibounce AO")


def by_cycles(obj: bpy.types.Object) -> tuple[float, np.ndarray]:
    """Seconds, and F0 of each vertex."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = False
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.light_settings.distance = 1e5
    obj.data.color_attributes.active_color = obj.data.color_attributes.new("Cycles", "FLOAT_COLOR", "POINT")
    started = time.perf_counter()
    bpy.ops.object.bake(type="AO", target="VERTEX_COLORS")
    return time.perf_counter() - started, colours(obj, "Cycles")


def colours(obj: bpy.types.Object, name: str) -> np.ndarray:
    data = obj.data.attributes[name].data
    values = np.empty(4 * len(data), np.float32)
    data.foreach_get("color", values)
    return values[::4].astype(float)


def main() -> dict[str, float]:
    enable_extension()
    seconds, results = [], []
    for levels in (0, 4):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        obj = suzanne(levels)
        seconds, results = zip(*(bake(obj) for bake in (by_the_extension, by_cycles)), strict=True)
    vertices = len(obj.data.vertices)
    print(f"Suzanne of {vertices:,} vertices, {len(obj.data.loops):,} face corners, {SAMPLES} samples")
    for name, each in zip(("the extension", "Cycles"), seconds, strict=True):
        print(f"  {name:14} {each:8.2f} s  {vertices * SAMPLES / each / 1e6:8.2f} million vertex rays a second")
    print(f"  mean F0: {results[0].mean():.4f} and {results[1].mean():.4f}")
    return {f"vertex bake, {vertices // 1000}k vertices, against Cycles": seconds[1] / seconds[0]}
