# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles renders as linear arrays (height, width, 4), top row first, alpha premultiplied and 0 where the sky is."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import shading
from quiet import quiet

SIZE = (768, 512)
REFERENCE_BOUNCES = 12
AMBIENT_SAMPLES = 8
SUN_SAMPLES = 8
REFERENCE_SAMPLES = 24


def set_up() -> None:
    """Engine, size and an output that keeps all passes linear."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.film_transparent = True
    scene.render.use_persistent_data = True
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True


def light_world(radiance: float) -> None:
    background = next(n for n in bpy.context.scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    background.inputs["Strength"].default_value = radiance


def render(samples: int, bounces: int) -> dict[str, np.ndarray]:
    """Render, and return the passes by name."""
    scene = bpy.context.scene
    scene.cycles.samples = samples
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = bounces
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "render.exr")
        with quiet():
            bpy.ops.render.render(write_still=True)
        # Blender 5 writes a part a pass, older ones put them all into one.
        parts = OpenEXR.File(scene.render.filepath, separate_channels=True).parts
    passes: dict[str, dict[str, np.ndarray]] = {}
    for part in parts:
        for name, channel in part.channels.items():
            _, render_pass, component = name.split(".")
            passes.setdefault(render_pass, {})[component] = channel.pixels
    combined = passes["Combined"]
    return {
        name: np.stack([found.get(c, combined["A"]) for c in "RGBA"], axis=-1).astype(float)
        for name, found in passes.items()
        if "R" in found
    }


def ambient() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Flat ambient, grey AO, multibounce AO, all under a white World of radiance 1; out of one render."""
    shading.show_ambient()
    light_world(0)
    passes = render(AMBIENT_SAMPLES, bounces=0)
    return passes[shading.FLAT_AOV], passes[shading.GREY_AOV], passes["Combined"]


def field(prop: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Multibounce AO with the prop put down, without its field and with it; right after :func:`ambient`."""
    prop.hide_render = False
    passes = render(AMBIENT_SAMPLES, bounces=0)
    prop.hide_render = True
    return passes["Combined"], passes[shading.FIELD_AOV]


def sunlight(sun: bpy.types.Object) -> np.ndarray:
    """Direct light of the sun alone, with its shadows."""
    shading.show_principled()
    light_world(0)
    sun.hide_render = False
    return render(SUN_SAMPLES, bounces=0)["Combined"]


def path_traced(sun: bpy.types.Object) -> np.ndarray:
    """The reference: the white World itself, diffuse surfaces, many bounces; denoised where Cycles can."""
    shading.show_diffuse()
    light_world(1)
    sun.hide_render = True
    bpy.context.scene.cycles.use_denoising = True
    bpy.context.scene.cycles.denoising_prefilter = "FAST"
    return render(REFERENCE_SAMPLES, REFERENCE_BOUNCES)["Combined"]
