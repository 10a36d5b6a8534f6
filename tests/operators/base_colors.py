# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose base colours are known, and what is read of them."""

from __future__ import annotations

import bpy
import numpy as np

from .bakes import attribute, operators, select
from .materials import bsdf, material
from .meshes import corner_vertices

GREY = 0.8
TINT, OTHER = (0.9, 0.5, 0.3, 1), (0.1, 0.6, 0.2, 1)


def read_albedo(*objects):
    """Albedo and warnings."""
    bpy.context.view_layer.update()
    return operators("base_color").read_albedo(bpy.context.evaluated_depsgraph_get(), set(objects))


def middles(*objects):
    """(m, 3): the colour of each triangle's middle."""
    albedo, warnings = read_albedo(*objects)
    assert warnings == []
    third = np.full(len(albedo), 1 / 3)
    return albedo.at(np.arange(len(albedo)), third, third)


def by_cycles(obj):
    """(corners, 3): the diffuse colour that Cycles gives the corners of ``obj``."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    colours = obj.data.color_attributes.get("Cycles") or obj.data.color_attributes.new(
        "Cycles", "FLOAT_COLOR", "CORNER"
    )
    obj.data.color_attributes.active_color = colours
    select(obj)
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"COLOR"}, target="VERTEX_COLORS")
    return attribute(obj, "Cycles")[:, :3]


def matte(name="Matte", colour=(0.8, 0.4, 0.2, 1.0)):
    """A Principled BSDF without the gloss that takes light from its diffuse colour."""
    made = material(name, colour)
    bsdf(made).inputs["Specular IOR Level"].default_value = 0
    return made


def image(pixels, name="Image", is_float=True, space=None):
    """Of ``pixels`` (h, w, 3 or 4), bottom row first; alpha is 1 where there is none."""
    pixels = np.asarray(pixels, np.float32)
    height, width, channels = pixels.shape
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    if space:
        made.colorspace_settings.name = space
    made.pixels.foreach_set(rgba.ravel())
    return made


def image_node(tree, shown, extension="EXTEND"):
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.extension = shown, extension
    return node


def paint(mesh, vertex_colours, name="Paint", kind="FLOAT_COLOR", domain="POINT"):
    """A colour attribute of linear ``vertex_colours`` (n, 3)."""
    colours = mesh.color_attributes.new(name, kind, domain)
    values = np.column_stack((vertex_colours, np.ones(len(vertex_colours))))
    values = values if domain == "POINT" else values[corner_vertices(mesh)]
    colours.data.foreach_set("color", values.astype(np.float32).ravel())
    return colours


def painted_material(name="Paint"):
    made = matte("Painted")
    node = made.node_tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = name
    made.node_tree.links.new(node.outputs["Color"], bsdf(made).inputs["Base Color"])
    return made


def mixed(tree, shader, kind, blend, factor, first, second):
    """A Mix node of outputs or colours into the base colour."""
    node = tree.nodes.new(kind)
    node.blend_type = blend
    if kind == "ShaderNodeMix":
        node.data_type = "RGBA"
    names = {"ShaderNodeMix": ("Factor_Float", "A_Color", "B_Color"), "ShaderNodeMixRGB": ("Fac", "Color1", "Color2")}
    sockets = [next(s for s in node.inputs if s.identifier == name) for name in names[kind]]
    for socket, value in zip(sockets, (factor, first, second), strict=True):
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    tree.links.new(next(s for s in node.outputs if s.enabled), shader)
