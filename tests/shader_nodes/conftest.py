# SPDX-License-Identifier: GPL-3.0-or-later
import importlib

import pytest


@pytest.fixture
def modules(extension, empty_scene):
    """Of AO fields: the node group, the atlas and the volume."""
    names = ("ao_field", "field_atlas", "field_volume")
    return [importlib.import_module(f"{extension.__name__}.shader_nodes.{name}") for name in names]


@pytest.fixture
def prop(modules):
    import bpy

    obj = bpy.data.objects.new("Prop", None)
    bpy.context.scene.collection.objects.link(obj)
    return obj


@pytest.fixture(scope="session")
def eevee(run_in_fresh_blender):
    """Skips where there is no OpenGL for EEVEE: Blender then aborts, so another process tries."""
    try:
        run_in_fresh_blender(TRY_TO_DRAW)
    except AssertionError:
        pytest.skip("this machine has no OpenGL that Blender can draw with headless")


@pytest.fixture(params=("CYCLES", "EEVEE"))
def engine(request):
    """Each render engine in turn, EEVEE where it can draw."""
    if request.param == "EEVEE":
        request.getfixturevalue("eevee")
    return request.param


TRY_TO_DRAW = """
import bpy
bpy.ops.wm.read_homefile(use_factory_startup=True)
render = bpy.context.scene.render
render.engine, render.resolution_x, render.resolution_y = "BLENDER_WORKBENCH", 4, 4
bpy.ops.render.render()
"""
