# SPDX-License-Identifier: GPL-3.0-or-later
"""The AO Field panel: the field of the active object, and when it is to be baked again."""

import bpy
import pytest

from .layout import draw


@pytest.fixture
def panel(extension, empty_scene):
    return next(cls for cls in bpy.types.Panel.__subclasses__() if cls.__name__ == "MULTIBOUNCE_AO_PT_field")


@pytest.fixture
def cube(panel):
    bpy.ops.mesh.primitive_cube_add()
    settings = bpy.context.scene.multibounce_ao
    settings.samples, settings.field_resolution = 4, 8
    return bpy.context.active_object


def labels(panel):
    return [thing.name for thing in draw(panel) if thing.kind == "label"]


def test_nothing_to_tell_before_a_bake(panel, cube):
    assert labels(panel) == []
    bpy.context.view_layer.objects.active = None
    assert labels(panel) == []


def test_warns_of_an_uneven_scale_before_a_bake(panel, cube):
    cube.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    assert labels(panel) == []
    cube.scale.x = 1
    bpy.context.view_layer.update()
    assert labels(panel)[0].startswith("Scaled unevenly: apply the scale")


def test_tells_of_the_field(panel, cube):
    bpy.ops.multibounce_ao.bake_field()
    assert {"Cube", "8 x 8"} <= set(labels(panel))
    assert not any("again" in label for label in labels(panel))


def test_offers_a_new_bake_after_an_uneven_scale(panel, cube):
    bpy.ops.multibounce_ao.bake_field()
    cube.scale = (2, 2, 2)
    bpy.context.view_layer.update()
    assert not any("again" in label for label in labels(panel))
    cube.scale.x = 1
    bpy.context.view_layer.update()
    assert any("bake again" in label for label in labels(panel))
    bpy.ops.multibounce_ao.bake_field()
    assert not any("again" in label for label in labels(panel))
