# SPDX-License-Identifier: GPL-3.0-or-later
"""AO fields in one material: their product darkens the base colour of every Principled BSDF, and out again."""

from __future__ import annotations

from collections.abc import Collection

import bpy

from ..shader_nodes.ao_field import object_of
from .field_record import FIELD

# Set on a material whose nodes were off before we came.
_NODES_WERE_OFF = "multibounce_ao_field_nodes_were_off"
_MIX_INPUTS = ("Factor_Float", "A_Color", "B_Color")


def can_receive(material: bpy.types.Material) -> bool:
    """Whether ``material`` has a Principled BSDF, or gets one because its nodes were never on."""
    return material.node_tree is None or bool(_shaders(material.node_tree))


def fields_in(material: bpy.types.Material) -> list[bpy.types.Node]:
    """Our field groups in ``material``, in the order in which they came."""
    nodes = material.node_tree.nodes if material.node_tree else ()
    return [node for node in nodes if FIELD in node and node.bl_idname == "ShaderNodeGroup"]


def is_field_mix(node: bpy.types.Node) -> bool:
    """Whether ``node`` is ours, and multiplies a base colour with what fields leave of the light."""
    return FIELD in node and node.bl_idname == "ShaderNodeMix"


def mix_sockets(mix: bpy.types.Node) -> tuple[bpy.types.NodeSocket, ...]:
    """Factor, A and B."""
    return tuple(next(s for s in mix.inputs if s.identifier == name) for name in _MIX_INPUTS)


def receive(material: bpy.types.Material, group: bpy.types.ShaderNodeTree) -> None:
    """Darken ``material`` by the field ``group``, beside those it has. One that is there already stays."""
    _turn_nodes_on(material)
    tree = material.node_tree
    if not any(node.node_tree == group for node in fields_in(material)):
        node = _new_node(tree, "ShaderNodeGroup", object_of(group).name)
        node.node_tree = group
        node.width = 200
    for bsdf in _shaders(tree):
        if _mix_before(bsdf) is None:
            _insert_mix(tree, bsdf)
    _multiply(tree, fields_in(material))


def release(material: bpy.types.Material, groups: Collection[bpy.types.ShaderNodeTree] | None = None) -> bool:
    """Take the fields ``groups``, None: all, out of ``material``, also those that nothing is left of. Returns whether
    any field remains; with none, the BSDF gets back what fed it, or its colour as it now is."""
    tree = material.node_tree
    if tree is None:
        return False
    for node in fields_in(material):
        if groups is None or node.node_tree is None or node.node_tree in groups:
            tree.nodes.remove(node)
    fields = fields_in(material)
    if fields:
        _multiply(tree, fields)
        return True
    for mix in [node for node in tree.nodes if is_field_mix(node)]:
        _bypass(tree, mix)
    for node in [node for node in tree.nodes if FIELD in node]:
        tree.nodes.remove(node)
    if _NODES_WERE_OFF in material:
        material.use_nodes = False
        del material[_NODES_WERE_OFF]
    return False


def _shaders(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled"]


def _mix_result(mix: bpy.types.Node) -> bpy.types.NodeSocket:
    return next(socket for socket in mix.outputs if socket.identifier == "Result_Color")


def _mix_before(bsdf: bpy.types.Node) -> bpy.types.Node | None:
    """Our mix among all that feeds the base colour: the artist may have put nodes between."""
    sockets, seen = [bsdf.inputs["Base Color"]], set()
    while sockets:
        for link in sockets.pop().links:
            node = link.from_node
            if is_field_mix(node):
                return node
            if node not in seen:
                seen.add(node)
                sockets += node.inputs
    return None


def _insert_mix(tree: bpy.types.NodeTree, bsdf: bpy.types.Node) -> None:
    """Base colour times what the fields leave of the light, last before the shader: bounces know the plain colour."""
    socket = bsdf.inputs["Base Color"]
    mix = _new_node(tree, "ShaderNodeMix", "Base Color * AO")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    mix.location = (bsdf.location.x - 220, bsdf.location.y)
    factor, base_color, _ = mix_sockets(mix)
    factor.default_value = 1.0
    base_color.default_value = socket.default_value
    if socket.is_linked:
        link = socket.links[0]
        muted = link.is_muted
        tree.links.new(link.from_socket, base_color).is_muted = muted
    tree.links.new(_mix_result(mix), socket)


def _multiply(tree: bpy.types.NodeTree, fields: list[bpy.types.Node]) -> None:
    """Link the product of all ``fields`` into every mix, and lay them out below."""
    for node in [node for node in tree.nodes if FIELD in node and node.bl_idname == "ShaderNodeMath"]:
        tree.nodes.remove(node)
    mixes = [node for node in tree.nodes if is_field_mix(node)]
    if not mixes:
        return
    x = min(mix.location.x for mix in mixes) - 240
    y = min(mix.location.y for mix in mixes) - 240
    product = None
    for index, node in enumerate(fields):
        node.location = (x - 220, y - 160 * index)
        if product is None:
            product = node.outputs["AO"]
            continue
        times = _new_node(tree, "ShaderNodeMath", "AO * AO")
        times.operation = "MULTIPLY"
        times.location = (x, y - 160 * (index - 1))
        tree.links.new(product, times.inputs[0])
        tree.links.new(node.outputs["AO"], times.inputs[1])
        product = times.outputs[0]
    for mix in mixes:
        tree.links.new(product, mix_sockets(mix)[2])


def _bypass(tree: bpy.types.NodeTree, mix: bpy.types.Node) -> None:
    """What feeds ``mix`` feeds all that read it; without a link they get its colour."""
    base_color = mix_sockets(mix)[1]
    for link in list(_mix_result(mix).links):
        if base_color.is_linked:
            source = base_color.links[0]
            muted = source.is_muted
            tree.links.new(source.from_socket, link.to_socket).is_muted = muted
        else:
            _replace_by_colour(tree, link, base_color.default_value)


def _replace_by_colour(tree: bpy.types.NodeTree, link: bpy.types.NodeLink, colour) -> None:
    """Remove ``link``; its end gets ``colour``. A reroute has none to pass on, so there it goes to what is behind."""
    target = link.to_socket
    if link.to_node.bl_idname == "NodeReroute":
        for behind in list(link.to_node.outputs[0].links):
            _replace_by_colour(tree, behind, colour)
    elif target.type == "RGBA":
        target.default_value = colour
    tree.links.remove(link)


def _new_node(tree: bpy.types.NodeTree, kind: str, label: str) -> bpy.types.Node:
    node = tree.nodes.new(kind)
    node.label = label
    node.select = False
    node[FIELD] = True
    return node


def _turn_nodes_on(material: bpy.types.Material) -> None:
    """Before 5.0 a material could do without nodes: it then shows its viewport colour, which the new BSDF takes
    over."""
    if bpy.app.version >= (5, 0, 0) or material.use_nodes:
        return
    material.use_nodes = True
    material[_NODES_WERE_OFF] = True
    for bsdf in _shaders(material.node_tree):
        bsdf.inputs["Base Color"].default_value = material.diffuse_color
