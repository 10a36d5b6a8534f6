# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the pictures of a bake that goes on (:mod:`.preview`) over its objects, in the viewports of all windows."""

from __future__ import annotations

import time
from collections.abc import Mapping

import bpy
import gpu
import numpy as np
from numpy.typing import NDArray

from .overlay_shader import overlay_shader, placed
from .preview import Picture, Preview, TexturePicture, VertexPicture
from .uv_layout import in_tile
from .viewports import redraw_viewports

# Seconds between drawings of what is new, and the part of the window's time that these may take.
REFRESH, SHARE = 0.4, 0.05

_VERTEX_LIGHT = "void main() { fragColor = vec4(light_at, 1.0); }"
_IMAGE_LIGHT = "void main() { fragColor = vec4(texture(image, uv_at).rgb, 1.0); }"


class PreviewOverlay:
    """What is drawn of a ``preview``, from now until :meth:`remove`. Objects whose mesh is changed meanwhile, that are
    in Edit Mode, or that viewports show as bounds or wires, are shown as they are."""

    def __init__(self, preview: Preview):
        self._preview = preview
        self._drawn: dict[Picture, _Vertices | _Texels] = {}
        self._shaders: dict[type, gpu.types.GPUShader] = {}
        self._changed: set[int] = set()
        self._shown = 0  # of the versions of all pictures
        self._taken = self._next = 0.0
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")
        bpy.app.handlers.depsgraph_update_post.append(self._forget_changed)

    def update(self, manager: bpy.types.WindowManager) -> None:
        """Have the viewports drawn where there is something new, but not too often."""
        version = sum(picture.version for picture in self._preview.pictures.values())
        if version != self._shown and time.perf_counter() > self._next:
            self._shown = version
            self._next = time.perf_counter() + max(REFRESH, self._taken / SHARE)
            redraw_viewports(manager)

    def remove(self, manager: bpy.types.WindowManager) -> None:
        """Draw no more; it may be called again."""
        if self._handle is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
            bpy.app.handlers.depsgraph_update_post.remove(self._forget_changed)
            self._handle = None
            self._drawn.clear()
            redraw_viewports(manager)

    def _forget_changed(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        self._changed |= {each.id.original.session_uid for each in depsgraph.updates if each.is_updated_geometry}

    def _draw(self) -> None:
        began, pictures = time.perf_counter(), self._preview.pictures
        self._drawn = {each: self._drawn.get(each) or _on_card(each) for each in pictures.values() if each.version}
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        for obj in bpy.context.visible_objects:
            drawn = self._drawn.get(pictures.get(obj.session_uid))
            if drawn is None or obj.session_uid in self._changed:
                continue
            if obj.mode != "EDIT" and obj.display_type not in ("BOUNDS", "WIRE"):
                shader = self._shader(type(drawn))
                shader.bind()
                with placed(shader, obj.matrix_world):
                    drawn.draw(shader)
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
        self._taken = time.perf_counter() - began

    def _shader(self, kind: type[_Vertices | _Texels]) -> gpu.types.GPUShader:
        if kind not in self._shaders:
            self._shaders[kind] = kind.shader()
        return self._shaders[kind]


class _Vertices:
    """A picture as the graphics card has it: triangles, made once, and their light, made again when there is more."""

    def __init__(self, picture: VertexPicture):
        self._picture = picture
        self._positions = _buffer({"position": picture.geometry.positions})
        self._elements = _elements(picture.geometry.triangles)
        self._batch, self._version = None, 0

    @staticmethod
    def shader() -> gpu.types.GPUShader:
        return overlay_shader("multibounce_ao_preview", {"light": "VEC3"}, _VERTEX_LIGHT)

    def draw(self, shader: gpu.types.GPUShader) -> None:
        """With that ``shader``, which is bound and :func:`.overlay_shader.placed`."""
        if self._version != self._picture.version:
            self._version = self._picture.version
            self._batch = gpu.types.GPUBatch(type="TRIS", buf=self._positions, elem=self._elements)
            self._batch.vertbuf_add(_buffer({"light": self._picture.colours()}))
        self._batch.draw(shader)


class _Texels:
    """The same of a picture with images: the triangles of each, and itself, made again when there is more."""

    def __init__(self, picture: TexturePicture):
        self._picture = picture
        geometry = picture.geometry
        self._batches = {}
        for number in picture.tiles:
            triangles = geometry.triangles[in_tile(geometry.uv[geometry.triangles], number)]
            uv = geometry.uv - np.float32(((number - 1001) % 10, (number - 1001) // 10))
            content = _buffer({"position": geometry.positions, "uv": uv})
            self._batches[number] = gpu.types.GPUBatch(type="TRIS", buf=content, elem=_elements(triangles))
        self._textures, self._version = {}, 0

    @staticmethod
    def shader() -> gpu.types.GPUShader:
        return overlay_shader("multibounce_ao_preview_images", {"uv": "VEC2"}, _IMAGE_LIGHT, samplers=("image",))

    def draw(self, shader: gpu.types.GPUShader) -> None:
        """With that ``shader``, which is bound and :func:`.overlay_shader.placed`."""
        if self._version != self._picture.version:
            self._version = self._picture.version
            self._textures = {number: _texture(image) for number, image in self._picture.tiles.items()}
        for number, batch in self._batches.items():
            shader.uniform_sampler("image", self._textures[number])
            batch.draw(shader)


def _on_card(picture: Picture) -> _Vertices | _Texels:
    return _Texels(picture) if isinstance(picture, TexturePicture) else _Vertices(picture)


def _buffer(content: Mapping[str, NDArray[np.float32]]) -> gpu.types.GPUVertBuf:
    """Attributes (n, k) by name, of n vertices."""
    layout = gpu.types.GPUVertFormat()
    for name, values in content.items():
        layout.attr_add(id=name, comp_type="F32", len=values.shape[1], fetch_mode="FLOAT")
    buffer = gpu.types.GPUVertBuf(layout, len(next(iter(content.values()))))
    for name, values in content.items():
        buffer.attr_fill(name, np.ascontiguousarray(values, np.float32))
    return buffer


def _elements(triangles: NDArray[np.int32]) -> gpu.types.GPUIndexBuf:
    return gpu.types.GPUIndexBuf(type="TRIS", seq=np.ascontiguousarray(triangles, np.uint32))


def _texture(image: NDArray[np.float32]) -> gpu.types.GPUTexture:
    """An ``image`` (h, w, 4), in half floats."""
    height, width, _ = image.shape
    pixels = gpu.types.Buffer("FLOAT", image.size, image.ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=pixels)
