# SPDX-License-Identifier: GPL-3.0-or-later
"""Base colours that nodes give, against those that Cycles shows."""

import bpy
import numpy as np
import pytest

from .base_colors import (
    OTHER,
    TINT,
    by_cycles,
    image,
    image_node,
    matte,
    mixed,
    paint,
    painted_material,
    read_albedo,
)
from .materials import bsdf
from .meshes import add_mesh


def group_of(tree, shader, build):
    """An artist's group: ``build`` fills it between its input "In" and its output."""
    inner = bpy.data.node_groups.new("Artist's", "ShaderNodeTree")
    inner.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
    inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    build(inner, inner.nodes.new("NodeGroupInput").outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = inner
    tree.links.new(node.outputs[0], shader)
    return node


def build_plain(tree, base, texture, colours):
    base.default_value = TINT


def build_image(tree, base, texture, colours):
    tree.links.new(texture.outputs[0], base)


def build_attribute(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = "Paint"
    tree.links.new(node.outputs["Color"], base)


def build_active_colours(tree, base, texture, colours):
    tree.links.new(tree.nodes.new("ShaderNodeVertexColor").outputs["Color"], base)


def build_missing_attribute(tree, base, texture, colours):
    colours.layer_name = "Nothing"
    tree.links.new(colours.outputs["Color"], base)


def build_vector_attribute(tree, base, texture, colours):
    colours.layer_name = "Vector"
    tree.links.new(colours.outputs["Color"], base)


def build_face_attribute(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = "Faces"
    tree.links.new(node.outputs["Color"], base)


def build_other_uv_map(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeUVMap")
    node.uv_map = "Other"
    tree.links.new(node.outputs[0], texture.inputs[0])
    tree.links.new(texture.outputs[0], base)


def build_missing_uv_map(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeUVMap")
    node.uv_map = "Nothing"
    tree.links.new(node.outputs[0], texture.inputs[0])
    tree.links.new(texture.outputs[0], base)


def mapping(kind):
    def build(tree, base, texture, colours):
        node = tree.nodes.new("ShaderNodeMapping")
        node.vector_type = kind
        node.inputs[1].default_value = (0.13, -0.31, 0.7)  # not to be had by its name where it is hidden
        node.inputs["Rotation"].default_value = (0.2, -0.4, 0.9)
        node.inputs["Scale"].default_value = (1.7, 0.6, 1.3)
        second = tree.nodes.new("ShaderNodeMapping")
        second.inputs["Rotation"].default_value = (-0.7, 0.3, 0.1)
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], node.inputs["Vector"])
        tree.links.new(node.outputs[0], second.inputs["Vector"])
        tree.links.new(second.outputs[0], texture.inputs[0])
        tree.links.new(texture.outputs[0], base)

    build.__name__ = f"build_mapping_{kind.lower()}"
    return build


def extension(kind):
    def build(tree, base, texture, colours):
        mapping("POINT")(tree, base, texture, colours)
        texture.extension = kind
        for node in tree.nodes:
            if node.bl_idname == "ShaderNodeMapping":
                node.inputs["Scale"].default_value = (3.7, 2.6, 1)

    build.__name__ = f"build_{kind.lower()}"
    return build


def closest(kind):
    def build(tree, base, texture, colours):
        extension(kind)(tree, base, texture, colours)
        texture.interpolation = "Closest"

    build.__name__ = f"build_closest_{kind.lower()}"
    return build


def mix(kind, blend, factor, first, second):
    def build(tree, base, texture, colours):
        places = {"image": texture.outputs[0], "paint": colours.outputs["Color"]}
        mixed(tree, base, kind, blend, factor, places.get(first, first), places.get(second, second))

    build.__name__ = f"build_{kind[10:]}_{blend}_{factor}_{'first' if isinstance(first, str) else 'second'}"
    return build


def build_reroutes(tree, base, texture, colours):
    first, second = tree.nodes.new("NodeReroute"), tree.nodes.new("NodeReroute")
    tree.links.new(texture.outputs[0], first.inputs[0])
    tree.links.new(first.outputs[0], second.inputs[0])
    tree.links.new(second.outputs[0], base)


def build_muted_node(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeHueSaturation")
    node.inputs["Saturation"].default_value = 0
    node.mute = True
    tree.links.new(texture.outputs[0], node.inputs["Color"])
    tree.links.new(node.outputs[0], base)


def build_muted_link(tree, base, texture, colours):
    base.default_value = TINT
    tree.links.new(texture.outputs[0], base).is_muted = True


def build_group(tree, base, texture, colours):
    def build(inner, incoming, outgoing):
        mixed(inner, outgoing, "ShaderNodeMix", "MULTIPLY", 1.0, incoming, TINT)

    node = group_of(tree, base, build)
    tree.links.new(texture.outputs[0], node.inputs[0])


def build_group_of_groups(tree, base, texture, colours):
    def build(inner, incoming, outgoing):
        def through(innermost, incoming, outgoing):
            innermost.links.new(incoming, outgoing)

        inner.links.new(incoming, group_of(inner, outgoing, through).inputs[0])

    group_of(tree, base, build).inputs[0].default_value = OTHER


def build_values(tree, base, texture, colours):
    node = tree.nodes.new("ShaderNodeValue")
    node.outputs[0].default_value = 0.3
    mixed(tree, base, "ShaderNodeMix", "MIX", node.outputs[0], texture.outputs[0], TINT)


def build_metal(tree, base, texture, colours):
    tree.links.new(texture.outputs[0], base)
    base.node.inputs["Metallic"].default_value = 0.75


def build_diffuse(tree, base, texture, colours):
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs[0], shader.inputs["Color"])
    tree.links.new(shader.outputs[0], tree.get_output_node("ALL").inputs["Surface"])


def build_emission(tree, base, texture, colours):
    shader = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(shader.outputs[0], tree.get_output_node("ALL").inputs["Surface"])


def build_alpha(tree, base, texture, colours):
    """Transparent pixels of an 8-bit image are black where the material does not read their alpha."""
    texture.image = image([[(1, 1, 1, 1), (1, 1, 1, 0)], [(1, 0, 1, 0), (1, 0, 0, 1)]], is_float=False)
    texture.interpolation = "Closest"
    tree.links.new(texture.outputs[0], base)


def float_alpha(mode, is_read):
    """Cycles divides colours by an alpha that the material reads; whether they are premultiplied, Cycles 5 takes from
    the mode, and Cycles 4 takes it for granted."""

    def build(tree, base, texture, colours):
        texture.image = image(np.tile((0.2, 0.1, 0.3, 0.5), (2, 2, 1)))
        texture.image.alpha_mode = mode
        tree.links.new(texture.outputs[0], base)
        if is_read:
            node = tree.nodes.new("ShaderNodeMath")
            node.inputs[1].default_value = 10.0
            node.use_clamp = True
            tree.links.new(texture.outputs["Alpha"], node.inputs[0])
            tree.links.new(node.outputs[0], base.node.inputs["Alpha"])

    build.__name__ = f"float_{mode.lower()}_alpha{'_that_is_read' if is_read else ''}"
    return build


MATERIALS = [
    build_plain,
    build_image,
    build_attribute,
    build_active_colours,
    build_missing_attribute,
    build_vector_attribute,
    build_face_attribute,
    build_other_uv_map,
    build_missing_uv_map,
    *(mapping(kind) for kind in ("POINT", "TEXTURE", "VECTOR")),
    *(extension(kind) for kind in ("REPEAT", "EXTEND", "CLIP", "MIRROR")),
    *(closest(kind) for kind in ("REPEAT", "EXTEND", "CLIP", "MIRROR")),
    mix("ShaderNodeMix", "MIX", 0.3, "image", TINT),
    mix("ShaderNodeMix", "MIX", 0.3, TINT, "paint"),
    mix("ShaderNodeMixRGB", "MIX", 0.6, TINT, "image"),
    mix("ShaderNodeMix", "MULTIPLY", 0.7, "paint", TINT),
    mix("ShaderNodeMixRGB", "MULTIPLY", 0.7, TINT, "image"),
    mix("ShaderNodeMix", "MULTIPLY", 1.0, TINT, OTHER),
    mix("ShaderNodeMix", "MIX", 1.0, "image", "paint"),
    mix("ShaderNodeMix", "OVERLAY", 0.0, "image", "paint"),
    build_reroutes,
    build_muted_node,
    build_muted_link,
    build_group,
    build_group_of_groups,
    build_values,
    build_metal,
    build_diffuse,
    build_emission,
    build_alpha,
    *(float_alpha(mode, is_read) for mode in ("STRAIGHT", "PREMUL", "CHANNEL_PACKED") for is_read in (False, True)),
]


@pytest.mark.parametrize("build", MATERIALS, ids=lambda build: build.__name__.removeprefix("build_"))
def test_colours_are_those_that_cycles_shows(build):
    random = np.random.default_rng(7)
    obj = add_mesh("Triangles", random.random((60, 3)), np.arange(60).reshape(20, 3))
    mesh = obj.data
    for name in ("UVMap", "Other"):
        mesh.uv_layers.new(name=name).uv.foreach_set("vector", random.random(2 * 60, np.float32))
    mesh.uv_layers["UVMap"].active_render = True
    mesh.uv_layers["Other"].active = True
    paint(mesh, random.random((60, 3)))
    paint(mesh, np.tile(np.eye(3), (20, 1)), name="Weights")
    mesh.color_attributes.render_color_index = mesh.color_attributes.find("Paint")
    mesh.attributes.new("Vector", "FLOAT_VECTOR", "POINT").data.foreach_set("vector", random.random(3 * 60, np.float32))
    mesh.attributes.new("Faces", "FLOAT_COLOR", "FACE").data.foreach_set("color", random.random(4 * 20, np.float32))
    # Blender bakes a corner a little inside of its face: where that is, the bake of such weights tells.
    mesh.materials.append(painted_material("Weights"))
    weights = by_cycles(obj)
    assert 0 < np.abs(weights - np.tile(np.eye(3), (20, 1))).max() < 1e-3

    made = matte()
    texture = image_node(made.node_tree, image(random.random((3, 5, 3))))
    colours = made.node_tree.nodes.new("ShaderNodeVertexColor")
    colours.layer_name = "Paint"
    build(made.node_tree, bsdf(made).inputs["Base Color"], texture, colours)
    mesh.materials[0] = made
    albedo, warnings = read_albedo(obj)
    assert warnings == []
    found = albedo.at(np.repeat(np.arange(20), 3), weights[:, 1], weights[:, 2])
    error = np.abs(found - by_cycles(obj)).max()
    print(f"{build.__name__}: largest difference from Cycles {error:.1e}")
    assert error < 2e-5
