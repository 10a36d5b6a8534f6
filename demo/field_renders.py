# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of the field demo: AO fields in EEVEE and Cycles, emitted as they are, and ray-traced AO in Cycles."""

import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy
import numpy as np
from captions import render_text
from pictures import save_picture
from quiet import quiet

SIZE = (480, 320)
FIELD_SAMPLES, RAY_SAMPLES = 6, 64
CAPTION_HEIGHT, GAP = 40, 6
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0, 0) else "BLENDER_EEVEE_NEXT"


# Blender aborts where there is no OpenGL, so another process tries.
_TRY_TO_DRAW = """
import bpy
bpy.ops.wm.read_homefile(use_factory_startup=True)
render = bpy.context.scene.render
render.engine, render.resolution_x, render.resolution_y = "BLENDER_WORKBENCH", 4, 4
bpy.ops.render.render()
"""


def has_opengl() -> bool:
    """Whether EEVEE can render on this machine."""
    return subprocess.run([sys.executable, "-c", _TRY_TO_DRAW], capture_output=True, check=False).returncode == 0


def set_up() -> None:
    """A white World, which only what is not emission sees."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.view_settings.view_transform = "Standard"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 0
    scene.eevee.taa_render_samples = FIELD_SAMPLES
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    background = next(n for n in scene.world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Color"].default_value = (1, 1, 1, 1)


def render_all(frames: Sequence[int], with_eevee: bool, say: Callable[[str], None]) -> dict[int, dict[str, np.ndarray]]:
    """Each of ``frames``, by what makes it: linear RGB (height, width, 3), top row first. One way of rendering after
    the other, since EEVEE translates materials anew when they are rewired."""
    scene = bpy.context.scene
    ways = [("No AO fields", "flat", "CYCLES", FIELD_SAMPLES)]
    if with_eevee:
        ways.append(("AO fields, EEVEE", "field", EEVEE, FIELD_SAMPLES))
    ways += [("AO fields, Cycles", "field", "CYCLES", FIELD_SAMPLES), ("Ray-traced", "rays", "CYCLES", RAY_SAMPLES)]
    pictures = {frame: {} for frame in frames}
    for name, what, engine, samples in ways:
        say(f"rendering: {name}")
        _show(what)
        scene.cycles.use_denoising = what == "rays"
        for frame in frames:
            scene.frame_set(frame)
            pictures[frame][name] = _render(engine, samples)
    return pictures


def difference(picture: np.ndarray, reference: np.ndarray) -> float:
    return float(np.sqrt(np.mean((picture - reference) ** 2)))


def _show(what: str) -> None:
    """Rewire every material: emit the colour with the fields in it, or before they were applied, or scatter light."""
    for material in bpy.data.materials:
        nodes, links = material.node_tree.nodes, material.node_tree.links
        by_type = {node.type: node for node in nodes}
        surface, shaded = by_type["OUTPUT_MATERIAL"].inputs["Surface"], by_type["BSDF_PRINCIPLED"].inputs["Base Color"]
        colour = shaded.links[0].from_socket
        if what == "flat":
            mix = colour.node
            colour = next(socket for socket in mix.inputs if socket.identifier == "A_Color").links[0].from_socket
        kind, name = ("ShaderNodeBsdfDiffuse", "BSDF") if what == "rays" else ("ShaderNodeEmission", "Emission")
        shader = next((node for node in nodes if node.bl_idname == kind), None) or nodes.new(kind)
        links.new(nodes["Plain Color"].outputs[0] if what == "rays" else colour, shader.inputs["Color"])
        links.new(shader.outputs[name], surface)


def _render(engine: str, samples: int) -> np.ndarray:
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = engine, samples
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        with quiet():
            bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(SIZE[0] * SIZE[1] * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels.reshape(SIZE[1], SIZE[0], 4)[::-1, :, :3].astype(float)


def save_sheet(rows: list[dict[str, np.ndarray]], differences: dict[int, dict[str, float]], path: Path) -> None:
    """All frames below each other, a column each way of rendering."""
    names = list(rows[0])
    width, height = SIZE
    sheet = np.full((CAPTION_HEIGHT + len(rows) * (height + GAP), len(names) * (width + GAP) - GAP, 3), 0.012)
    lines = []
    for column, name in enumerate(names):
        x = column * (width + GAP)
        found = [each[name] for each in differences.values() if name in each]
        note = f"   rms {np.sqrt(np.mean(np.square(found))):.3f}" if found else ""
        lines.append((name + note, x + 4, 27, 22))
        for row, pictures in enumerate(rows):
            y = CAPTION_HEIGHT + row * (height + GAP)
            sheet[y : y + height, x : x + width] = pictures[name]
    text = render_text(lines, sheet.shape[1], CAPTION_HEIGHT)[..., None]
    sheet[:CAPTION_HEIGHT] = sheet[:CAPTION_HEIGHT] * (1 - text) + 0.85 * text
    save_picture(sheet, path)
