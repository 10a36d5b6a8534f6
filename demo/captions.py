# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of text as coverage arrays, set in Blender's own font and rendered by Cycles."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
from quiet import quiet


def render_text(lines: list[tuple[str, float, float, float]], width: int, height: int) -> np.ndarray:
    """Coverage (height, width) in [0, 1], top row first.

    A line is (text, left, baseline from the top, size), in pixels.
    """
    scene = bpy.data.scenes.new("Captions")
    ink = bpy.data.materials.new("Ink")
    for body, left, baseline, size in lines:
        text = bpy.data.objects.new("Caption", bpy.data.curves.new("Caption", "FONT"))
        text.data.body, text.data.size = body, size
        text.data.materials.append(ink)
        text.location = (left - width / 2, height / 2 - baseline, 0)
        scene.collection.objects.link(text)
    camera = bpy.data.objects.new("Caption Camera", bpy.data.cameras.new("Caption Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", max(width, height)
    camera.location.z = 10
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.max_bounces = 16, 0
    scene.cycles.use_denoising = False
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.image_settings.file_format = "PNG"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "captions.png")
        with quiet():
            bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    bpy.data.scenes.remove(scene)
    return pixels.reshape(height, width, 4)[::-1, :, 3].astype(float)
