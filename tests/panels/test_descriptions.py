# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and tooltips as Blender's own: a tooltip for everything, a sentence without its full stop, units."""

import re

import bpy
import pytest

OPERATORS = {
    "bake": "Bake Multibounce AO",
    "clear": "Clear Bake",
    "add_nodes": "Add Multibounce Nodes",
    "add_curve_nodes": "Add Curve Nodes",
    "bake_field": "Bake AO Field",
    "apply_field": "Apply AO Field",
    "fit_bounces": "Fit Bounce Curves",
    "clear_fit": "Use Published Fit",
    "project_world": "Project World",
    "clear_world": "Use White World",
    "add_world_light": "Add World Light",
    "reset_settings": "Reset to Defaults",
}


@pytest.fixture(autouse=True)
def scene(empty_scene):
    return empty_scene


def settings():
    return [p for p in bpy.context.scene.multibounce_ao.bl_rna.properties if p.identifier not in ("rna_type", "name")]


def assert_tooltip(text):
    assert len(text) > 10
    assert re.match("[A-Z0-9]", text), text
    assert not text.endswith("."), text
    assert "  " not in text
    assert "\n" not in text


@pytest.mark.parametrize(("name", "label"), [*OPERATORS.items(), ("cancel", "Cancel Bake")])
def test_operators(name, label):
    rna = getattr(bpy.ops.multibounce_ao, name).get_rna_type()
    assert rna.name == label
    assert_tooltip(rna.description)
    # Settings live on the scene, so that the panel, scripts and the command line share them.
    assert {p.identifier for p in rna.properties} == {"rna_type"}


def test_settings_and_their_choices():
    for prop in settings():
        assert prop.name
        assert prop.name != prop.identifier
        assert_tooltip(prop.description)
        for item in prop.enum_items if prop.type == "ENUM" else ():
            assert item.name
            assert_tooltip(item.description)


def test_settings_are_those_of_the_contract():
    defaults = {
        "target": "VERTEX", "samples": 256, "max_distance": 0.0, "falloff": "NONE", "occluders": "VISIBLE",
        "use_ground_plane": False, "ignore_backfaces": False, "bounces": "BAKED", "use_material_nodes": True,
        "seed": 0, "resolution": 1024, "margin": 16, "uv_map": "", "output_directory": "",
        "use_bent_normal_map": False, "bent_normal_space": "TANGENT", "bent_normal_y": "POS_Y", "height_map": None,
        "height_map_amplitude": pytest.approx(0.04), "field_resolution": 16, "use_field_volume": False,
        "use_udim": False,
        "use_ao_map": False, "use_colored_ao_map": False, "map_format": "PNG_8", "use_gltf_occlusion": False,
        "use_selected_to_active": False, "use_match_names": False, "cage_object": None, "cage_extrusion": 0.0,
        "max_ray_distance": 0.0, "color_depth": "32", "exr_codec": "ZIP", "margin_type": "ADJACENT_FACES",
    }  # fmt: skip
    assert {p.identifier: getattr(p, "default", None) for p in settings()} == defaults
    choices = {p.identifier: [item.identifier for item in p.enum_items] for p in settings() if p.type == "ENUM"}
    assert choices == {
        "target": ["VERTEX", "TEXTURE"],
        "falloff": ["NONE", "LINEAR", "SMOOTH"],
        "occluders": ["SELF", "SELECTED", "VISIBLE"],
        "bounces": ["FITTED", "BAKED", "RADIOSITY"],
        "bent_normal_space": ["OBJECT", "TANGENT"],
        "bent_normal_y": ["POS_Y", "NEG_Y"],
        "color_depth": ["16", "32"],
        "map_format": ["PNG_8", "PNG_16", "OPEN_EXR"],
        "margin_type": ["ADJACENT_FACES", "EXTEND"],
        "exr_codec": ["NONE", "RLE", "ZIPS", "ZIP", "PIZ"],
    }


def test_quantities_have_units():
    units = {p.identifier: (p.subtype, p.unit) for p in settings()}
    for name in ("max_distance", "cage_extrusion", "max_ray_distance"):
        assert units[name] == ("DISTANCE", "LENGTH")
    assert units["resolution"][0] == units["field_resolution"][0] == "PIXEL"
    assert units["margin"][0] == "PIXEL"
    assert units["output_directory"][0] == "DIR_PATH"


def test_operators_can_be_undone(extension):
    for name in OPERATORS:
        cls = next(
            c for c in bpy.types.Operator.__subclasses__() if getattr(c, "bl_idname", "") == f"multibounce_ao.{name}"
        )
        assert {"REGISTER", "UNDO"} <= cls.bl_options
