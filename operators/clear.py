# SPDX-License-Identifier: GPL-3.0-or-later
"""Take a bake back: attributes, images, AO fields and nodes."""

from __future__ import annotations

import bpy

from .field_receivers import RECEIVES, clear_fields
from .images import images_of_only
from .names import ALL_CHANNELS, PROPERTY
from .object_materials import mesh_is_baked, unplug_images, unplug_objects
from .poll import object_mode_with


def clear_bake(objects: list[bpy.types.Object]) -> None:
    """Remove what bakes left on ``objects``, their AO fields and those they receive, and put their materials back.
    Files on disk stay."""
    _clear_maps([obj for obj in objects if obj.type == "MESH"])
    clear_fields(objects)


def _clear_maps(objects: list[bpy.types.Object]) -> None:
    """On mesh objects: attributes or images, and their nodes."""
    cleared = set(objects)
    images = images_of_only(cleared)
    unplug_objects(objects)
    for obj in objects:
        if PROPERTY in obj and not mesh_is_baked(obj.data, cleared):
            _remove_attributes(obj.data)
    unplug_images(images)
    for image in images:
        bpy.data.images.remove(image)
    for obj in objects:
        obj.pop(PROPERTY, None)


def _remove_attributes(mesh: bpy.types.Mesh) -> None:
    for name in ALL_CHANNELS:
        attribute = mesh.attributes.get(name)
        if attribute is not None:
            mesh.attributes.remove(attribute)


class MULTIBOUNCE_AO_OT_clear(bpy.types.Operator):
    """Remove what bakes made on the selected objects: attributes, images, AO fields and nodes. Files on disk stay"""

    bl_idname = "multibounce_ao.clear"
    bl_label = "Clear Bake"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        nothing = "No mesh is selected that can be edited: select the objects to clear"
        return object_mode_with(cls, context, _clearable(context), nothing)

    def execute(self, context: bpy.types.Context) -> set[str]:
        objects = _clearable(context)
        clear_bake(objects)
        self.report({"INFO"}, f"Cleared the bake of {len(objects)} object{'s' if len(objects) > 1 else ''}")
        return {"FINISHED"}


def _clearable(context: bpy.types.Context) -> list[bpy.types.Object]:
    return [
        obj
        for obj in context.selected_objects
        if (obj.type == "MESH" or RECEIVES in obj) and not (obj.library or obj.data.library)
    ]
