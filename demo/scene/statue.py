# SPDX-License-Identifier: GPL-3.0-or-later
"""Suzanne, glazed, on a stepped pedestal in the niche."""

import bpy
import numpy as np

from . import palette, plan
from .lathe import lathe
from .patches import COLOUR_ATTRIBUTE, add_object

HEAD_SCALE = 0.48
CENTRE = np.array([0.0, 0.14, plan.SILL + 0.96])


def add_suzanne(material) -> bpy.types.Object:
    """The head with three applied subdivisions, so that eyes and ears have vertices to hold their occlusion."""
    bpy.ops.mesh.primitive_monkey_add(size=2, location=CENTRE, rotation=(-0.06, 0.04, -0.14))
    suzanne = bpy.context.object
    suzanne.name = suzanne.data.name = "Suzanne"
    suzanne.scale = (HEAD_SCALE,) * 3
    modifier = suzanne.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 3
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    mesh = suzanne.data
    mesh.shade_smooth()
    mesh.materials.append(material)
    points = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", points)
    colours = np.ones((len(mesh.vertices), 4), np.float32)
    colours[:, :3] = palette.mottled(np.broadcast_to(palette.GLAZE, (len(colours), 3)), points.reshape(-1, 3), 6)
    attribute = mesh.attributes.new(COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    attribute.data.foreach_set("color", np.clip(colours, 0.1, 0.85).ravel())
    return suzanne


def add_pedestal(material) -> bpy.types.Object:
    """An octagonal flat-shaded pedestal."""
    radii = np.array([0.40, 0.40, 0.36, 0.31, 0.26, 0.24, 0.31, 0.38, 0.38, 0.0])
    heights = np.array([-0.03, 0.1, 0.14, 0.14, 0.2, 0.38, 0.44, 0.44, 0.51, 0.51])
    patch = lathe(np.stack([radii, heights], axis=-1), 8, palette.SANDSTONE)
    pedestal = add_object("Pedestal", patch, material, smooth=False)
    pedestal.location = (CENTRE[0], CENTRE[1] + 0.02, plan.SILL - 0.005)
    pedestal.rotation_euler[2] = np.pi / 8
    return pedestal
