# SPDX-License-Identifier: GPL-3.0-or-later
"""Base colours that only a renderer finds: the viewport colour stands in for them, and the artist is told."""

import numpy as np
import pytest

from .base_colors import GREY, OTHER, TINT, image, image_node, matte, mixed, read_albedo
from .materials import bsdf
from .meshes import add, plate


def build_noise(tree, base, texture, colours):
    tree.links.new(tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], base)


def build_two_varying(tree, base, texture, colours):
    mixed(tree, base, "ShaderNodeMix", "MULTIPLY", 1.0, texture.outputs[0], colours.outputs["Color"])


def build_varying_factor(tree, base, texture, colours):
    mixed(tree, base, "ShaderNodeMix", "MIX", texture.outputs["Alpha"], TINT, OTHER)


def build_no_image(tree, base, texture, colours):
    texture.image = None
    tree.links.new(texture.outputs[0], base)


def build_lost_file(tree, base, texture, colours):
    texture.image.source = "FILE"
    texture.image.filepath = "//lost.png"
    tree.links.new(texture.outputs[0], base)


def build_tiles(tree, base, texture, colours):
    texture.image.source = "TILED"
    tree.links.new(texture.outputs[0], base)


def build_box_projection(tree, base, texture, colours):
    texture.projection = "BOX"
    tree.links.new(texture.outputs[0], base)


def build_generated_coordinates(tree, base, texture, colours):
    tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"], texture.inputs[0])
    tree.links.new(texture.outputs[0], base)


def build_other_colour_space(tree, base, texture, colours):
    texture.image = image(np.ones((2, 2, 3)), is_float=False, space="Rec.2020")
    tree.links.new(texture.outputs[0], base)


def build_number_attribute(tree, base, texture, colours):
    colours.layer_name = "Number"
    tree.links.new(colours.outputs["Color"], base)


def build_no_shader(tree, base, texture, colours):
    tree.nodes.remove(base.node)


UNREADABLE = {
    build_noise: "Noise Texture",
    build_two_varying: "Mix",
    build_varying_factor: "Image Texture",
    build_no_image: "without an image",
    build_lost_file: "missing file",
    build_tiles: "tiles",
    build_box_projection: "Box",
    build_generated_coordinates: "Texture Coordinate",
    build_other_colour_space: "Rec.2020",
    build_number_attribute: "Number",
    build_no_shader: "no shader",
}


@pytest.mark.parametrize("build", UNREADABLE, ids=lambda build: build.__name__.removeprefix("build_"))
def test_viewport_colour_with_one_warning(build):
    floor = plate("Floor", steps=3)
    numbers = floor.data.attributes.new("Number", "FLOAT", "POINT")
    numbers.data.foreach_set("value", np.ones(16, np.float32))
    made = matte("Clouds")
    made.diffuse_color = TINT
    texture = image_node(made.node_tree, image(np.ones((2, 2, 3)), name="Sky"))
    colours = made.node_tree.nodes.new("ShaderNodeVertexColor")
    build(made.node_tree, bsdf(made).inputs["Base Color"], texture, colours)
    floor.data.materials.append(made)
    second = add("Second", floor.data, (5, 0, 0))
    third = plate("Third", steps=1, location=(9, 0, 0))

    albedo, warnings = read_albedo(floor, second, third)
    (warning,) = warnings
    print(warning)
    for part in ("'Floor'", "'Clouds'", UNREADABLE[build], "viewport color"):
        assert part in warning
    colours = albedo.at(np.arange(38), np.zeros(38), np.zeros(38))
    np.testing.assert_allclose(colours, [TINT[:3]] * 36 + [(GREY, GREY, GREY)] * 2, atol=1e-6)


def test_metallic_that_cannot_be_read_costs_no_colour():
    floor = plate("Floor", steps=1)
    made = matte("Rusty", TINT)
    noise = made.node_tree.nodes.new("ShaderNodeTexNoise")
    made.node_tree.links.new(noise.outputs[0], bsdf(made).inputs["Metallic"])
    floor.data.materials.append(made)
    albedo, warnings = read_albedo(floor)
    np.testing.assert_allclose(albedo.at(np.arange(2), np.zeros(2), np.zeros(2)), [TINT[:3]] * 2)
    (warning,) = warnings
    assert "'Floor'" in warning and "'Rusty'" in warning and "Metallic" in warning
