# SPDX-License-Identifier: GPL-3.0-or-later
"""The button: let the selected objects receive the field of the active one."""

from __future__ import annotations

import bpy

from .field_receivers import apply_field
from .field_record import has_field
from .poll import object_mode_with


class MULTIBOUNCE_AO_OT_apply_field(bpy.types.Operator):
    """Make the selected objects receive the AO field of the active one, wherever it goes"""

    bl_idname = "multibounce_ao.apply_field"
    bl_label = "Apply AO Field"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not has_field(context.active_object):
            cls.poll_message_set("The active object has no AO field: bake one first")
            return False
        nothing = "Nothing else is selected: select what is to receive the field, then the object that has it"
        return object_mode_with(cls, context, receivers(context), nothing)

    def execute(self, context: bpy.types.Context) -> set[str]:
        occluder = context.active_object
        done, warnings = apply_field(occluder, receivers(context))
        if not done:
            self.report({"ERROR"}, "\n".join(warnings))
            return {"CANCELLED"}
        for warning in warnings:
            self.report({"WARNING"}, warning)
        names = f"'{done[0].name}' receives" if len(done) == 1 else f"{len(done)} objects receive"
        self.report({"INFO"}, f"{names} the AO field of '{occluder.name}'")
        return {"FINISHED"}


def receivers(context: bpy.types.Context) -> list[bpy.types.Object]:
    """What is selected besides the active object."""
    return [obj for obj in context.selected_objects if obj != context.active_object]
