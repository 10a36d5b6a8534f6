# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group in one material: between what feeds a Principled BSDF's Base Color and that socket, and out again."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import bpy

from ..shader_nodes import bent_cone, multibounce_ao, multibounce_curve, multibounce_fit, multibounce_radiosity
from .field_nodes import is_field_mix
from .gltf_occlusion import GLTF
from .material_tree import bypass, insert, mix_sockets, new_node, shaders, turn_nodes_back_off, turn_nodes_on, upstream
from .names import BENT_CONE, MULTIBOUNCE_AO, PROPERTY, RADIOSITY

# For each kind of bounces, and for the curve, which takes the F0 of either bake: the group, and which channel's output
# feeds which of its inputs.
GROUPS = {
    "FITTED": (multibounce_fit, {"AO": (BENT_CONE, "Alpha")}),
    "BAKED": (multibounce_ao, {"Bounces": (MULTIBOUNCE_AO, "Color"), "Tail": (MULTIBOUNCE_AO, "Alpha")}),
    "RADIOSITY": (multibounce_radiosity, {"Radiosity": (RADIOSITY, "Color")}),
    "CURVE": (multibounce_curve, {"AO": (MULTIBOUNCE_AO, "Red")}),
    "CURVE_OF_RADIOSITY": (multibounce_curve, {"AO": (RADIOSITY, "Alpha")}),
}
# The same for the group that brings the World's light to those.
WORLD_LIGHT = {"Bent Cone": (BENT_CONE, "Color"), "Alpha": (BENT_CONE, "Alpha")}
# What a mesh without the attribute shows instead, as open.
OPEN = {MULTIBOUNCE_AO: (1.0, 0.0, 0.0, 1.0), RADIOSITY: (1.0, 1.0, 1.0, 1.0)}

# Set on the node that brings the World's light.
_WORLD_LIGHT = "multibounce_ao_world_light"


@dataclass(frozen=True)
class BakedSource:
    """Where a material finds what was baked: the mesh's attributes, or ``images`` by channel through ``uv_map``."""

    images: dict[str, bpy.types.Image] | None = None
    uv_map: str = ""


def plug(material: bpy.types.Material, bounces: str, source: BakedSource | None) -> None:
    """Put the group for ``bounces`` before every Principled BSDF of ``material``, fed from ``source`` if there is one.

    Groups that are there already keep their place; they get the new source, and without one keep theirs.
    """
    turn_nodes_on(material)
    tree = material.node_tree
    module, inputs = GROUPS[bounces]
    group_tree = module.ensure()
    groups = []
    for bsdf in shaders(tree):
        group = upstream(bsdf.inputs["Base Color"], _is_our_group) or _insert_group(tree, bsdf, group_tree)
        _show(tree, group, group_tree)
        if group not in groups:
            groups.append(group)
    if source is not None:
        _remove_sources(tree)
        _feed(tree, groups, inputs, source)
        for node in _world_lights(tree):
            _feed(tree, [node], WORLD_LIGHT, source)


def add_world_light(material: bpy.types.Material, source: BakedSource) -> bool:
    """Put the light of the bent cone, over that of an open surface, into the ``Irradiance`` of all our groups in
    ``material``; False where there is none. The renderer brings the open surface's light."""
    groups = [group for group in groups_in(material) if "Irradiance" in group.inputs]
    if not groups:
        return False
    tree = material.node_tree
    lights = _world_lights(tree)
    if not lights:
        x, y = min(group.location.x for group in groups) - 260, groups[0].location.y - 560
        light = new_node(tree, "ShaderNodeGroup", PROPERTY, x, y)
        light.node_tree = bent_cone.ensure()
        light.width = 200
        light[_WORLD_LIGHT] = True
        lights = [light]
        _feed(tree, lights, WORLD_LIGHT, source)
    for group in groups:
        tree.links.new(lights[0].outputs["Relative Light"], group.inputs["Irradiance"])
    return True


def unplug(material: bpy.types.Material) -> None:
    """Take our nodes out of ``material``; the BSDF gets back what fed it, or its colour as it now is."""
    tree = material.node_tree
    if tree is None:
        return
    for group in groups_in(material):
        if "Base Color" in group.inputs and "Color" in group.outputs:
            bypass(tree, group.inputs["Base Color"], group.outputs["Color"])
    for node in [node for node in tree.nodes if _is_ours(node)]:
        tree.nodes.remove(node)
    turn_nodes_back_off(material)


def groups_in(material: bpy.types.Material) -> list[bpy.types.Node]:
    """Our groups in ``material``."""
    return [node for node in material.node_tree.nodes if _is_our_group(node)] if material.node_tree else []


def shows(material: bpy.types.Material, images: Collection[bpy.types.Image]) -> bool:
    """Whether our nodes in ``material`` read one of ``images``."""
    tree = material.node_tree
    return tree is not None and any(_is_ours(node) and getattr(node, "image", None) in images for node in tree.nodes)


def _insert_group(tree: bpy.types.NodeTree, bsdf: bpy.types.Node, group_tree: bpy.types.NodeTree) -> bpy.types.Node:
    """Last before the shader, but before what AO fields take away: the bounces are of the plain base colour."""
    socket = bsdf.inputs["Base Color"]
    mix = upstream(socket, is_field_mix)
    if mix is not None:
        _, socket, _, _ = mix_sockets(mix)
    group = new_node(tree, "ShaderNodeGroup", PROPERTY, bsdf.location.x - 260, bsdf.location.y)
    group.node_tree = group_tree
    group.width = 200
    insert(tree, socket, group.inputs["Base Color"], group.outputs["Color"])
    return group


def _show(tree: bpy.types.NodeTree, group: bpy.types.Node, group_tree: bpy.types.NodeTree) -> None:
    """Make ``group`` a node of ``group_tree``. Sockets of the same name keep their links and values; left to itself
    Blender matches them by the order in which they were made, which differs from group to group."""
    if group.node_tree == group_tree:
        return
    values = {s.name: tuple(s.default_value) for s in group.inputs if s.type in {"RGBA", "VECTOR"}}
    values |= {s.name: s.default_value for s in group.inputs if s.type == "VALUE"}
    links = [(s.name, link.from_socket, link.is_muted) for s in group.inputs for link in s.links]
    used = [(s.name, link.to_socket, link.is_muted) for s in group.outputs for link in s.links]
    group.node_tree = None
    group.node_tree = group_tree
    for name, value in values.items():
        if name in group.inputs:
            group.inputs[name].default_value = value
    for name, socket, muted in links:
        if name in group.inputs:
            tree.links.new(socket, group.inputs[name]).is_muted = muted
    for name, socket, muted in used:
        if name in group.outputs:
            tree.links.new(group.outputs[name], socket).is_muted = muted


def _feed(tree: bpy.types.NodeTree, groups: list, inputs: dict[str, tuple[str, str]], source: BakedSource) -> None:
    """Link the baked channels into every group, one source node a channel."""
    x = min(group.location.x for group in groups) - 320
    y = groups[0].location.y - 160
    nodes = {}
    for socket, (channel, output) in inputs.items():
        if channel not in nodes:
            nodes[channel] = _source(tree, channel, source, x, y)
            y -= 300
        if output not in nodes[channel]:
            nodes[channel] |= _separated(tree, nodes[channel]["Color"], x + 160, y + 300)
        for group in groups:
            tree.links.new(nodes[channel][output], group.inputs[socket])


def _separated(
    tree: bpy.types.NodeTree, colour: bpy.types.NodeSocket, x: float, y: float
) -> dict[str, bpy.types.NodeSocket]:
    """Outputs "Red", "Green" and "Blue"."""
    node = new_node(tree, "ShaderNodeSeparateColor", PROPERTY, x, y)
    tree.links.new(colour, node.inputs[0])
    return {socket.name: socket for socket in node.outputs}


def _source(
    tree: bpy.types.NodeTree, channel: str, source: BakedSource, x: float, y: float
) -> dict[str, bpy.types.NodeSocket]:
    """Outputs "Color" and "Alpha" of what was baked."""
    if source.images is None:
        return _attribute(tree, channel, x, y)
    node = new_node(tree, "ShaderNodeTexImage", PROPERTY, x, y)
    node.image = source.images[channel]
    node.extension = "EXTEND"  # the tile's border must not blend with the opposite side
    uv_map = new_node(tree, "ShaderNodeUVMap", PROPERTY, x - 200, y)
    uv_map.uv_map = source.uv_map
    tree.links.new(uv_map.outputs["UV"], node.inputs["Vector"])
    return {name: node.outputs[name] for name in ("Color", "Alpha")}


def _attribute(tree: bpy.types.NodeTree, channel: str, x: float, y: float) -> dict[str, bpy.types.NodeSocket]:
    """A mesh that shares the material but was not baked shows as open.

    What it lacks reads as black with alpha 1. For the cone that is open already. Elsewhere black would be a closed
    point, but whose alpha is below 1 in a bake: T always (core.bounces.decay), and F0 unless all is open.
    """
    node = new_node(tree, "ShaderNodeAttribute", PROPERTY, x, y)
    node.attribute_type = "GEOMETRY"
    node.attribute_name = channel
    if channel not in OPEN:
        return {name: node.outputs[name] for name in ("Color", "Alpha")}
    node.location.x -= 400
    is_baked = new_node(tree, "ShaderNodeMath", PROPERTY, x - 200, y - 160)
    is_baked.operation, is_baked.label = "LESS_THAN", "Is Baked"
    is_baked.inputs[1].default_value = 1.0
    tree.links.new(node.outputs["Alpha"], is_baked.inputs[0])
    mix = new_node(tree, "ShaderNodeMix", PROPERTY, x, y)
    mix.data_type, mix.label = "RGBA", "Baked or Open"
    factor, opened, baked, result = mix_sockets(mix)
    opened.default_value = OPEN[channel]
    tree.links.new(is_baked.outputs[0], factor)
    tree.links.new(node.outputs["Color"], baked)
    return {"Color": result, "Alpha": node.outputs["Alpha"]}


def _is_ours(node: bpy.types.Node) -> bool:
    return PROPERTY in node


def _is_our_group(node: bpy.types.Node) -> bool:
    return _is_ours(node) and node.bl_idname == "ShaderNodeGroup" and _WORLD_LIGHT not in node and GLTF not in node


def _world_lights(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if _is_ours(node) and _WORLD_LIGHT in node]


def _remove_sources(tree: bpy.types.NodeTree) -> None:
    for node in [n for n in tree.nodes if _is_ours(n) and n.bl_idname != "ShaderNodeGroup" and GLTF not in n]:
        tree.nodes.remove(node)
