# SPDX-License-Identifier: GPL-3.0-or-later
"""AO fields in one material: their product darkens the base colour of every Principled BSDF, and out again."""

from __future__ import annotations

from collections.abc import Collection

import bpy

from ..shader_nodes.ao_field import object_of
from .field_record import FIELD
from .material_tree import bypass, insert, mix_sockets, new_node, shaders, turn_nodes_back_off, turn_nodes_on, upstream


def fields_in(material: bpy.types.Material) -> list[bpy.types.Node]:
    """Our field groups in ``material``, in the order in which they came."""
    nodes = material.node_tree.nodes if material.node_tree else ()
    return [node for node in nodes if FIELD in node and node.bl_idname == "ShaderNodeGroup"]


def is_field_mix(node: bpy.types.Node) -> bool:
    """Whether ``node`` is ours, and multiplies a base colour with what fields leave of the light."""
    return FIELD in node and node.bl_idname == "ShaderNodeMix"


def receive(material: bpy.types.Material, group: bpy.types.ShaderNodeTree) -> None:
    """Darken ``material`` by the field ``group``, beside those it has. One that is there already stays; those whose
    object was deleted go."""
    turn_nodes_on(material)
    tree = material.node_tree
    for node in fields_in(material):
        if _is_orphan(node):
            tree.nodes.remove(node)
    if not any(node.node_tree == group for node in fields_in(material)):
        node = new_node(tree, "ShaderNodeGroup", FIELD, 0.0, 0.0)
        node.label = object_of(group).name
        node.node_tree = group
        node.width = 200
    for bsdf in shaders(tree):
        if upstream(bsdf.inputs["Base Color"], is_field_mix) is None:
            _insert_mix(tree, bsdf)
    _multiply(tree, fields_in(material))


def release(material: bpy.types.Material, groups: Collection[bpy.types.ShaderNodeTree] | None = None) -> None:
    """Take the fields ``groups``, None: all, out of ``material``, also those whose object was deleted. When none
    remains, the BSDF gets back what fed it, or its colour as it now is."""
    tree = material.node_tree
    if tree is None:
        return
    for node in fields_in(material):
        if groups is None or node.node_tree in groups or _is_orphan(node):
            tree.nodes.remove(node)
    fields = fields_in(material)
    if fields:
        _multiply(tree, fields)
        return
    for mix in [node for node in tree.nodes if is_field_mix(node)]:
        _, base_color, _, result = mix_sockets(mix)
        bypass(tree, base_color, result)
    for node in [node for node in tree.nodes if FIELD in node]:
        tree.nodes.remove(node)
    turn_nodes_back_off(material)


def _is_orphan(node: bpy.types.Node) -> bool:
    """Whether the object whose field ``node`` is was deleted: Blender keeps it as long as the group refers to it."""
    obj = object_of(node.node_tree) if node.node_tree is not None else None
    return obj is None or not obj.users_collection


def _insert_mix(tree: bpy.types.NodeTree, bsdf: bpy.types.Node) -> None:
    """Base colour times what the fields leave of the light, last before the shader: bounces know the plain colour.
    Above the row in which the base colour's own nodes stand."""
    mix = new_node(tree, "ShaderNodeMix", FIELD, bsdf.location.x - 220, bsdf.location.y + 260)
    mix.label = "Base Color * AO"
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    factor, base_color, _, result = mix_sockets(mix)
    factor.default_value = 1.0
    insert(tree, bsdf.inputs["Base Color"], base_color, result)


def _multiply(tree: bpy.types.NodeTree, fields: list[bpy.types.Node]) -> None:
    """Link the product of all ``fields`` into every mix, and lay them out beside it, upwards."""
    for node in [node for node in tree.nodes if FIELD in node and node.bl_idname == "ShaderNodeMath"]:
        tree.nodes.remove(node)
    mixes = [node for node in tree.nodes if is_field_mix(node)]
    if not mixes:
        return
    x = min(mix.location.x for mix in mixes) - 240
    y = max(mix.location.y for mix in mixes)
    product = None
    for index, node in enumerate(fields):
        node.location = (x - 220, y + 200 * index)
        if product is None:
            product = node.outputs["AO"]
            continue
        times = new_node(tree, "ShaderNodeMath", FIELD, x, y + 200 * index)
        times.label, times.operation = "AO * AO", "MULTIPLY"
        tree.links.new(product, times.inputs[0])
        tree.links.new(node.outputs["AO"], times.inputs[1])
        product = times.outputs[0]
    for mix in mixes:
        tree.links.new(product, mix_sockets(mix)[2])
