# SPDX-License-Identifier: GPL-3.0-or-later
"""The N-panel: the button, the settings in order of use, and the last result."""

from __future__ import annotations

import bpy
from bl_ui.utils import PresetPanel

from ..operators.bake import selected_meshes
from ..operators.forecast import MOST_WARNINGS, forecast
from ..operators.images import map_names
from ..operators.modal import Running, running
from ..operators.names import PROPERTY
from ..operators.presets import FOLDER
from ..operators.report import count_text
from ..operators.settings import BakeSettings
from .sidebar import SidebarPanel

# Draft shows in a blink whether the settings are right; Good is clean to a careful eye, and the default.
SAMPLES = {"Draft": 16, "Good": 256, "Final": 1024}


class MULTIBOUNCE_AO_PT_presets(PresetPanel, bpy.types.Panel):
    bl_label = "Bake Presets"
    preset_subdir = FOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = "multibounce_ao.preset_add"

    def draw(self, context: bpy.types.Context) -> None:
        super().draw(context)
        self.layout.operator("multibounce_ao.reset_settings", icon="LOOP_BACK")


class MULTIBOUNCE_AO_PT_bake(SidebarPanel, bpy.types.Panel):
    bl_label = "Multibounce AO"

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        MULTIBOUNCE_AO_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        run = running()
        if run is not None:
            self._progress(run)
        else:
            row = self.layout.row()
            row.scale_y = 1.5
            row.operator("multibounce_ao.bake", icon="RENDER_STILL")
            self._forecast(context)

        column = self._column(self.layout)
        column.row().prop(settings, "target", expand=True)
        column.prop(settings, "samples")
        self._qualities(column.row(align=True), settings.samples)
        column.prop(settings, "bounces")
        column.prop(settings, "use_material_nodes")

        row = self.layout.row(align=True)
        row.operator("multibounce_ao.add_nodes", text="Add Nodes", icon="NODE_MATERIAL")
        row.operator("multibounce_ao.clear", text="Clear", icon="TRASH")
        row = self.layout.row(align=True)
        row.use_property_split = False
        row.prop(context.window_manager, "multibounce_ao_view", expand=True)

    def _forecast(self, context: bpy.types.Context) -> None:
        """What the button will do, and what to know before."""
        meshes = selected_meshes(context)
        if not meshes or context.mode != "OBJECT":
            return
        told = forecast(meshes, BakeSettings.of(context.scene), context.selected_objects)
        if told.objects:
            self._wrapped(context, told.text(), "NONE")
        for warning in told.warnings[:MOST_WARNINGS]:
            self._wrapped(context, warning)
        if len(told.warnings) > MOST_WARNINGS:
            self.layout.label(text=f"And {len(told.warnings) - MOST_WARNINGS} more", icon="BLANK1")

    def _progress(self, run: Running) -> None:
        """Where the button was: what is at work, how far it is, and how to end it."""
        column = self.layout.column(align=True)
        row = column.row(align=True)
        row.scale_y = 1.5
        row.progress(factor=run.progress.fraction, type="BAR", text=run.text())
        row.operator("multibounce_ao.cancel", text="", icon="CANCEL")
        column.label(text=run.details() or run.label)

    def _qualities(self, row: bpy.types.UILayout, current: int) -> None:
        for name, samples in SAMPLES.items():
            button = row.operator("wm.context_set_int", text=name, depress=samples == current)
            button.data_path = "scene.multibounce_ao.samples"
            button.value = samples


class MULTIBOUNCE_AO_PT_occlusion(SidebarPanel, bpy.types.Panel):
    bl_label = "Occlusion"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        column = self._column(self.layout)
        column.prop(settings, "occluders")
        column.prop(settings, "use_ground_plane")
        column.prop(settings, "ignore_backfaces")
        column.separator()
        column.prop(settings, "max_distance")
        falloff = column.row()
        falloff.active = settings.max_distance > 0.0
        falloff.prop(settings, "falloff")
        column.separator()
        column.prop(settings, "seed")


class MULTIBOUNCE_AO_PT_selected_to_active(SidebarPanel, bpy.types.Panel):
    bl_label = "Selected to Active"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.multibounce_ao, "use_selected_to_active", text="")

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        column = self._column(self.layout)
        column.active = settings.use_selected_to_active
        column.prop(settings, "use_match_names")
        column.separator()
        column.prop(settings, "cage_object")
        extrusion = column.row()
        extrusion.active = settings.cage_object is None
        extrusion.prop(settings, "cage_extrusion", text="Extrusion")
        column.prop(settings, "max_ray_distance")


class MULTIBOUNCE_AO_PT_texture(SidebarPanel, bpy.types.Panel):
    bl_label = "Texture"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        column = self._column(self.layout)
        column.active = settings.target == "TEXTURE"
        column.prop(settings, "resolution")
        column.prop(settings, "margin")
        margin_type = column.row()
        margin_type.active = settings.margin > 0
        margin_type.prop(settings, "margin_type", text="Type")
        obj = context.active_object
        if obj is not None and obj.type == "MESH":
            column.prop_search(settings, "uv_map", obj.data, "uv_layers", icon="GROUP_UVS")
        else:
            column.prop(settings, "uv_map")
        column.prop(settings, "use_udim")


class MULTIBOUNCE_AO_PT_output(SidebarPanel, bpy.types.Panel):
    bl_label = "Output"
    bl_parent_id = "MULTIBOUNCE_AO_PT_texture"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        column = self._column(self.layout)
        # Bounce curves and AO fields go there too, whatever the target.
        column.prop(settings, "output_directory", text="Folder")
        writes, has_folder = settings.target == "TEXTURE", settings.output_directory != ""
        depth, codec = column.row(), column.row()
        depth.active = writes and has_folder
        depth.prop(settings, "color_depth")
        # Tiles and maps are OpenEXR files where they are packed, too.
        exr_maps = settings.map_format == "OPEN_EXR" and map_names(settings) != ()
        codec.active = writes and (has_folder or settings.use_udim or exr_maps)
        codec.prop(settings, "exr_codec")


class MULTIBOUNCE_AO_PT_maps(SidebarPanel, bpy.types.Panel):
    bl_label = "Maps for Other Programs"
    bl_parent_id = "MULTIBOUNCE_AO_PT_texture"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        column = self._column(self.layout)
        column.active = settings.target == "TEXTURE"
        column.prop(settings, "use_ao_map")
        column.prop(settings, "use_colored_ao_map")
        column.prop(settings, "use_gltf_occlusion")
        map_format = column.row()
        grey_map = settings.use_ao_map or settings.use_gltf_occlusion
        map_format.active = grey_map or settings.use_colored_ao_map or settings.use_bent_normal_map
        map_format.prop(settings, "map_format")
        column.separator()
        column.prop(settings, "use_bent_normal_map")
        chosen = column.column()
        chosen.active = settings.use_bent_normal_map
        chosen.prop(settings, "bent_normal_space")
        chosen.prop(settings, "bent_normal_y")


class MULTIBOUNCE_AO_PT_result(SidebarPanel, bpy.types.Panel):
    bl_label = "Last Bake"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        return obj is not None and "f0" in obj.get(PROPERTY, ())

    def draw(self, context: bpy.types.Context) -> None:
        record = context.active_object[PROPERTY]
        f0 = record["f0"]
        lines = (
            ("Points", count_text(record["points"])),
            ("Rays", count_text(record["rays"])),
            ("Time", f"{record['seconds']:.2f} s"),
            ("Mean AO", f"{f0['mean']:.3f}  ({f0['min']:.2f} to {f0['max']:.2f})"),
        )
        self._table(self.layout, lines)
        for warning in record.get("warnings", ()):
            self._wrapped(context, warning)
