# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples of docs/python.md run as they stand."""

import re
from pathlib import Path

import numpy as np
import pytest
from enable_extension import PACKAGE

PAGE = Path(__file__).resolve().parents[2] / "docs" / "python.md"


@pytest.fixture(scope="module")
def examples():
    """Of a tool in Blender, of overrides there, and of a tool without Blender."""
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_in_blender(examples, empty_scene, capsys):
    import bpy

    bpy.ops.mesh.primitive_monkey_add()
    bpy.ops.object.light_add()
    exec(compile(examples[0].replace("bl_ext.user_default.multibounce_ao", PACKAGE), "python.md", "exec"), {})
    lines = [line for line in capsys.readouterr().out.splitlines() if "Suzanne" in line]
    assert lines[0].split()[:2] == ["0%", "Suzanne"]
    assert lines[-2].split()[:2] == ["100%", "Suzanne"]
    assert re.fullmatch(r"Suzanne mean AO 0\.\d{3} in \d+\.\d\d s", lines[-1])
    assert "Multibounce AO" in bpy.data.objects["Suzanne"].data.attributes


def test_overrides(examples, empty_scene):
    import bpy

    bpy.ops.mesh.primitive_plane_add()
    exec(compile(examples[1], "python.md", "exec"), {})
    bpy.ops.multibounce_ao.bake()
    assert bpy.context.object["multibounce_ao"]["samples"] == 1024


def test_without_blender(examples):
    """F0 beside a wall of height 1 and half-width 1 at distance d, in front of its middle: 1 minus the form factor of a
    rectangle that stands on the point's plane (Howell, A Catalog of Radiation Heat Transfer Configuration Factors,
    B-4), twice one half of it."""
    found = {}
    exec(compile(examples[2], "python.md", "exec"), found)
    d = found["x"] + 1.0
    root = np.hypot(1.0, d)
    blocked = 2 * (np.arctan(1 / d) - d / root * np.arctan(1 / root)) / (2 * np.pi)
    assert np.abs(found["ao"][:, 0] - (1 - blocked)).max() < 0.01
    assert (np.diff(found["ao"][:, 0]) > 0).all()
    assert found["rays"] == 7 * 256
    assert found["bent"].shape == (7, 4)
