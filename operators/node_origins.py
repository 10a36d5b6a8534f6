# SPDX-License-Identifier: GPL-3.0-or-later
"""What feeds a socket of a material's nodes."""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from .field_nodes import is_field_mix
from .material_tree import mix_sockets

Groups = tuple[bpy.types.Node, ...]  # the group nodes that a socket lies within, innermost first


class UnreadableError(Exception):
    """A base colour that only a renderer finds. The message says where it comes from; ``remedy``, what to do."""

    def __init__(self, origin: str, remedy: str = "bake the color to an image or a color attribute"):
        super().__init__(origin)
        self.remedy = remedy


def origin_of(socket: bpy.types.NodeSocket, groups: Groups) -> tuple[bpy.types.NodeSocket, Groups]:
    """The output that feeds the input ``socket``, or the unlinked input whose value does: through reroutes, muted
    nodes, what AO fields take away, and the artist's groups, into them and out."""
    while True:
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None:
            return socket, groups
        output, node = link.from_socket, link.from_node
        if node.mute:
            inside = next((inside for inside in node.internal_links if inside.to_socket == output), None)
            if inside is None:
                raise UnreadableError(f"the muted node '{node.name}'", "connect the base color itself")
            socket = inside.from_socket
        elif node.bl_idname == "NodeReroute":
            socket = node.inputs[0]
        elif is_field_mix(node):
            socket = mix_sockets(node)[1]
        elif node.bl_idname == "NodeGroupInput" and groups:
            socket, groups = _same_socket(groups[0].inputs, output), groups[1:]
        elif node.bl_idname == "ShaderNodeGroup" and not is_our_group(node):
            ends = node.node_tree.nodes if node.node_tree else ()
            end = next((end for end in ends if end.bl_idname == "NodeGroupOutput" and end.is_active_output), None)
            if end is None:
                raise UnreadableError(f"the empty group '{node.name}'")
            socket, groups = _same_socket(end.inputs, output), (node, *groups)
        else:
            return output, groups


def _same_socket(sockets: Iterable[bpy.types.NodeSocket], socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    return next(each for each in sockets if each.identifier == socket.identifier)


def is_our_group(node: bpy.types.Node) -> bool:
    """Ours by its sockets, which no other has: artists may have put it there by hand."""
    return (
        node.bl_idname == "ShaderNodeGroup"
        and {"Base Color", "Irradiance"} <= {socket.name for socket in node.inputs}
        and {"Color", "Factor"} <= {socket.name for socket in node.outputs}
    )
