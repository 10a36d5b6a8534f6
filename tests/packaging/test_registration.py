# SPDX-License-Identifier: GPL-3.0-or-later
"""Enabling the extension costs little, and disabling it leaves nothing behind."""

import re

# What registration can add to Blender, for comparing.
STATE = """
import sys
import bpy
from enable_extension import PACKAGE, enable_extension

def state():
    types = [getattr(bpy.types, name) for name in dir(bpy.types)]
    structs = {t.bl_rna.identifier: t for t in types if hasattr(t, "bl_rna")}
    return {
        "types": set(dir(bpy.types)),
        "properties": {(name, key) for name, t in structs.items() for key in t.bl_rna.properties.keys()},
        "draw functions": {
            name: len(t.draw._draw_funcs) for name, t in structs.items()
            if hasattr(getattr(t, "draw", None), "_draw_funcs") and len(t.draw._draw_funcs) > 1
        },
        "handlers": {
            name: len(handlers) for name in dir(bpy.app.handlers)
            if isinstance(handlers := getattr(bpy.app.handlers, name), list)
        },
        "keys": {
            (configuration.name, keymap.name): len(keymap.keymap_items)
            for configuration in bpy.context.window_manager.keyconfigs for keymap in configuration.keymaps
        },
    }

def same(one, other):
    for key in one:
        assert one[key] == other[key], key
"""


def test_enabling_imports_no_heavy_package(run_in_fresh_blender):
    output = run_in_fresh_blender("""
import sys
import time
import enable_extension
loaded_by_blender = enable_extension.PACKAGE in sys.modules
began = time.perf_counter()
enable_extension.enable_extension()
if not loaded_by_blender:
    print(f"enabled in {1000 * (time.perf_counter() - began):.0f} ms; more where Python has no cache and compiles")
loaded = {"embreex", "scipy", "OpenEXR", "Imath"} & set(sys.modules)
assert enable_extension.PACKAGE in sys.modules
assert not loaded, loaded
""")
    print(*re.findall("enabled in .*", output))


def test_unregistering_leaves_nothing_behind(run_in_fresh_blender):
    run_in_fresh_blender(
        STATE
        + """
untouched = None if PACKAGE in sys.modules else state()
extension = enable_extension()
extension.unregister()
clean = state()
if untouched is not None:
    same(untouched, clean)
for _ in range(2):
    extension.register()
    assert state()["types"] > clean["types"]
    assert ("Scene", "multibounce_ao") in state()["properties"]
    extension.unregister()
    same(clean, state())
"""
    )


def test_ids_are_unique_and_follow_blenders_convention(extension):
    import bpy

    kinds = {
        "OT": bpy.types.Operator,
        "PT": bpy.types.Panel,
        "MT": bpy.types.Menu,
        "UL": bpy.types.UIList,
        "HT": bpy.types.Header,
    }
    ids = []
    for kind, base in kinds.items():
        for cls in base.__subclasses__():
            if cls.__module__.startswith(extension.__name__):
                name = getattr(cls, "bl_idname", cls.__name__)
                prefix = r"multibounce_ao\." if kind == "OT" else f"MULTIBOUNCE_AO_{kind}_"
                assert re.fullmatch(prefix + "[a-z0-9_]+", name), name
                ids.append(name)
    assert ids
    assert len(ids) == len(set(ids))
