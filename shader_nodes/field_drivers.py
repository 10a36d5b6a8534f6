# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers that keep an AO field's node group with its object.

World rotation as a quaternion, mean scale, whose sign tells of mirroring, and whether renders hide the object. These
drivers need no Python.
"""

from __future__ import annotations

import bpy


def follow(tree: bpy.types.ShaderNodeTree, obj: bpy.types.Object) -> None:
    """Drive the nodes ``Rotation`` and ``w``, ``Scale`` and ``Hidden`` of ``tree`` by what ``obj`` does."""
    tree.animation_data_clear()
    rotation, scale = tree.nodes["Rotation"], tree.nodes["Scale"]
    for socket, channel in (
        *zip(rotation.inputs, ("ROT_X", "ROT_Y", "ROT_Z"), strict=True),
        (tree.nodes["w"].outputs[0], "ROT_W"),
        (scale.outputs[0], "SCALE_AVG"),
    ):
        target = _driven_by(socket, obj, "TRANSFORMS")
        target.transform_type = channel
        target.transform_space = "WORLD_SPACE"
        target.rotation_mode = "QUATERNION"
    _driven_by(tree.nodes["Hidden"].outputs[0], obj, "SINGLE_PROP").data_path = "hide_render"


def _driven_by(socket: bpy.types.NodeSocket, obj: bpy.types.Object, kind: str) -> bpy.types.DriverTarget:
    """A driver that gives ``socket`` the value of its one variable, of ``kind``; returns what that reads of ``obj``."""
    driver = socket.driver_add("default_value").driver
    driver.type = "AVERAGE"
    variable = driver.variables.new()
    variable.type = kind
    variable.targets[0].id = obj
    return variable.targets[0]
