# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of the user's own, and the way back to the defaults."""

from pathlib import Path

import bpy

from .bakes import change_settings
from .meshes import box


def values():
    settings = bpy.context.scene.multibounce_ao
    names = [prop.identifier for prop in settings.bl_rna.properties if prop.identifier not in ("rna_type", "name")]
    return {name: getattr(settings, name) for name in names}


def test_a_preset_brings_the_settings_back_but_for_those_of_one_scene():
    cage = box("Cage")
    change_settings(
        samples=77, target="TEXTURE", falloff="SMOOTH", max_distance=2.5, uv_map="A", seed=3, cage_object=cage
    )
    assert bpy.ops.multibounce_ao.preset_add(name="Mine") == {"FINISHED"}
    kept = values()
    (file,) = Path(bpy.utils.user_resource("SCRIPTS"), "presets", "multibounce_ao").glob("*.py")
    try:
        bpy.ops.multibounce_ao.reset_settings()
        change_settings(uv_map="B")
        bpy.ops.script.execute_preset(filepath=str(file), menu_idname="MULTIBOUNCE_AO_PT_presets")
        assert values() == kept | {"uv_map": "B", "cage_object": None}
    finally:
        assert bpy.ops.multibounce_ao.preset_add(name="Mine", remove_name=True, remove_active=True) == {"FINISHED"}
        file.unlink(missing_ok=True)


def test_reset(scene):
    defaults = values()
    image = bpy.data.images.new("Relief", 4, 4)
    change_settings(samples=7, target="TEXTURE", occluders="SELF", bounces="FITTED", seed=4, height_map=image)
    assert values() != defaults
    assert bpy.ops.multibounce_ao.reset_settings() == {"FINISHED"}
    assert values() == defaults
