# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the settings, kept as Blender keeps all presets, and the way back to the defaults."""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase

from .settings import BakeSettings

FOLDER = "multibounce_ao"
# What belongs to one scene alone, not to a way of baking.
_OF_A_SCENE = {"uv_map", "output_directory", "cage_object"}


class MULTIBOUNCE_AO_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Add or remove a preset of the bake's settings"""

    bl_idname = "multibounce_ao.preset_add"
    bl_label = "Add Bake Preset"
    preset_menu = "MULTIBOUNCE_AO_PT_presets"
    preset_defines = ["settings = bpy.context.scene.multibounce_ao"]
    preset_values = [f"settings.{name}" for name in BakeSettings.__dataclass_fields__ if name not in _OF_A_SCENE]
    preset_subdir = FOLDER


class MULTIBOUNCE_AO_OT_reset_settings(bpy.types.Operator):
    """Give all settings of Multibounce AO in this scene their defaults"""

    bl_idname = "multibounce_ao.reset_settings"
    bl_label = "Reset to Defaults"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        settings = context.scene.multibounce_ao
        for prop in settings.bl_rna.properties:
            if prop.identifier not in {"rna_type", "name"}:
                settings.property_unset(prop.identifier)
        return {"FINISHED"}
