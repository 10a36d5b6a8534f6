# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels of overrides in the Properties editor: a switch and a value a line, grey where it is not switched on."""

import importlib
from types import SimpleNamespace

import bpy
import pytest
from enable_extension import PACKAGE

from .layout import draw


@pytest.fixture
def panels(extension, empty_scene):
    return importlib.import_module(f"{PACKAGE}.panels.override_panels")


def properties(drawn):
    return {thing.name: thing.active for thing in drawn}


def test_an_objects_panel(panels):
    panel = panels.MULTIBOUNCE_AO_PT_object
    assert draw(panel) == []  # no object
    bpy.ops.object.light_add()
    assert draw(panel) == []
    bpy.ops.mesh.primitive_plane_add()
    overrides = bpy.context.object.multibounce_ao_overrides
    shown = properties(draw(panel))
    names = {prop.identifier for prop in overrides.bl_rna.properties} - {"rna_type", "name"}
    assert set(shown) == names
    switches = {name for name in names if name.startswith("override_")}
    assert {name for name, active in shown.items() if active} == switches
    overrides.override_samples = True
    assert {name for name, active in properties(draw(panel)).items() if active} == switches | {"samples"}


def test_a_collections_panel(panels):
    panel = panels.MULTIBOUNCE_AO_PT_collection
    assert draw(panel) == []  # the scene's own
    made = bpy.data.collections.new("Props")
    bpy.context.scene.collection.children.link(made)
    bpy.context.view_layer.active_layer_collection = bpy.context.view_layer.layer_collection.children["Props"]
    shown = properties(draw(panel))
    names = {prop.identifier for prop in made.multibounce_ao_overrides.bl_rna.properties} - {"rna_type", "name"}
    assert set(shown) == names - {"cage_object", "override_cage_object"}


def test_they_are_closed_and_stand_in_the_tab(panels):
    for name, tab in (("object", "object"), ("collection", "collection")):
        panel = getattr(panels, f"MULTIBOUNCE_AO_PT_{name}")
        assert (panel.bl_space_type, panel.bl_context, panel.bl_options) == ("PROPERTIES", tab, {"DEFAULT_CLOSED"})
        context = SimpleNamespace(object=None, collection=None, scene=bpy.context.scene)
        assert not panel.poll(context)
