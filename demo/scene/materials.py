# SPDX-License-Identifier: GPL-3.0-or-later
"""One ordinary Principled material a stuff: painted colour attribute, fine procedural mottling, roughness."""

import bpy

from .patches import COLOUR_ATTRIBUTE


def add(name: str, grain: float, roughness: float) -> bpy.types.Material:
    """A material whose base colour is the attribute times fine noise; `grain` is the noise's scale in 1/m."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    principled = nodes.new("ShaderNodeBsdfPrincipled")
    principled.inputs["Roughness"].default_value = roughness
    links.new(principled.outputs["BSDF"], output.inputs["Surface"])

    colour = nodes.new("ShaderNodeAttribute")
    colour.attribute_name = COLOUR_ATTRIBUTE
    coordinates = nodes.new("ShaderNodeTexCoord")
    noise = nodes.new("ShaderNodeTexNoise")
    noise.inputs["Scale"].default_value = grain
    noise.inputs["Detail"].default_value = 2
    links.new(coordinates.outputs["Object"], noise.inputs["Vector"])
    tone = nodes.new("ShaderNodeMapRange")
    tone.inputs["From Min"].default_value = 0.25
    tone.inputs["From Max"].default_value = 0.75
    tone.inputs["To Min"].default_value = 0.94
    tone.inputs["To Max"].default_value = 1.02
    links.new(noise.outputs[0], tone.inputs["Value"])
    scale = nodes.new("ShaderNodeVectorMath")
    scale.operation = "SCALE"
    links.new(colour.outputs["Color"], scale.inputs[0])
    links.new(tone.outputs["Result"], scale.inputs["Scale"])
    links.new(scale.outputs["Vector"], principled.inputs["Base Color"])
    for x, node in enumerate((coordinates, noise, tone, scale, principled, output)):
        node.location = (x * 220 - 900, 0)
    colour.location = (-460, 260)
    return material
