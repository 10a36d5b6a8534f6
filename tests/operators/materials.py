# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials as artists have them."""

from __future__ import annotations

import bpy


def material(name: str = "Paint", colour=(0.8, 0.4, 0.2, 1.0)) -> bpy.types.Material:
    """One Principled BSDF of a plain colour."""
    made = bpy.data.materials.new(name)
    if made.node_tree is None:  # before Blender 5.0
        made.use_nodes = True
    bsdf(made).inputs["Base Color"].default_value = colour
    return made


def textured_material(name: str = "Textured") -> bpy.types.Material:
    made = material(name)
    tree = made.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Wood", 4, 4)
    texture.label = "Wood of the floor"
    tree.links.new(texture.outputs["Color"], bsdf(made).inputs["Base Color"])
    return made


def bsdf(owner: bpy.types.Material) -> bpy.types.ShaderNodeBsdfPrincipled:
    return next(node for node in owner.node_tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled")


def group(owner: bpy.types.Material) -> bpy.types.ShaderNodeGroup | None:
    """The extension's node group in a material."""
    groups = [node for node in owner.node_tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    assert len(groups) < 2
    return groups[0] if groups else None


def source(socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """What feeds an input."""
    return socket.links[0].from_socket if socket.is_linked else None
