# SPDX-License-Identifier: GPL-3.0-or-later
"""Plug the node group into one material by hand."""

from __future__ import annotations

import bpy

from .bake_record import baked_source
from .object_materials import plug_slot


class MULTIBOUNCE_AO_OT_add_nodes(bpy.types.Operator):
    """Plug the multibounce node group into the active material, before the base colour of its Principled BSDF"""

    bl_idname = "multibounce_ao.add_nodes"
    bl_label = "Add Multibounce Nodes"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        if obj is None or obj.active_material is None:
            cls.poll_message_set("No active material: select an object and give it a material")
            return False
        if obj.active_material.library is not None:
            cls.poll_message_set(f"Material '{obj.active_material.name}' is linked: make it local first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = context.active_object
        source = baked_source(obj)
        slot = obj.material_slots[obj.active_material_index]
        problem = plug_slot(slot, obj, context.scene.multibounce_ao.bounces, source)
        if problem:
            self.report({"ERROR"}, problem)
            return {"CANCELLED"}
        if source is None:
            self.report(
                {"INFO"}, f"'{obj.name}' has no bake yet: bake it, or connect an AO map to the group's first input"
            )
        return {"FINISHED"}
