# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps for other programs: what their pixels are, in which files, and what a glTF export makes of the AO map."""

import json
import struct

import bpy
import numpy as np
import pytest

from core.multibounce import irradiance_from_bounces

from .bakes import MULTIBOUNCE_AO, bake, clear, pixels, reports
from .meshes import add_mesh, add_uv_map, box, plate
from .snapshot import differences, snapshot

MADE = {"target": "TEXTURE", "resolution": 24, "samples": 64, "use_material_nodes": False}


def image(obj, name):
    return bpy.data.images[f"{obj.name} {name}"]


def corner():
    """A floor with a wall, so that it has all values of AO from a half to one."""
    floor = plate("Floor")
    box("Wall", low=(-1.2, -3, -1), high=(-1.0, 3, 4))
    return floor


def colour(obj, value):
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = value
    obj.data.materials.append(material)
    return material.node_tree


def to_srgb(x):
    """IEC 61966-2-1."""
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("map_format", ["PNG_8", "PNG_16", "OPEN_EXR"])
@pytest.mark.parametrize("to_files", [False, True])
def test_pixels(map_format, to_files, tmp_path):
    """The AO map is F0; the coloured one E/E0 with the base colour, as sRGB in a PNG file."""
    floor = corner()
    rho = (0.9, 0.5, 0.1)
    colour(floor, (*rho, 1))
    folder = str(tmp_path) if to_files else ""
    (report,) = reports(
        floor, **MADE, output_directory=folder, map_format=map_format, use_ao_map=True, use_colored_ao_map=True
    )
    assert len(report.outputs) == 4
    channels = pixels(image(floor, MULTIBOUNCE_AO)).astype(float)
    expected = irradiance_from_bounces(*np.moveaxis(channels[..., None], 2, 0), np.array(rho))
    assert np.ptp(expected[..., 2]) > 0.3
    assert (expected[..., 0] - expected[..., 2]).max() > 0.05
    step = {"PNG_8": 1 / 255, "PNG_16": 1 / 65535, "OPEN_EXR": 1e-6}[map_format]
    grey, coloured = image(floor, "AO"), image(floor, "Colored AO")
    assert grey.colorspace_settings.name == "Non-Color"
    np.testing.assert_allclose(pixels(grey)[..., :3], np.repeat(channels[..., :1], 3, axis=2), atol=0.51 * step)
    # Blender gives the bytes of an 8-bit image as they are, and floats as linear light.
    found = pixels(coloured)[..., :3]
    if map_format == "PNG_16":
        found = to_srgb(found)
    shown = expected if map_format == "OPEN_EXR" else to_srgb(expected)
    np.testing.assert_allclose(found, shown, atol=0.51 * step + 1e-5)
    assert coloured.colorspace_settings.name == ("Non-Color" if map_format == "OPEN_EXR" else "sRGB")
    extension = ".exr" if map_format == "OPEN_EXR" else ".png"
    assert {path.name for path in tmp_path.iterdir() if "bent" not in path.name and "multi" not in path.name} == (
        {"Floor_ao" + extension, "Floor_colored_ao" + extension} if to_files else set()
    )
    assert all((each.packed_file is None) == to_files for each in (grey, coloured))


def test_base_colours_of_images_and_attributes():
    """The base colour at each texel: an image through the same UV map, then a colour attribute."""
    floor = corner()
    tree = colour(floor, (1, 1, 1, 1))
    shader = tree.nodes["Principled BSDF"]
    picture = bpy.data.images.new("Picture", 24, 24, float_buffer=True, is_data=True)
    rho = np.random.default_rng(0).random((24, 24, 4)).astype(np.float32)
    rho[..., 3] = 1
    picture.pixels.foreach_set(rho.ravel())
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation = picture, "Closest"
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    settings = {**MADE, "map_format": "OPEN_EXR", "use_colored_ao_map": True, "margin": 0}
    bake(floor, **settings)
    channels = pixels(image(floor, MULTIBOUNCE_AO)).astype(float)
    expected = irradiance_from_bounces(*np.moveaxis(channels[..., None], 2, 0), rho[..., :3])
    np.testing.assert_allclose(pixels(image(floor, "Colored AO"))[..., :3], expected, atol=1e-5)

    attribute = floor.data.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    position = np.array([v.co for v in floor.data.vertices])
    attribute.data.foreach_set("color", np.column_stack(((position + 1) / 2, position[:, 0] * 0 + 1)).ravel())
    node = tree.nodes.new("ShaderNodeVertexColor")
    node.layer_name = "Paint"
    tree.links.new(node.outputs["Color"], shader.inputs["Base Color"])
    bake(floor, **settings)
    at = np.stack([*np.meshgrid((np.arange(24) + 0.5) / 24, (np.arange(24) + 0.5) / 24), np.full((24, 24), 0.5)], -1)
    channels = pixels(image(floor, MULTIBOUNCE_AO)).astype(float)
    expected = irradiance_from_bounces(*np.moveaxis(channels[..., None], 2, 0), at)
    np.testing.assert_allclose(pixels(image(floor, "Colored AO"))[..., :3], expected, atol=2e-3)


def test_radiosity_has_its_own_colours():
    floor = corner()
    bake(floor, **MADE, bounces="RADIOSITY", map_format="OPEN_EXR", use_ao_map=True, use_colored_ao_map=True)
    channels = pixels(image(floor, "Multibounce Radiosity"))
    np.testing.assert_array_equal(pixels(image(floor, "Colored AO"))[..., :3], channels[..., :3])
    np.testing.assert_array_equal(pixels(image(floor, "AO"))[..., 0], channels[..., 3])


def exported(path):
    """The JSON part and the images' bytes of a .glb file."""
    import addon_utils  # found once bpy is

    addon_utils.enable("io_scene_gltf2")
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB")
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    told = json.loads(data[20 : 20 + length])
    binary = data[20 + length + 8 :]
    views = [told["bufferViews"][each["bufferView"]] for each in told.get("images", ())]
    return told, [binary[view.get("byteOffset", 0) :][: view["byteLength"]] for view in views]


@pytest.mark.usefixtures("fitted")
def test_gltf_exports_carry_the_occlusion(tmp_path):
    """Exported and read back: the mean of the occlusion texture's red, which glTF takes, is that of F0; and the second
    UV map that the bake used is named."""
    floor = corner()
    colour(floor, (0.9, 0.5, 0.1, 1))
    add_uv_map(floor.data, [(v.co.y / 2 + 0.5, v.co.x / 2 + 0.5) for v in floor.data.vertices], "Light")
    bake(floor, **MADE, use_gltf_occlusion=True, uv_map="Light")
    bpy.data.objects.remove(bpy.data.objects["Wall"])
    told, images = exported(tmp_path / "floor.glb")
    material = told["materials"][told["meshes"][0]["primitives"][0]["material"]]
    occlusion = material["occlusionTexture"]
    assert occlusion.get("texCoord", 0) == 1
    np.testing.assert_allclose(material["pbrMetallicRoughness"]["baseColorFactor"], (0.9, 0.5, 0.1, 1), atol=1e-6)
    (tmp_path / "read.png").write_bytes(images[told["textures"][occlusion["index"]]["source"]])
    read = bpy.data.images.load(str(tmp_path / "read.png"))
    expected = floor["multibounce_ao"]["f0"]["mean"]
    print(f"mean of the exported occlusion {pixels(read)[..., 0].mean():.4f}, of F0 {expected:.4f}")
    assert tuple(read.size) == (24, 24)
    assert abs(pixels(read)[..., 0].mean() - expected) < 0.01
    assert 0.5 < expected < 0.95


def gltf_nodes(tree):
    groups = [node for node in tree.nodes if node.bl_idname == "ShaderNodeGroup"]
    return [node for node in groups if node.node_tree.name == "glTF Material Output"]


@pytest.mark.usefixtures("fitted")
def test_gltf_nodes_come_and_go():
    """A later bake keeps one set of them, one without takes them out, and Clear puts the material back."""
    floor = corner()
    tree = colour(floor, (0.5, 0.5, 0.5, 1))
    before = {key: value for key, value in snapshot().items() if key.startswith("materials")}
    for settings in ({"use_material_nodes": True}, {"use_material_nodes": True}, {"use_material_nodes": False}):
        bake(floor, **(MADE | settings), use_gltf_occlusion=True)
        (output,) = gltf_nodes(tree)
        assert output.inputs["Occlusion"].links[0].from_node.image == image(floor, "AO")
    bake(floor, **MADE, use_gltf_occlusion=False)
    assert not gltf_nodes(tree)
    bake(floor, **MADE, use_gltf_occlusion=True)
    clear(floor)
    after = {key: value for key, value in snapshot().items() if key.startswith("materials")}
    assert differences(before, after) == []
    assert not bpy.data.images


@pytest.mark.usefixtures("fitted")
def test_a_vertex_bake_has_no_map_for_gltf():
    """With the setting left on, whether there is a map of an earlier bake or not."""
    floor = corner()
    tree = colour(floor, (0.5, 0.5, 0.5, 1))
    vertices = MADE | {"target": "VERTEX"}
    bake(floor, **vertices, use_gltf_occlusion=True)
    assert not gltf_nodes(tree)
    bake(floor, **MADE, use_gltf_occlusion=True)
    assert gltf_nodes(tree)
    bake(floor, **vertices, use_gltf_occlusion=True)
    assert not gltf_nodes(tree)


@pytest.mark.usefixtures("fitted")
def test_an_occlusion_of_the_artists_own_stays():
    floor = corner()
    tree = colour(floor, (0.5, 0.5, 0.5, 1))
    group = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
    group.interface.new_socket("Occlusion", socket_type="NodeSocketFloat")
    output, value = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeValue")
    output.node_tree = group
    tree.links.new(value.outputs[0], output.inputs["Occlusion"])
    (report,) = reports(floor, **MADE, use_gltf_occlusion=True)
    assert "'Paint' has an occlusion of its own" in " ".join(report.warnings)
    assert output.inputs["Occlusion"].links[0].from_node == value


@pytest.mark.usefixtures("fitted")
@pytest.mark.parametrize("in_material", [False, True])
def test_a_gltf_group_without_occlusion_gets_the_input(tmp_path, in_material):
    """The exporter finds the group by its name alone, so there must be no second one, "glTF Material Output.001"."""
    floor = corner()
    tree = colour(floor, (0.5, 0.5, 0.5, 1))
    group = bpy.data.node_groups.new("glTF Material Output", "ShaderNodeTree")
    group.interface.new_socket("Thickness", socket_type="NodeSocketFloat")
    if in_material:
        tree.nodes.new("ShaderNodeGroup").node_tree = group
    bake(floor, **MADE, use_gltf_occlusion=True)
    assert [each.name for each in bpy.data.node_groups if "glTF" in each.name] == ["glTF Material Output"]
    assert [item.name for item in group.interface.items_tree] == ["Thickness", "Occlusion"]
    (output,) = gltf_nodes(tree)
    assert output.inputs["Occlusion"].links[0].from_node.image == image(floor, "AO")
    told, _ = exported(tmp_path / "floor.glb")
    assert any("occlusionTexture" in material for material in told["materials"])
    clear(floor)
    assert len(gltf_nodes(tree)) == in_material


@pytest.mark.usefixtures("fitted")
def test_materials_that_are_shared_are_copied_for_the_map():
    one, two = plate("One"), plate("Two", location=(5, 0, 0))
    colour(one, (0.5, 0.5, 0.5, 1))
    two.data.materials.append(one.data.materials[0])
    bake(one, **MADE, use_gltf_occlusion=True)
    assert one.data.materials[0] != two.data.materials[0]
    assert two.data.materials[0].name == "Paint"
    clear(one)
    assert one.data.materials[0] == two.data.materials[0]


def test_names_that_the_artist_has_taken_are_refused():
    floor = add_mesh("Floor", [(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1, 2)])
    add_uv_map(floor.data, [(0, 0), (1, 0), (1, 1)])
    bpy.data.images.new("Floor AO", 4, 4)
    assert reports(floor, **MADE)[0].error is None
    assert "'Floor AO', which is no bake" in reports(floor, **MADE, use_ao_map=True)[0].error
