# SPDX-License-Identifier: GPL-3.0-or-later
"""core.multibounce.surface_curve as a node group, in the extension's own way of building them."""

import importlib

import bpy

NAME = "Surface Curve"


def curve_group(package: str) -> bpy.types.ShaderNodeTree:
    """E = k + albedo (1 - k) k' / (1 - albedo (1 - k')) with k' = sqrt(k openness), times the base colour."""
    expression, group, shading = (
        importlib.import_module(f"{package}.shader_nodes.{name}") for name in ("expression", "group", "shading")
    )

    def build(tree: bpy.types.ShaderNodeTree) -> None:
        graph = expression.Graph(tree)
        k, albedo = graph.input("k_A"), graph.input("Base Color")
        others = ((k * graph.input("Openness")) ** 0.5).named("k'")
        bounced = others / (1 - albedo * (1 - others))
        shading.shade(graph, k + albedo * (1 - k) * bounced)
        graph.arrange()

    inputs = (group.Socket("k_A", "NodeSocketFloat", "F0"), group.Socket("Openness", "NodeSocketFloat", "Mean of k_A"))
    inputs += (shading.BASE_COLOR, shading.IRRADIANCE)
    return group.ensure_group(NAME, 1, inputs, (shading.COLOR, shading.FACTOR), build)
