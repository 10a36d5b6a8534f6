# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes before the Base Color of a material's Principled BSDFs: put in, found again, and taken out without a trace.

What a bake plugs in and what AO fields plug in stand in the same place, and each comes and goes by itself: the bake's
group first, because it wants the plain base colour, then the fields' multiplication. An ID property tells which nodes
are whose.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy

from .field_record import FIELD
from .names import PROPERTY

# Set on a material whose nodes were off before we came.
_NODES_WERE_OFF = "multibounce_ao_nodes_were_off"
# Identifiers of a colour Mix node's sockets: several have the same name.
_MIX_INPUTS = ("Factor_Float", "A_Color", "B_Color")


def can_plug(material: bpy.types.Material) -> bool:
    """Whether ``material`` has a Principled BSDF, or gets one because its nodes were never on."""
    return material.node_tree is None or bool(shaders(material.node_tree))


def shaders(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled"]


def turn_nodes_on(material: bpy.types.Material) -> None:
    """Before 5.0 a material could do without nodes: it then shows its viewport colour, which the new BSDF takes
    over."""
    if bpy.app.version >= (5, 0, 0) or material.use_nodes:
        return
    material.use_nodes = True
    material[_NODES_WERE_OFF] = True
    for bsdf in shaders(material.node_tree):
        bsdf.inputs["Base Color"].default_value = material.diffuse_color


def turn_nodes_back_off(material: bpy.types.Material) -> None:
    """Undo :func:`turn_nodes_on`, unless nodes of ours are left."""
    if _NODES_WERE_OFF in material and not any(PROPERTY in node or FIELD in node for node in material.node_tree.nodes):
        material.use_nodes = False
        del material[_NODES_WERE_OFF]


def new_node(tree: bpy.types.NodeTree, kind: str, owner: str, x: float, y: float) -> bpy.types.Node:
    """A node at (x, y) that is ours by the ID property ``owner``."""
    node = tree.nodes.new(kind)
    node.location = (x, y)
    node.select = False
    node[owner] = True
    return node


def mix_sockets(mix: bpy.types.Node) -> tuple[bpy.types.NodeSocket, ...]:
    """Factor, A, B and Result of a Mix node of colours."""
    inputs = (next(s for s in mix.inputs if s.identifier == name) for name in _MIX_INPUTS)
    return *inputs, next(s for s in mix.outputs if s.identifier == "Result_Color")


def upstream(socket: bpy.types.NodeSocket, is_wanted: Callable[[bpy.types.Node], bool]) -> bpy.types.Node | None:
    """The first node that ``is_wanted`` among all that feeds ``socket``: the artist may have put nodes between."""
    sockets, seen = [socket], set()
    while sockets:
        for link in sockets.pop().links:
            node = link.from_node
            if is_wanted(node):
                return node
            if node not in seen:
                seen.add(node)
                sockets += node.inputs
    return None


def insert(
    tree: bpy.types.NodeTree,
    socket: bpy.types.NodeSocket,
    base_color: bpy.types.NodeSocket,
    result: bpy.types.NodeSocket,
) -> None:
    """What ``socket`` had, link and colour, goes to ``base_color``, an input of the node whose output ``result`` feeds
    ``socket`` from now on."""
    base_color.default_value = socket.default_value
    if socket.is_linked:
        _pass_on(tree, socket.links[0], base_color)
    tree.links.new(result, socket)


def bypass(tree: bpy.types.NodeTree, base_color: bpy.types.NodeSocket, result: bpy.types.NodeSocket) -> None:
    """Undo :func:`insert`: what feeds ``base_color`` feeds all that reads ``result``; without a link they get its
    colour."""
    for link in list(result.links):
        if base_color.is_linked:
            _pass_on(tree, base_color.links[0], link.to_socket)
        else:
            _replace_by_colour(tree, link, base_color.default_value)


def _pass_on(tree: bpy.types.NodeTree, link: bpy.types.NodeLink, socket: bpy.types.NodeSocket) -> None:
    """Link what ``link`` comes from to ``socket``, muted as it is."""
    muted = link.is_muted
    tree.links.new(link.from_socket, socket).is_muted = muted


def _replace_by_colour(tree: bpy.types.NodeTree, link: bpy.types.NodeLink, colour: Sequence[float]) -> None:
    """Remove ``link``; its end gets ``colour``. A reroute has none to pass on, so there it goes to what is behind."""
    target = link.to_socket
    if link.to_node.bl_idname == "NodeReroute":
        for behind in list(link.to_node.outputs[0].links):
            _replace_by_colour(tree, behind, colour)
    elif target.type == "RGBA":
        target.default_value = colour
    tree.links.remove(link)
