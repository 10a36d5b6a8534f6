# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel of AO fields: the two buttons, in order of use, and the field of the active object."""

from __future__ import annotations

import bpy

from ..operators.field_record import FIELD, has_changed, has_field, is_uneven
from ..operators.report import count_text
from .sidebar import SidebarPanel


class MULTIBOUNCE_AO_PT_field(SidebarPanel, bpy.types.Panel):
    bl_label = "AO Field"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, obj = self.layout, context.active_object
        column = self._column(layout)
        for name in ("field_resolution", "use_field_volume"):
            column.prop(context.scene.multibounce_ao, name)
        if obj is not None and obj.type == "MESH" and not has_field(obj) and is_uneven(obj):
            self._wrapped(context, "Scaled unevenly: apply the scale first, for a field that any even scale keeps")
        layout.operator("multibounce_ao.bake_field", icon="SPHERE")
        layout.operator("multibounce_ao.apply_field", icon="MOD_SHRINKWRAP")
        if has_field(obj):
            record = obj[FIELD]
            self._table(
                layout,
                (
                    ("Field of", obj.name),
                    ("Resolution", f"{record['resolution']} x {record['resolution']}"),
                    ("Rays", count_text(record["rays"])),
                    ("Time", f"{record['seconds']:.2f} s"),
                ),
            )
            if has_changed(obj):
                layout.label(text="Scaled unevenly since: bake again", icon="ERROR")
