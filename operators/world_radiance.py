# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a World, all around, as spherical harmonics: of a plain colour or a picture at once, of anything else by
a panorama.

The panorama is rendered by Cycles in a scene of its own, from a copy of the World, and all of it is taken away again.
"""

from __future__ import annotations

import tempfile
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from math import pi, radians
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.spherical_harmonics import COUNT, Y0, project_panorama
from ..core.workers import calling, in_thread
from ..shader_nodes.cone_light import LARGEST
from .report import BakeError
from .world_picture import PictureLight, read_picture

# Pixels of the panorama, and rays through each: few where they agree, more where they do not. Cycles measures NOISE
# against the root of a pixel's brightness, so that what is bright is refined most.
HEIGHT, WIDTH = 256, 512
LEAST_SAMPLES, MOST_SAMPLES = 8, 1024
NOISE = 0.02
# How wide the sun of a sky is made, so that no panorama misses it: degrees, and a share of its height, since near the
# horizon its colour changes with that. It sheds the same light, and nine coefficients cannot tell the two apart.
SUN, SUN_OF_HEIGHT = 6.0, 0.25

# What light that falls on a surface is for the Light Path nodes of a World. Outputs that are not named here give 0.
_LIGHT_PATH = {"Is Diffuse Ray": 1.0, "Diffuse Depth": 1.0, "Ray Depth": 1.0}


def world_coefficients(scene: bpy.types.Scene, strips: int = 1) -> Generator[float, None, NDArray[np.float64]]:
    """Coefficients (9, 3), see :mod:`core.spherical_harmonics`, of the radiance of the World of ``scene``, in its
    present frame, in world axes and Rec. 709; yields the fraction done. A panorama is rendered in so many ``strips``,
    with a yield between: they change nothing of it. Raises BakeError."""
    world = scene.world
    if world is None:
        raise BakeError(
            f"Scene '{scene.name}' has no World: add one in the World properties, with a color, a sky or an image"
        )
    name, coefficients = world.name, _simple_light(world)
    if isinstance(coefficients, PictureLight):
        coefficients = yield from in_thread(calling(coefficients.coefficients))
    elif coefficients is None:
        coefficients = project_panorama((yield from render_panorama(scene, strips)))
    if not (np.abs(coefficients) <= LARGEST).all():
        raise BakeError(f"World '{name}' is infinitely bright somewhere: look for what its nodes divide by 0")
    return coefficients


def _simple_light(world: bpy.types.World) -> NDArray[np.float64] | PictureLight | None:
    """Coefficients (9, 3) of a World of one colour, or the one picture that it is; None where its nodes say more."""
    tree = world.node_tree
    if tree is None or not (bpy.app.version >= (5, 0, 0) or world.use_nodes):
        return _of_colour(world.color)
    output = tree.get_output_node("CYCLES")
    links = output.inputs["Surface"].links if output is not None else ()
    if not links:
        return _of_colour((0.0, 0.0, 0.0))
    background = links[0].from_node
    if background.bl_idname != "ShaderNodeBackground" or background.mute or links[0].is_muted:
        return None
    colour, strength = background.inputs["Color"], background.inputs["Strength"]
    if strength.is_linked:
        return None
    if colour.is_linked:
        return read_picture(colour, strength.default_value)
    return strength.default_value * _of_colour(colour.default_value)


def _of_colour(colour: Sequence[float]) -> NDArray[np.float64]:
    coefficients = np.zeros((COUNT, 3))
    coefficients[0] = np.array(colour[:3]) / Y0
    return coefficients


def render_panorama(scene: bpy.types.Scene, strips: int) -> Generator[float, None, NDArray[np.float64]]:
    """Radiance (HEIGHT, WIDTH, 3) of the World of ``scene``, as :func:`core.spherical_harmonics.equirectangular` has
    it: what falls on surfaces, not what the camera sees where the World tells the two apart. Between ``strips``, each a
    rendering of its own, nothing is left in the file; yields the fraction done."""
    world, time = scene.world, (scene.frame_current, scene.frame_subframe)
    parts = []
    for strip in range(strips):
        yield strip / strips
        parts.append(_render_strip(world, time, strip / strips, (strip + 1) / strips))
    return np.concatenate(parts).astype(np.float64)


def _render_strip(world: bpy.types.World, time: tuple[int, float], low: float, high: float) -> NDArray[np.float32]:
    """Radiance (h, WIDTH, 3) of ``world`` at that ``time``, frame and subframe, from ``low`` to ``high``, parts of the
    height."""
    if bpy.app.is_job_running("RENDER"):
        raise BakeError("A render is running, and the World is rendered, too: wait for it, or cancel it")
    with _panorama_scene(world, time) as panorama, tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.exr"
        render = panorama.render
        render.filepath = str(path)
        render.use_border = render.use_crop_to_border = True
        render.border_min_y, render.border_max_y = low, high
        bpy.ops.render.render(write_still=True, scene=panorama.name)
        image = bpy.data.images.load(str(path))
        try:
            image.colorspace_settings.name = "Non-Color"
            pixels = np.empty((image.size[1], WIDTH, 4), np.float32)
            image.pixels.foreach_get(pixels.reshape(-1))
        finally:
            bpy.data.images.remove(image)
    return pixels[..., :3]


@contextmanager
def _panorama_scene(world: bpy.types.World, time: tuple[int, float]) -> Iterator[bpy.types.Scene]:
    """A scene with nothing but the ``world`` at that ``time`` and a camera that looks all around, +x in the middle."""
    there = {block for blocks in _made() for block in blocks}
    try:
        panorama = bpy.data.scenes.new("World")
        panorama.frame_set(time[0], subframe=time[1])
        panorama.world = _for_surfaces(world)
        data = bpy.data.cameras.new("World")
        data.type = "PANO"
        settings = data if hasattr(data, "panorama_type") else data.cycles  # Cycles' own before Blender 5.0
        settings.panorama_type = "EQUIRECTANGULAR"
        camera = bpy.data.objects.new("World", data)
        camera.rotation_euler = (pi / 2, 0.0, -pi / 2)
        panorama.collection.objects.link(camera)
        panorama.camera = camera
        _set_up(panorama)
        yield panorama
    finally:
        bpy.data.batch_remove([block for blocks in _made() for block in blocks if block not in there])


def _made() -> tuple:
    """All that may be more after a panorama; "Render Result" is an image."""
    data = bpy.data
    return data.scenes, data.objects, data.cameras, data.worlds, data.node_groups, data.images


def _set_up(scene: bpy.types.Scene) -> None:
    render, cycles, image = scene.render, scene.cycles, scene.render.image_settings
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = WIDTH, HEIGHT, 100
    render.use_compositing = render.use_sequencer = False
    if bpy.app.version >= (5, 0, 0):
        image.media_type = "IMAGE"
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGBA", "32"
    cycles.device = "CPU"
    cycles.samples = MOST_SAMPLES
    cycles.use_adaptive_sampling, cycles.use_denoising = True, False
    cycles.adaptive_min_samples, cycles.adaptive_threshold = LEAST_SAMPLES, NOISE
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = 0.0


def _for_surfaces(world: bpy.types.World) -> bpy.types.World:
    """A copy of ``world`` that shows the camera what it sheds on surfaces, without a volume."""
    copy = world.copy()
    copy.cycles_visibility.camera = True
    copy.cycles.sampling_method = "NONE"  # no map of where it is bright: no surface is there to need one
    _prepare(copy.node_tree)
    for node in copy.node_tree.nodes:
        if node.bl_idname == "ShaderNodeOutputWorld":
            for link in list(node.inputs["Volume"].links):
                copy.node_tree.links.remove(link)
    return copy


def _prepare(tree: bpy.types.NodeTree) -> None:
    """Put numbers for a ray from a surface in the place of Light Path nodes, and make suns larger; also in groups,
    which are copied."""
    for node in list(tree.nodes):
        if node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
            node.node_tree = node.node_tree.copy()
            _prepare(node.node_tree)
        elif node.bl_idname == "ShaderNodeTexSky":
            node.sun_size = max(node.sun_size, min(radians(SUN), SUN_OF_HEIGHT * node.sun_elevation))
        elif node.bl_idname == "ShaderNodeLightPath":
            for output in node.outputs:
                targets = [link.to_socket for link in output.links]
                if targets:
                    value = tree.nodes.new("ShaderNodeValue")
                    value.outputs[0].default_value = _LIGHT_PATH.get(output.name, 0.0)
                    for target in targets:
                        tree.links.new(value.outputs[0], target)
