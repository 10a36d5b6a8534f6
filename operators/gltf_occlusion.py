# SPDX-License-Identifier: GPL-3.0-or-later
"""The AO map where Blender's glTF exporter looks for it: the Occlusion input of a node group "glTF Material Output"."""

from __future__ import annotations

import bpy

from .names import AO_MAP, PROPERTY

# The exporter knows the group by this name, and the input by its.
GROUP, OCCLUSION = "glTF Material Output", "Occlusion"
# Set on the nodes that are here for it.
GLTF = "multibounce_ao_gltf"


def plug_occlusion(material: bpy.types.Material, image: bpy.types.Image, uv_map: str) -> str | None:
    """Let exports of ``material`` carry ``image`` as occlusion; returns a warning where the artist's own stays."""
    tree = material.node_tree
    unplug_occlusion(tree)
    outputs = [
        node
        for node in tree.nodes
        if node.bl_idname == "ShaderNodeGroup" and node.node_tree and node.node_tree.name == GROUP
    ]
    if any(node.inputs[OCCLUSION].is_linked for node in outputs if OCCLUSION in node.inputs):
        return f"Material '{material.name}' has an occlusion of its own for glTF, which stays: unlink it for the AO map"
    group = _group()  # with it, nodes of the artist's own have the input, too
    if not any(OCCLUSION in node.inputs for node in outputs):
        outputs = [_add(tree, "ShaderNodeGroup", 300.0, -400.0)]
        outputs[0].node_tree = group
    output = next(node for node in outputs if OCCLUSION in node.inputs)
    x, y = output.location
    texture, uv = _add(tree, "ShaderNodeTexImage", x - 320.0, y), _add(tree, "ShaderNodeUVMap", x - 520.0, y)
    texture.image, texture.label, uv.uv_map = image, AO_MAP, uv_map
    tree.links.new(uv.outputs["UV"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], output.inputs[OCCLUSION])
    return None


def unplug_occlusion(tree: bpy.types.NodeTree) -> None:
    """Remove what :func:`plug_occlusion` added."""
    for node in [node for node in tree.nodes if GLTF in node]:
        tree.nodes.remove(node)


def _add(tree: bpy.types.NodeTree, kind: str, x: float, y: float) -> bpy.types.Node:
    node = tree.nodes.new(kind)
    node.location, node.select = (x, y), False
    node[PROPERTY] = node[GLTF] = True
    return node


def _sockets(group: bpy.types.NodeTree) -> list[bpy.types.NodeTreeInterfaceSocket]:
    return [item for item in group.interface.items_tree if item.item_type == "SOCKET"]


def _group() -> bpy.types.NodeTree:
    """The group of the .blend, given the input where it lacks it: exporters know no other name. A new one is as the
    exporter's own menu makes it."""
    group = bpy.data.node_groups.get((GROUP, None))
    if group is None:
        group = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
        group.interface.new_socket(OCCLUSION, socket_type="NodeSocketFloat")
        group.interface.new_socket("Thickness", socket_type="NodeSocketFloat").default_value = 0.0
        for kind in ("NodeGroupInput", "NodeGroupOutput"):
            group.nodes.new(kind)
    elif not any(item.name == OCCLUSION and item.in_out == "INPUT" for item in _sockets(group)):
        group.interface.new_socket(OCCLUSION, socket_type="NodeSocketFloat")
    return group
