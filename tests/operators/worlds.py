# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds whose light is known."""

from __future__ import annotations

import bpy
import numpy as np


def world(colour=(1.0, 1.0, 1.0), strength: float = 1.0) -> bpy.types.World:
    """A World of one colour, the scene's own from now on."""
    made = bpy.data.worlds.new("World")
    if made.node_tree is None:  # before Blender 5.0
        made.use_nodes = True
    background(made).inputs["Color"].default_value = (*colour, 1.0)
    background(made).inputs["Strength"].default_value = strength
    bpy.context.scene.world = made
    return made


def background(made: bpy.types.World) -> bpy.types.ShaderNode:
    return next(node for node in made.node_tree.nodes if node.bl_idname == "ShaderNodeBackground")


def picture_world(pixels: np.ndarray, turn: float = 0.0) -> bpy.types.World:
    """A World of an equirectangular picture (h, w, 3), bottom row first, turned by ``turn`` radians about z."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("Sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.dstack((pixels, np.ones((height, width)))).astype(np.float32).ravel())
    image.pack()
    made = world()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping, place = nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeTexCoord")
    mapping.inputs["Rotation"].default_value = (0, 0, turn)
    links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], background(made).inputs["Color"])
    return made


def directions_world() -> bpy.types.World:
    """A World whose radiance in the direction (x, y, z) is (2 + x, 2 + y, 2 + z), by its nodes."""
    made = world()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    place, add = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeVectorMath")
    add.inputs[1].default_value = (2, 2, 2)
    links.new(place.outputs["Generated"], add.inputs[0])
    links.new(add.outputs[0], background(made).inputs["Color"])
    return made
