# SPDX-License-Identifier: GPL-3.0-or-later
"""Show what bakes left in the viewport: drawn over the meshes, so that nothing of the file changes for it."""

from __future__ import annotations

import bpy
import gpu
import numpy as np
from bpy.props import EnumProperty
from gpu_extras.batch import batch_for_shader

from .images import recorded_images
from .mesh_reader import evaluated_mesh, read, read_corner_vertices, read_positions, read_triangles
from .names import BENT_CONE, MULTIBOUNCE_AO, PROPERTY, RADIOSITY
from .overlay_shader import overlay_shader, placed
from .uv_layout import in_tile
from .viewports import redraw_viewports

VIEWS = (
    ("OFF", "Off", "Show the viewport as it is"),
    ("AO", "AO", "Show the ambient occlusion of all visible objects that are baked"),
    (
        "BOUNCES",
        "Bounces",
        "Show the light that later bounces add where the base color is 0.8, or the colors of a Radiosity bake",
    ),
    # The button is too narrow for "Bent Normal".
    ("BENT", "Normal", "Show the bent normal, the mean direction of the visible sky, as an object-space normal map"),
)
# Of white walls.
ALBEDO = 0.8

_FRAGMENT = """
// The viewport's buffer encodes what is written to it for the display.
vec3 decoded(vec3 colour)
{
  return mix(pow((colour + 0.055) / 1.055, vec3(2.4)), colour / 12.92, lessThan(colour, vec3(0.04045)));
}

void main()
{
  vec4 ao = AO, bent = BENT;
  if (view == 2) {
    fragColor = vec4(decoded(0.5 + 0.5 * bent.xyz / max(length(bent.xyz), 1e-6)), 1.0);
  }
  else if (radiosity) {
    fragColor = vec4(view == 0 ? ao.aaa : ao.rgb, 1.0);
  }
  else {
    float later = albedo * ao.g + albedo * albedo * ao.b / (1.0 - albedo * ao.a);
    fragColor = vec4(vec3(view == 0 ? ao.r : later), 1.0);
  }
}
"""


class _Overlay:
    """What is drawn while a view is on: a batch an object, made again when its mesh changes."""

    def __init__(self) -> None:
        self._batches: dict[int, tuple] = {}
        self._shaders: dict[bool, gpu.types.GPUShader] = {}
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), "WINDOW", "POST_VIEW")
        bpy.app.handlers.depsgraph_update_post.append(self._forget_changed)

    def remove(self) -> None:
        bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")
        bpy.app.handlers.depsgraph_update_post.remove(self._forget_changed)

    def _forget_changed(self, _scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        for update in depsgraph.updates:
            if update.is_updated_geometry:
                self._batches.pop(update.id.original.session_uid, None)

    def _draw(self) -> None:
        context = bpy.context
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(True)
        for obj in context.visible_objects:
            if obj.type == "MESH" and "f0" in obj.get(PROPERTY, ()) and obj.mode != "EDIT":
                if obj.session_uid not in self._batches:
                    self._batches[obj.session_uid] = self._batch(context, obj)
                self._draw_object(context, obj, *self._batches[obj.session_uid])
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")

    def _draw_object(self, context: bpy.types.Context, obj: bpy.types.Object, batch, textures) -> None:
        if batch is None:
            return
        shader = self._shader(textures is not None)
        shader.bind()
        for name, texture in (textures or {}).items():
            shader.uniform_sampler(name, texture)
        shader.uniform_int("view", [view[0] for view in VIEWS].index(context.window_manager.multibounce_ao_view) - 1)
        shader.uniform_bool("radiosity", [obj[PROPERTY]["bounces"] == "RADIOSITY"])
        shader.uniform_float("albedo", ALBEDO)
        with placed(shader, obj.matrix_world):
            batch.draw(shader)

    def _batch(self, context: bpy.types.Context, obj: bpy.types.Object):
        """The triangles of ``obj`` with its channels, and their textures if these are images; None, None where the
        result is gone."""
        record = obj[PROPERTY]
        first = RADIOSITY if record["bounces"] == "RADIOSITY" else MULTIBOUNCE_AO
        with evaluated_mesh(obj.evaluated_get(context.evaluated_depsgraph_get())) as mesh:
            if mesh is None or not mesh.polygons:
                return None, None
            corners, vertex = read_triangles(mesh).ravel(), read_corner_vertices(mesh)
            content = {}
            if record["target"] == "TEXTURE":
                images = recorded_images(obj)
                if not {first, BENT_CONE} <= images.keys() or record["uv_map"] not in mesh.uv_layers:
                    return None, None
                uv = read(mesh.uv_layers[record["uv_map"]].uv, "vector", 2, np.float32)
                if images[first].source == "TILED":
                    # Blender gives the first tile alone to be drawn with: what lies in the others stays as it is.
                    corners = corners.reshape(-1, 3)
                    corners = corners[in_tile(uv[corners], images[first].tiles[0].number)].ravel()
                content["uv"] = uv[corners]
                textures = {
                    "ao_image": gpu.texture.from_image(images[first]),
                    "bent_image": gpu.texture.from_image(images[BENT_CONE]),
                }
            else:
                textures = None
                for name, channel in (("ao", first), ("bent", BENT_CONE)):
                    attribute = mesh.attributes.get(channel)
                    if attribute is None:
                        return None, None
                    values = read(attribute.data, "color", 4, np.float32)
                    content[name] = values[vertex[corners] if attribute.domain == "POINT" else corners]
            content["position"] = read_positions(mesh)[vertex[corners]]
        return batch_for_shader(self._shader(textures is not None), "TRIS", content), textures

    def _shader(self, images: bool) -> gpu.types.GPUShader:
        """Of the channels in attributes, or in ``images``."""
        if images not in self._shaders:
            self._shaders[images] = _shader(images)
        return self._shaders[images]


def _shader(images: bool) -> gpu.types.GPUShader:
    constants = {"view": "INT", "radiosity": "BOOL", "albedo": "FLOAT"}
    if images:
        fragment = _fragment("texture(ao_image, uv_at)", "texture(bent_image, uv_at)")
        samplers = "ao_image", "bent_image"
        return overlay_shader("multibounce_ao_view_images", {"uv": "VEC2"}, fragment, constants, samplers)
    inputs = {"ao": "VEC4", "bent": "VEC4"}
    return overlay_shader("multibounce_ao_view", inputs, _fragment("ao_at", "bent_at"), constants)


def _fragment(ao: str, bent: str) -> str:
    return _FRAGMENT.replace("AO,", f"{ao},").replace("BENT;", f"{bent};")


_overlay: _Overlay | None = None


def _changed(manager: bpy.types.WindowManager, context: bpy.types.Context) -> None:
    global _overlay
    wanted = manager.multibounce_ao_view != "OFF" and not bpy.app.background
    if wanted and _overlay is None:
        _overlay = _Overlay()
    elif not wanted and _overlay is not None:
        _overlay.remove()
        _overlay = None
    redraw_viewports(manager)


@bpy.app.handlers.persistent
def _turn_off(*_: object) -> None:
    # Where a file is opened without its windows, the window manager and this choice stay.
    for manager in bpy.data.window_managers:
        manager.multibounce_ao_view = "OFF"


def register() -> None:
    bpy.types.WindowManager.multibounce_ao_view = EnumProperty(
        name="View",
        description="What the viewport shows of the bakes. It changes nothing in the file",
        items=VIEWS,
        options={"SKIP_SAVE"},
        update=_changed,
    )
    bpy.app.handlers.load_pre.append(_turn_off)


def unregister() -> None:
    _turn_off()
    bpy.app.handlers.load_pre.remove(_turn_off)
    del bpy.types.WindowManager.multibounce_ao_view
