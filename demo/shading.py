# SPDX-License-Identifier: GPL-3.0-or-later
"""Rewires the baked materials for the pictures: to emit the ambient light, or to be lit by lamps or the World."""

from collections.abc import Iterator
from dataclasses import dataclass

import bpy

FLAT_AOV = "Flat"
GREY_AOV = "Grey AO"
FIELD_AOV = "With Field"
GROUP_OUTPUTS = {"Color", "Factor", "AO"}


@dataclass
class Tap:
    """One baked material: its nodes, the group that `bake` plugged in, and what feeds the group's base colour."""

    tree: bpy.types.NodeTree
    group: bpy.types.Node
    base_color: bpy.types.NodeSocket
    principled: bpy.types.Node
    surface: bpy.types.NodeSocket


def _is_multibounce(node: bpy.types.Node) -> bool:
    return node.type == "GROUP" and {output.name for output in node.outputs} >= GROUP_OUTPUTS


def taps() -> Iterator[Tap]:
    """Every baked material. One group and one Principled BSDF in each is what the scene's materials have."""
    for material in bpy.data.materials:
        nodes = list(material.node_tree.nodes) if material.node_tree else []
        for group in filter(_is_multibounce, nodes):
            by_type = {node.type: node for node in nodes}
            yield Tap(
                material.node_tree,
                group,
                group.inputs["Base Color"].links[0].from_socket,
                by_type["BSDF_PRINCIPLED"],
                by_type["OUTPUT_MATERIAL"].inputs["Surface"],
            )


def _output_aov(tap: Tap, name: str, color: bpy.types.NodeSocket) -> None:
    aov = tap.tree.nodes.new("ShaderNodeOutputAOV")
    aov.aov_name = name
    tap.tree.links.new(color, aov.inputs["Color"])


def show_ambient() -> None:
    """Emit the group's colour: light of a uniform white World of radiance 1, occluded, with bounces.

    Beside it as AOVs: the same without any occlusion, with the grey AO alone, and darkened by AO fields too.
    """
    for name in (FLAT_AOV, GREY_AOV, FIELD_AOV):
        bpy.context.view_layer.aovs.add().name = name
    for tap in taps():
        emission = tap.tree.nodes.new("ShaderNodeEmission")
        tap.tree.links.new(tap.group.outputs["Color"], emission.inputs["Color"])
        tap.tree.links.new(emission.outputs["Emission"], tap.surface)
        dimmed = tap.tree.nodes.new("ShaderNodeVectorMath")
        dimmed.operation = "SCALE"
        tap.tree.links.new(tap.base_color, dimmed.inputs[0])
        tap.tree.links.new(tap.group.outputs["AO"], dimmed.inputs["Scale"])
        _output_aov(tap, FLAT_AOV, tap.base_color)
        _output_aov(tap, GREY_AOV, dimmed.outputs["Vector"])
        _output_aov(tap, FIELD_AOV, tap.principled.inputs["Base Color"].links[0].from_socket)


def show_diffuse() -> None:
    """A plain Lambertian of the base colour: what the path-traced reference and the bake both assume."""
    for tap in taps():
        diffuse = tap.tree.nodes.new("ShaderNodeBsdfDiffuse")
        tap.tree.links.new(tap.base_color, diffuse.inputs["Color"])
        tap.tree.links.new(diffuse.outputs["BSDF"], tap.surface)


def show_principled() -> None:
    """The artist's own shader without the AO, for direct light from a lamp."""
    for tap in taps():
        tap.tree.links.new(tap.base_color, tap.principled.inputs["Base Color"])
        tap.tree.links.new(tap.principled.outputs["BSDF"], tap.surface)
