# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands as a terminal gives them, and a file for them."""

from __future__ import annotations

import json
from pathlib import Path

import bpy

from .bakes import operators
from .meshes import add, box, plate


def run(*arguments: object) -> int:
    """The command with these arguments; returns its exit code."""
    return operators("command_line").run([str(argument) for argument in arguments])


def save_several(folder: Path) -> Path:
    """Saves a .blend with meshes that renders show and that they do not, a lamp, and a mesh without UVs; the scene is
    empty afterwards."""
    plate("Floor")
    box("Crate", low=(9, -1, -4), high=(11, 1, -2))  # below the floor, out of its sight
    plate("Far", location=(0, 0, 50)).hide_render = True
    plate("Folded away", location=(0, 0, 60)).hide_viewport = True
    attic = bpy.data.collections.new("Attic")
    bpy.context.scene.collection.children.link(attic)
    attic.hide_render = True
    attic.objects.link(stored := plate("Stored", location=(0, 0, 70)))
    bpy.context.scene.collection.objects.unlink(stored)
    add("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    path = folder / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return path


def reported(blend: Path, *arguments: object, code: int = 0) -> dict:
    """The report of a bake that ends with ``code``."""
    report = blend.parent / "reports" / "report.json"
    assert run("bake", blend, "--report", report, *arguments) == code
    return json.loads(report.read_text(encoding="utf-8"))
