# SPDX-License-Identifier: GPL-3.0-or-later
"""Multibounce AO: ambient occlusion, coloured as light is after many bounces.

core/          the mathematics and the rays, without Blender
operators/     reads and writes Blender's data
shader_nodes/  builds the node groups
panels/        draws
"""

import bpy

from .operators import command_line, modal, occluder_cache, overrides, settings, uv_checks, view_result
from .operators.add_nodes import MULTIBOUNCE_AO_OT_add_curve_nodes, MULTIBOUNCE_AO_OT_add_nodes
from .operators.apply_field import MULTIBOUNCE_AO_OT_apply_field
from .operators.bake import MULTIBOUNCE_AO_OT_bake
from .operators.bake_field import MULTIBOUNCE_AO_OT_bake_field
from .operators.clear import MULTIBOUNCE_AO_OT_clear
from .operators.fit_bounces import MULTIBOUNCE_AO_OT_clear_fit, MULTIBOUNCE_AO_OT_fit_bounces
from .operators.modal import MULTIBOUNCE_AO_OT_cancel
from .operators.presets import MULTIBOUNCE_AO_OT_preset_add, MULTIBOUNCE_AO_OT_reset_settings
from .operators.project_world import (
    MULTIBOUNCE_AO_OT_add_world_light,
    MULTIBOUNCE_AO_OT_clear_world,
    MULTIBOUNCE_AO_OT_project_world,
)
from .panels.bake_panel import (
    MULTIBOUNCE_AO_PT_bake,
    MULTIBOUNCE_AO_PT_maps,
    MULTIBOUNCE_AO_PT_occlusion,
    MULTIBOUNCE_AO_PT_output,
    MULTIBOUNCE_AO_PT_presets,
    MULTIBOUNCE_AO_PT_result,
    MULTIBOUNCE_AO_PT_selected_to_active,
    MULTIBOUNCE_AO_PT_texture,
)
from .panels.field_panel import MULTIBOUNCE_AO_PT_field
from .panels.fit_panel import MULTIBOUNCE_AO_PT_fit
from .panels.override_panels import MULTIBOUNCE_AO_PT_collection, MULTIBOUNCE_AO_PT_object
from .panels.world_panel import MULTIBOUNCE_AO_PT_world

# In order of registration: the settings' type before its place on the scene, a panel before its sub-panels.
CLASSES = (
    settings.MultibounceAOSettings,
    overrides.MultibounceAOOverrides,
    MULTIBOUNCE_AO_OT_bake,
    MULTIBOUNCE_AO_OT_cancel,
    MULTIBOUNCE_AO_OT_clear,
    MULTIBOUNCE_AO_OT_add_nodes,
    MULTIBOUNCE_AO_OT_add_curve_nodes,
    MULTIBOUNCE_AO_OT_fit_bounces,
    MULTIBOUNCE_AO_OT_clear_fit,
    MULTIBOUNCE_AO_OT_bake_field,
    MULTIBOUNCE_AO_OT_apply_field,
    MULTIBOUNCE_AO_OT_project_world,
    MULTIBOUNCE_AO_OT_clear_world,
    MULTIBOUNCE_AO_OT_add_world_light,
    MULTIBOUNCE_AO_OT_preset_add,
    MULTIBOUNCE_AO_OT_reset_settings,
    overrides.MULTIBOUNCE_AO_OT_clear_overrides,
    MULTIBOUNCE_AO_PT_presets,
    MULTIBOUNCE_AO_PT_bake,
    MULTIBOUNCE_AO_PT_occlusion,
    MULTIBOUNCE_AO_PT_selected_to_active,
    MULTIBOUNCE_AO_PT_texture,
    MULTIBOUNCE_AO_PT_output,
    MULTIBOUNCE_AO_PT_maps,
    MULTIBOUNCE_AO_PT_result,
    MULTIBOUNCE_AO_PT_fit,
    MULTIBOUNCE_AO_PT_world,
    MULTIBOUNCE_AO_PT_field,
    MULTIBOUNCE_AO_PT_object,
    MULTIBOUNCE_AO_PT_collection,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    settings.add_to_scene()
    overrides.register()
    command_line.register()
    occluder_cache.register()
    modal.register()
    uv_checks.register()
    view_result.register()


def unregister() -> None:
    view_result.unregister()
    uv_checks.unregister()
    modal.unregister()
    occluder_cache.unregister()
    command_line.unregister()
    overrides.unregister()
    settings.remove_from_scene()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
