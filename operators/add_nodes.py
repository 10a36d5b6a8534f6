# SPDX-License-Identifier: GPL-3.0-or-later
"""Plug a node group into one material by hand: that of the bake, or the curve of any AO map."""

from __future__ import annotations

import bpy

from ..shader_nodes.cone_light import STORED_WORLD
from .bake_record import baked_source, curve_group
from .material_nodes import BakedSource, add_world_light, groups_in
from .object_materials import plug_slot, users_of
from .openness import baked_openness


class MULTIBOUNCE_AO_OT_add_nodes(bpy.types.Operator):
    """Plug the multibounce node group into the active material, with the World's light if one is projected"""

    bl_idname = "multibounce_ao.add_nodes"
    bl_label = "Add Multibounce Nodes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _has_material(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, bounces = context.active_object, context.scene.multibounce_ao.bounces
        source = baked_source(obj, bounces)
        slot = _active_slot(obj)
        problem = plug_slot(slot, obj, bounces, source)
        if problem:
            self.report({"ERROR"}, problem)
            return {"CANCELLED"}
        if source is None:
            self.report(
                {"INFO"}, f"'{obj.name}' has no bake yet: bake it, or connect an AO map to the group's first input"
            )
        elif STORED_WORLD in context.scene:
            add_world_light(slot.material, source)
        return {"FINISHED"}


class MULTIBOUNCE_AO_OT_add_curve_nodes(bpy.types.Operator):
    """Plug a node group into the active material that finds the bounces from any AO map, baked here or elsewhere"""

    bl_idname = "multibounce_ao.add_curve_nodes"
    bl_label = "Add Curve Nodes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.mode != "OBJECT":  # the baked values of a mesh in Edit Mode are out of reach
            cls.poll_message_set("Switch to Object Mode first")
            return False
        return _has_material(cls, context)

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.active_object
        slot = _active_slot(obj)
        group, source = _curve_source(obj, slot.material)
        problem = plug_slot(slot, obj, group, source)
        if problem:
            self.report({"ERROR"}, problem)
            return {"CANCELLED"}
        if source is None:
            self.report({"INFO"}, f"'{obj.name}' has no bake yet: bake it, or connect an AO map to the group's AO")
            return {"FINISHED"}
        openness = baked_openness(users_of(slot.material))
        if openness is not None:
            for node in groups_in(slot.material):
                if "Openness" in node.inputs:
                    node.inputs["Openness"].default_value = openness
            self.report({"INFO"}, f"Openness of the surface: {openness:.3f}")
        return {"FINISHED"}


def _has_material(operator: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether there is an active material that nodes can be put into; tells why not."""
    obj = context.active_object
    if obj is None or obj.active_material is None:
        operator.poll_message_set("No active material: select an object and give it a material")
        return False
    if obj.active_material.library is not None:
        operator.poll_message_set(f"Material '{obj.active_material.name}' is linked: make it local first")
        return False
    return True


def _active_slot(obj: bpy.types.Object) -> bpy.types.MaterialSlot:
    return obj.material_slots[obj.active_material_index]


def _curve_source(obj: bpy.types.Object, material: bpy.types.Material) -> tuple[str, BakedSource | None]:
    """Which group shows baked AO, and from where: the bake of ``obj``, or attributes of another object that shows the
    ``material``."""
    for other in (obj, *users_of(material)):
        group = curve_group(other)
        source = baked_source(other, group)
        if source is not None and (other == obj or source.images is None):
            return group, source
    return "CURVE", None
