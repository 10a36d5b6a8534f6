# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the Properties editor: settings that an object or a collection has of its own."""

from __future__ import annotations

import bpy

from ..operators.overrides import SWITCH, MultibounceAOOverrides

# In groups, as the sidebar has them.
GROUPS = (
    ("target", "samples", "use_material_nodes"),
    ("occluders", "ignore_backfaces", "max_distance", "falloff"),
    ("resolution", "margin", "margin_type", "uv_map", "use_udim"),
    ("cage_object", "cage_extrusion", "max_ray_distance"),
    ("field_resolution", "use_field_volume"),
)
# What the sidebar's headings tell apart there.
TEXTS = {"field_resolution": "Field Resolution", "use_field_volume": "Field Volume"}


class OverridePanel:
    """To be derived from before ``bpy.types.Panel``."""

    bl_label = "Multibounce AO"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_options = {"DEFAULT_CLOSED"}

    def _overrides(self, overrides: MultibounceAOOverrides, mesh: bpy.types.Mesh | None) -> None:
        """A switch and a value a line; UV maps are those of ``mesh``. A collection, which has none, has no cage
        either."""
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for group in GROUPS:
            column = layout.column()
            for name in group:
                if name != "cage_object" or mesh is not None:
                    self._line(column, overrides, name, mesh)

    def _line(
        self, column: bpy.types.UILayout, overrides: MultibounceAOOverrides, name: str, mesh: bpy.types.Mesh | None
    ) -> None:
        prop = overrides.bl_rna.properties[name]
        row = column.row(align=True, heading=TEXTS.get(name, prop.name))
        row.prop(overrides, SWITCH + name, text="")
        value = row.row(align=True)
        value.active = getattr(overrides, SWITCH + name)
        if name == "uv_map" and mesh is not None:
            value.prop_search(overrides, name, mesh, "uv_layers", text="", icon="GROUP_UVS")
        elif prop.type == "BOOLEAN":
            value.prop(overrides, name, text="On" if getattr(overrides, name) else "Off", toggle=True)
        else:
            value.prop(overrides, name, text="")

    def _clear(self, overrides: MultibounceAOOverrides) -> None:
        row = self.layout.row()
        row.context_pointer_set("multibounce_ao_overrides", overrides)
        row.operator("multibounce_ao.clear_overrides", text="", icon="LOOP_BACK", emboss=False)


class MULTIBOUNCE_AO_PT_object(OverridePanel, bpy.types.Panel):
    bl_context = "object"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.type == "MESH"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self._clear(context.object.multibounce_ao_overrides)

    def draw(self, context: bpy.types.Context) -> None:
        self._overrides(context.object.multibounce_ao_overrides, context.object.data)


class MULTIBOUNCE_AO_PT_collection(OverridePanel, bpy.types.Panel):
    bl_context = "collection"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.collection not in (None, context.scene.collection)

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self._clear(context.collection.multibounce_ao_overrides)

    def draw(self, context: bpy.types.Context) -> None:
        self._overrides(context.collection.multibounce_ao_overrides, None)
