# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar: everything in it can be drawn, every setting can be reached, and what does not apply is greyed out."""

import importlib
import re

import bpy
import pytest
from enable_extension import PACKAGE

from .layout import draw

WORLD_OPERATORS = ("project_world", "add_world_light")
FIELD_OPERATORS = ("bake_field", "apply_field")
OPERATORS = {
    f"multibounce_ao.{name}"
    for name in (*WORLD_OPERATORS, *FIELD_OPERATORS, "bake", "clear", "add_nodes", "fit_bounces", "add_curve_nodes")
}


@pytest.fixture
def panels(extension, empty_scene):
    """The extension's panels of the sidebar by name, in the order of registration; not the menu of presets, nor what
    the Properties editor shows."""
    ours = [cls for cls in bpy.types.Panel.__subclasses__() if cls.__module__.startswith(extension.__name__)]
    found = [cls for cls in ours if cls.bl_region_type == "UI"]
    assert found
    return {cls.__name__: cls for cls in found}


@pytest.fixture
def plate():
    bpy.ops.mesh.primitive_plane_add()
    return bpy.context.active_object


def properties(drawn):
    return {thing.name: thing.active for thing in drawn if thing.kind == "prop"}


def everything(panels):
    return [thing for panel in panels.values() for thing in draw(panel)]


@pytest.mark.parametrize("active", ["nothing", "a mesh", "a lamp", "a baked mesh", "a mesh baked to textures"])
def test_every_setting_and_operator_is_there_once(panels, active):
    if "mesh" in active:
        bpy.ops.mesh.primitive_plane_add()
    if active == "a lamp":
        bpy.ops.object.light_add()
    if "baked" in active:
        settings = bpy.context.scene.multibounce_ao
        settings.resolution = 8
        settings.target = "TEXTURE" if "textures" in active else "VERTEX"
        bpy.ops.multibounce_ao.bake()
    drawn = everything(panels)
    names = [thing.name for thing in drawn if thing.kind == "prop"]
    assert len(names) == len(set(names))
    known = {p.identifier for p in bpy.context.scene.multibounce_ao.bl_rna.properties}
    assert set(names) == known - {"rna_type", "name"} | {"multibounce_ao_view"}
    assert {thing.name for thing in drawn if thing.kind == "operator"} == {*OPERATORS, "wm.context_set_int"}


def test_the_button_comes_first(panels):
    first = everything(panels)[0]
    assert (first.kind, first.name) == ("operator", "multibounce_ao.bake")


def test_progress_takes_the_place_of_the_button(panels, monkeypatch):
    modal = importlib.import_module(f"{PACKAGE}.operators.modal")
    progress = importlib.import_module(f"{PACKAGE}.operators.progress")
    run = object.__new__(modal.Running)
    run.progress, run.pace, run.waits = progress.Progress(0.425, "Suzanne"), progress.Pace(), False
    run.label, run.pace.left, run.pace.rate = "Bake Multibounce AO", 61.0, 2.5e6
    monkeypatch.setattr(modal, "_running", run)
    bar, button, details = everything(panels)[:3]
    assert (bar.kind, bar.name) == ("progress", "42 %  Suzanne")
    assert (button.kind, button.name) == ("operator", "multibounce_ao.cancel")
    assert details.name == "2.5 M rays/s, 1 min 1 s left"
    with pytest.raises(RuntimeError, match="Bake Multibounce AO is running: wait for it, or press Esc"):
        bpy.ops.multibounce_ao.bake()
    run.waits = True
    assert [thing.name for thing in everything(panels)[:3:2]] == ["Done", "Switch to Object Mode to store it"]


def test_buttons_set_the_samples(panels):
    buttons = [thing.options for thing in everything(panels) if thing.name == "wm.context_set_int"]
    chosen = []
    for button in buttons:
        assert bpy.ops.wm.context_set_int(data_path=button.data_path, value=button.value) == {"FINISHED"}
        chosen.append(bpy.context.scene.multibounce_ao.samples)
    default = bpy.context.scene.multibounce_ao.bl_rna.properties["samples"].default
    assert chosen[0] < default < chosen[-1] and default in chosen


def test_what_does_not_apply_is_grey(panels):
    settings = bpy.context.scene.multibounce_ao
    of_textures = {"resolution", "margin", "margin_type", "uv_map", "color_depth", "exr_codec"}
    of_textures |= {"use_bent_normal_map", "bent_normal_space", "bent_normal_y"}
    of_textures |= {"use_udim", "use_ao_map", "use_colored_ao_map", "use_gltf_occlusion", "map_format"}
    settings.target, settings.max_distance = "VERTEX", 0
    of_cages = {"use_match_names", "cage_object", "cage_extrusion", "max_ray_distance"}
    grey = {name for name, active in properties(everything(panels)).items() if not active}
    assert grey == of_textures | of_cages | {"falloff", "height_map_amplitude"}
    settings.use_selected_to_active = True
    settings.target, settings.max_distance = "TEXTURE", 1
    grey = {name for name, active in properties(everything(panels)).items() if not active}
    packed = {"color_depth", "exr_codec"}
    assert grey == packed | {"map_format", "height_map_amplitude", "bent_normal_space", "bent_normal_y"}
    settings.use_bent_normal_map = True
    grey = {name for name, active in properties(everything(panels)).items() if not active}
    assert grey == packed | {"height_map_amplitude"}
    # What is packed as an OpenEXR file has a codec, too.
    for name, value, other in (("use_udim", True, False), ("map_format", "OPEN_EXR", "PNG_8")):
        setattr(settings, name, value)
        assert {name for name, active in properties(everything(panels)).items() if not active} == {
            "color_depth",
            "height_map_amplitude",
        }
        setattr(settings, name, other)
    settings.output_directory = "//maps"
    settings.height_map = bpy.data.images.new("Relief", 4, 4)
    assert all(properties(everything(panels)).values())


def test_last_result(panels, plate):
    bpy.ops.multibounce_ao.clear()
    assert draw(panels["MULTIBOUNCE_AO_PT_result"]) == []
    bpy.context.scene.multibounce_ao.samples = 100
    bpy.ops.multibounce_ao.bake()
    labels = [thing.name for thing in draw(panels["MULTIBOUNCE_AO_PT_result"]) if thing.kind == "label"]
    assert {"4", "400"} < set(labels)  # points, rays
    assert any(re.fullmatch(r"\d+\.\d+ s", label) for label in labels)
    assert any(label.startswith("1.000") for label in labels)  # the mean


def test_what_the_button_will_do_stands_under_it(panels, plate):
    bpy.context.scene.multibounce_ao.samples = 100
    plate.hide_render = True
    button, *labels = everything(panels)[:3]
    assert button.name == "multibounce_ao.bake"
    assert labels[0].name.startswith("1 object, 4 points, 400 rays")
    assert labels[1].name.startswith("'Plane' is disabled in renders")
    plate.select_set(False)
    assert everything(panels)[1].kind == "prop"


def test_panels_stand_in_the_sidebar_of_the_viewport(panels):
    top = [panel for panel in panels.values() if not getattr(panel, "bl_parent_id", "")]
    assert len(top) == 1
    before = set()
    for name, panel in panels.items():
        assert (panel.bl_space_type, panel.bl_region_type, panel.bl_category) == ("VIEW_3D", "UI", "Multibounce AO")
        assert panel is top[0] or panel.bl_parent_id in before
        before.add(name)
        assert getattr(bpy.types, panel.__name__).is_registered


def test_the_view_is_off_in_another_file(panels, tmp_path):
    manager = bpy.context.window_manager
    manager.multibounce_ao_view = "AO"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"), copy=True)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "other.blend"), load_ui=False)
    assert bpy.context.window_manager.multibounce_ao_view == "OFF"
