# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of the bounced light as shader nodes: each multiplies the base colour by E/E0, into a pass of its own."""

import importlib
from dataclasses import dataclass

import bpy

from .subjects import Albedo


@dataclass(frozen=True)
class Model:
    """`title` is for pictures and tables; `name` is the pass that it is rendered into."""

    name: str
    title: str
    knows: str


MODELS = (
    Model("None", "No bounces", "k_A, which is plain AO"),
    Model("Published", "Published fit", "alpha, the uniform visibility"),
    Model("Curve", "Surface curve", "k_A, and one number for the whole scene"),
    Model("Baked", "Baked channels", "F0, F1, F2 and T, measured"),
    Model("Radiosity", "Radiosity", "E/E0 in RGB, measured in the colors that all has at the bake"),
)


class Shaders:
    """The models in the materials of baked objects: the extension's own groups, fed by what it baked.

    package   name of the extension's
    albedo    the base colours
    textured  the objects that were baked to images; each has a material of its own
    openness  of the scene (core.multibounce.surface_openness)
    """

    def __init__(self, package: str, albedo: Albedo, textured: list[bpy.types.Object], openness: float) -> None:
        self._package = package
        self._openness = openness
        self._owners = {obj.data.materials[0]: obj for obj in textured}
        # By material: its surface's socket, and what can shine there.
        self._surfaces: dict[bpy.types.Material, bpy.types.NodeSocket] = {}
        self._diffuse: dict[bpy.types.Material, bpy.types.NodeSocket] = {}
        self._principled: dict[bpy.types.Material, bpy.types.NodeSocket] = {}
        for model in MODELS:
            bpy.context.view_layer.aovs.add().name = model.name
        for material, base_color in albedo.sockets.items():
            self._keep(material, base_color)
            for name, colour in self._colours(material, base_color).items():
                aov = material.node_tree.nodes.new("ShaderNodeOutputAOV")
                aov.aov_name = name
                material.node_tree.links.new(colour, aov.inputs["Color"])

    def show_diffuse(self) -> None:
        """Lambertian surfaces of the base colours: what is path traced."""
        self._show(self._diffuse)

    def show_principled(self) -> None:
        """The scene's own shaders: radiosity bakes read the base colours from them."""
        self._show(self._principled)

    def _show(self, shaders: dict[bpy.types.Material, bpy.types.NodeSocket]) -> None:
        for material, surface in self._surfaces.items():
            material.node_tree.links.new(shaders[material], surface)

    def _keep(self, material: bpy.types.Material, base_color: bpy.types.NodeSocket) -> None:
        tree = material.node_tree
        by_type = {node.type: node for node in tree.nodes}
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        tree.links.new(base_color, diffuse.inputs["Color"])
        self._surfaces[material] = by_type["OUTPUT_MATERIAL"].inputs["Surface"]
        self._diffuse[material] = diffuse.outputs["BSDF"]
        self._principled[material] = by_type["BSDF_PRINCIPLED"].outputs["BSDF"]

    def _colours(
        self, material: bpy.types.Material, base_color: bpy.types.NodeSocket
    ) -> dict[str, bpy.types.NodeSocket]:
        """The shade by each model, by the model's name."""
        tree = material.node_tree

        def group(node_tree: bpy.types.NodeTree, **inputs) -> bpy.types.Node:
            node = tree.nodes.new("ShaderNodeGroup")
            node.node_tree = node_tree
            for name, source in {"Base Color": base_color, **inputs}.items():
                tree.links.new(source, node.inputs[name])
            return node

        bounces, cone = self._source(material, "Multibounce AO"), self._source(material, "Bent Cone")
        radiosity = self._source(material, "Multibounce Radiosity")
        baked = group(self._group("multibounce_ao"), Bounces=bounces["Color"], Tail=bounces["Alpha"])
        curve = group(self._group("multibounce_curve"), AO=baked.outputs["AO"])
        curve.inputs["Openness"].default_value = self._openness
        shaded = {
            "Published": group(self._group("multibounce_fit"), AO=cone["Alpha"]),
            "Curve": curve,
            "Baked": baked,
            "Radiosity": group(self._group("multibounce_radiosity"), Radiosity=radiosity["Color"]),
        }
        dimmed = tree.nodes.new("ShaderNodeVectorMath")
        dimmed.operation = "SCALE"
        tree.links.new(base_color, dimmed.inputs[0])
        tree.links.new(baked.outputs["AO"], dimmed.inputs["Scale"])
        return {"None": dimmed.outputs["Vector"]} | {name: node.outputs["Color"] for name, node in shaded.items()}

    def _group(self, name: str) -> bpy.types.NodeTree:
        return importlib.import_module(f"{self._package}.shader_nodes.{name}").ensure()

    def _source(self, material: bpy.types.Material, channel: str) -> bpy.types.bpy_prop_collection:
        """Outputs of a node that reads a baked attribute, or the image of the material's owner."""
        tree = material.node_tree
        if material not in self._owners:
            node = tree.nodes.new("ShaderNodeAttribute")
            node.attribute_name = channel
            return node.outputs
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images[f"{self._owners[material].name} {channel}"]
        node.extension = "EXTEND"
        return node.outputs
