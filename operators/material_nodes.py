# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group in one material: between what feeds a Principled BSDF's Base Color and that socket, and out again."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..shader_nodes import multibounce_fit
from .names import BENT_CONE, PROPERTY

# For each kind of bounces: the group, and which channel's output feeds which of its inputs.
GROUPS = {"FITTED": (multibounce_fit, {"AO": (BENT_CONE, "Alpha")})}

# Set on a material whose nodes were off before we came.
_NODES_WERE_OFF = "multibounce_ao_nodes_were_off"


@dataclass(frozen=True)
class BakedSource:
    """Where a material finds what was baked: the mesh's attributes, or ``images`` by channel through ``uv_map``."""

    images: dict[str, bpy.types.Image] | None = None
    uv_map: str = ""


def plug(material: bpy.types.Material, bounces: str, source: BakedSource | None) -> bool:
    """Put the group for ``bounces`` before every Principled BSDF of ``material``, fed from ``source`` if there is one.

    Groups that are there already keep their place and get the new source. Returns whether there was a BSDF to plug
    into.
    """
    _turn_nodes_on(material)
    tree = material.node_tree
    _remove_sources(tree)
    module, inputs = GROUPS[bounces]
    group_tree = module.ensure()
    plugged = []
    for bsdf in [node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled"]:
        socket = bsdf.inputs["Base Color"]
        link = socket.links[0] if socket.is_linked else None
        if link and _is_ours(link.from_node):
            group = link.from_node
            group.node_tree = group_tree
        else:
            group = _new_node(tree, "ShaderNodeGroup", bsdf.location.x - 260, bsdf.location.y)
            group.node_tree = group_tree
            group.width = 200
            group.inputs["Base Color"].default_value = socket.default_value
            if link:
                muted = link.is_muted
                tree.links.new(link.from_socket, group.inputs["Base Color"]).is_muted = muted
            tree.links.new(group.outputs["Color"], socket)
        plugged.append(group)
    if plugged and source is not None:
        _feed(tree, plugged, inputs, source)
    return bool(plugged)


def unplug(material: bpy.types.Material) -> None:
    """Take our nodes out of ``material``; the BSDF gets back what fed it, or its colour as it now is."""
    tree = material.node_tree
    if tree is None:
        return
    for group in [node for node in tree.nodes if _is_ours(node) and node.bl_idname == "ShaderNodeGroup"]:
        base_color = group.inputs.get("Base Color")
        color = group.outputs.get("Color")
        for link in list(color.links) if color else []:
            target = link.to_socket
            if base_color.is_linked:
                source = base_color.links[0]
                muted = source.is_muted
                tree.links.new(source.from_socket, target).is_muted = muted
            else:
                tree.links.remove(link)
                if hasattr(target, "default_value"):
                    target.default_value = base_color.default_value
    for node in [node for node in tree.nodes if _is_ours(node)]:
        tree.nodes.remove(node)
    if _NODES_WERE_OFF in material:
        material.use_nodes = False
        del material[_NODES_WERE_OFF]


def _feed(tree: bpy.types.NodeTree, groups: list, inputs: dict[str, tuple[str, str]], source: BakedSource) -> None:
    """Link the baked channels into every group, one source node a channel."""
    x = min(group.location.x for group in groups) - 320
    y = groups[0].location.y - 160
    nodes = {}
    for socket, (channel, output) in inputs.items():
        if channel not in nodes:
            nodes[channel] = _source_node(tree, channel, source, x, y)
            y -= 300
        for group in groups:
            tree.links.new(nodes[channel].outputs[output], group.inputs[socket])


def _source_node(tree: bpy.types.NodeTree, channel: str, source: BakedSource, x: float, y: float) -> bpy.types.Node:
    if source.images is None:
        node = _new_node(tree, "ShaderNodeAttribute", x, y)
        node.attribute_type = "GEOMETRY"
        node.attribute_name = channel
        return node
    node = _new_node(tree, "ShaderNodeTexImage", x, y)
    node.image = source.images[channel]
    node.extension = "EXTEND"  # the tile's border must not blend with the opposite side
    uv_map = _new_node(tree, "ShaderNodeUVMap", x - 200, y)
    uv_map.uv_map = source.uv_map
    tree.links.new(uv_map.outputs["UV"], node.inputs["Vector"])
    return node


def _new_node(tree: bpy.types.NodeTree, kind: str, x: float, y: float) -> bpy.types.Node:
    node = tree.nodes.new(kind)
    node.location = (x, y)
    node.select = False
    node[PROPERTY] = True
    return node


def _is_ours(node: bpy.types.Node) -> bool:
    return PROPERTY in node


def _remove_sources(tree: bpy.types.NodeTree) -> None:
    for node in [node for node in tree.nodes if _is_ours(node) and node.bl_idname != "ShaderNodeGroup"]:
        tree.nodes.remove(node)


def _turn_nodes_on(material: bpy.types.Material) -> None:
    """Before 5.0 a material could do without nodes: it then shows its viewport colour, which the new BSDF takes
    over."""
    if bpy.app.version >= (5, 0, 0) or material.use_nodes:
        return
    material.use_nodes = True
    material[_NODES_WERE_OFF] = True
    for node in material.node_tree.nodes:
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            node.inputs["Base Color"].default_value = material.diffuse_color
