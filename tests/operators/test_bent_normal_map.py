# SPDX-License-Identifier: GPL-3.0-or-later
"""The bent normal map: what Blender, and whoever has the mesh's tangents, reads from it."""

import struct

import bpy
import numpy as np
import OpenEXR
import pytest

from .bakes import BENT_CONE, bake, change_settings, clear, operators, pixels, rms, select
from .materials import material
from .meshes import add_mesh, add_uv_map, box, corner_vertices, plate, positions, read, suzanne
from .refusals import error_of

SIZE = 128
MAP = "Bent Normal"


def bake_map(obj, space="TANGENT", **settings):
    """(h, w, 3), each component in [-1, 1]."""
    chosen = {"target": "TEXTURE", "bounces": "FITTED", "resolution": SIZE, "margin": 0, "use_material_nodes": False}
    chosen["map_format"] = "OPEN_EXR"  # exact
    bake(obj, use_bent_normal_map=True, bent_normal_space=space, **(chosen | settings))
    return pixels(bpy.data.images[f"{obj.name} {MAP}"])[..., :3] * 2.0 - 1.0


def bent_cone(obj):
    """Mean visible directions (h, w, 3) in object space, and which texels have one (h, w)."""
    found = pixels(bpy.data.images[f"{obj.name} {BENT_CONE}"])[..., :3].astype(float)
    return found, found.any(axis=2)


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)


def degrees_between(first, second):
    return np.degrees(np.arccos(np.clip((unit(first) * unit(second)).sum(axis=-1), -1, 1)))


def occluded_suzanne():
    """Under a slab and beside a wall, so that bent directions lean."""
    obj = suzanne(levels=1)
    box("Wall", low=(1.3, -3, -3), high=(1.5, 3, 3))
    obj.data.materials.append(material())
    return obj


@pytest.mark.parametrize("y", ["POS_Y", "NEG_Y"])
@pytest.mark.parametrize("space", ["OBJECT", "TANGENT"])
def test_an_open_plane(space, y):
    found = bake_map(plate(), space, bent_normal_y=y, resolution=8)
    np.testing.assert_allclose(found, np.tile((0, 0, 1), (8, 8, 1)), atol=1e-6)


def test_decoded_with_the_meshs_tangents():
    """By the definition: n = x T + y B + z N of each texel that one triangle fills."""
    from core.rasterise import rasterise
    from core.sample_points import texel_places

    obj = occluded_suzanne()
    # With backs ignored nothing is inside of anything, so each texel shows what it sees.
    found = bake_map(obj, samples=64, ignore_backfaces=True)
    expected, held = bent_cone(obj)
    mesh = obj.data
    mesh.calc_loop_triangles()
    mesh.calc_tangents(uvmap=mesh.uv_layers[0].name)
    normals, tangents = (read(mesh.loops, name, 3) for name in ("normal", "tangent"))
    signs = read(mesh.loops, "bitangent_sign", 1)
    corners = read(mesh.loop_triangles, "loops", 3, np.int32)
    uv = read(mesh.uv_layers[0].uv, "vector", 2)[corners]
    texels = rasterise(uv, SIZE, SIZE, texel_places(64))
    whole = (texels.triangle == texels.triangle[:, :1]).all(axis=1) & held.reshape(-1)[texels.texel]
    texel, triangle = texels.texel[whole], texels.triangle[whole, 0]
    weights = texels.weights[whole].mean(axis=1)
    weights = np.column_stack((1 - weights.sum(axis=1), weights))
    normal, tangent = (np.einsum("kc,kcx->kx", weights, each[corners[triangle]]) for each in (normals, tangents))
    frame = tangent, signs[corners[triangle, 0], None] * np.cross(normal, tangent), normal
    decoded = sum(found.reshape(-1, 3)[texel, axis, None] * frame[axis] for axis in range(3))
    error = degrees_between(decoded, expected.reshape(-1, 3)[texel])
    print(
        f"{len(texel)} texels decoded with the mesh's tangents: rms {rms(error):.4f} degrees, at most {error.max():.3f}"
    )
    assert len(texel) > 1000
    assert degrees_between(normals[corners[triangle, 0]], expected.reshape(-1, 3)[texel]).mean() > 5
    assert error.max() < 0.01


@pytest.mark.parametrize("mirrored", ["", "u", "object"])
@pytest.mark.parametrize("space", ["OBJECT", "TANGENT"])
def test_read_by_the_normal_map_node(space, mirrored):
    """Cycles decodes the map on a turned and unevenly stretched object, also where UVs or the object are mirrored: the
    bent direction in the world."""
    obj = occluded_suzanne()
    obj.rotation_euler, obj.scale = (0.4, 0.9, -0.6), (1.0, 1.5, -0.8 if mirrored == "object" else 0.8)
    if mirrored == "u":
        uv = read(obj.data.uv_layers[0].uv, "vector", 2)
        obj.data.uv_layers[0].uv.foreach_set("vector", ((1, 0) + (-1, 1) * uv).astype(np.float32).ravel())
    bake_map(obj, space)
    local, held = bent_cone(obj)
    found = by_the_normal_map_node(obj, space)
    matrix = np.array(obj.matrix_world)[:3, :3]
    # Cycles decodes at a random point of each texel, whose frame is turned by what the surface bends within one.
    held &= found.any(axis=2)
    error = degrees_between(found, local @ matrix.T)[held]
    print(f"{space} map, {mirrored or 'nothing'} mirrored, by Cycles' Normal Map node: rms {rms(error):.2f} degrees")
    assert held.sum() > 3000
    assert rms(error) < 3.0


def by_the_normal_map_node(obj, space):
    """World normals (h, w, 3) that Cycles makes of the map, 0 where it covers nothing."""
    tree = obj.active_material.node_tree
    texture, decode, place = (tree.nodes.new(f"ShaderNode{name}") for name in ("TexImage", "NormalMap", "VectorMath"))
    texture.image, texture.interpolation = bpy.data.images[f"{obj.name} {MAP}"], "Closest"
    decode.space, decode.uv_map = space, obj.data.uv_layers[0].name
    place.operation = "MULTIPLY_ADD"
    place.inputs[1].default_value = place.inputs[2].default_value = (0.5, 0.5, 0.5)
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(texture.outputs["Color"], decode.inputs["Color"])
    tree.links.new(decode.outputs["Normal"], place.inputs[0])
    tree.links.new(place.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = bpy.data.images.new("Cycles", SIZE, SIZE, alpha=True, float_buffer=True)
    target.image.colorspace_settings.name = "Non-Color"
    target.image.pixels.foreach_set(np.full(4 * SIZE * SIZE, 0.5, np.float32))
    tree.nodes.active = target
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    select(obj)
    bpy.ops.object.bake(type="EMIT", margin=0, use_clear=False)
    return pixels(target.image)[..., :3] * 2.0 - 1.0


def test_directx_has_green_the_other_way():
    obj = occluded_suzanne()
    opengl = bake_map(obj, bent_normal_y="POS_Y", resolution=32)
    directx = bake_map(obj, bent_normal_y="NEG_Y", resolution=32)
    assert np.abs(opengl[..., 1]).max() > 0.5
    np.testing.assert_allclose(directx, opengl * (1, -1, 1), atol=1e-6)


def test_faces_of_many_corners():
    """MikkTSpace knows triangles and quads only: a hexagon's tangents are those of the same hexagon cut up, and no mesh
    is left behind."""
    angle = np.arange(6) * np.pi / 3
    around = np.column_stack((np.cos(angle), np.sin(angle), np.zeros(6)))
    bent = np.vstack((around, around[:2] + np.array((1.0, 0.6, 0.8))))
    uv = np.vstack((around[:, :2], around[:2, :2] + np.array((0.7, 0.4)))) @ ((0.8, 0.6), (-0.6, 0.8)) * 0.25 + 0.4
    whole = add_mesh("Whole", bent, [range(6), (1, 0, 6, 7)])
    cut = add_mesh("Cut", bent, [*((0, i, i + 1) for i in range(1, 5)), (1, 0, 6, 7)])
    change_settings(use_bent_normal_map=True, bent_normal_space="TANGENT")
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    meshes, by_vertex = len(bpy.data.meshes), []
    for obj in (whole, cut):
        add_uv_map(obj.data, uv)
        obj.data.normals_split_custom_set_from_vertices(unit(bent + np.array((0.2, 0.1, 2.0))))
        obj.data.calc_loop_triangles()
        made = operators("bent_normal_map").read_bent_normal_map(obj.data, np.eye(4), "UVMap", settings)
        assert (made.tangents.signs == 1).all()
        vectors = np.full((2, 8, 3), np.nan)  # of the hexagon, and of the quad
        in_quad = np.arange(len(made.normals)) >= len(made.normals) - 4
        vectors[in_quad.astype(int), corner_vertices(obj.data)] = made.tangents.vectors
        by_vertex.append(vectors)
    assert len(bpy.data.meshes) == meshes
    assert not [each for each in whole.data.attributes if each.name.startswith("multibounce")]
    np.testing.assert_allclose(by_vertex[0], by_vertex[1], atol=1e-3)


def test_closed_points_show_their_normal():
    obj = plate("Floor")
    box("Tomb", low=(-2, -2, -1), high=(2, 2, 1))
    for space in ("OBJECT", "TANGENT"):
        np.testing.assert_allclose(bake_map(obj, space, resolution=8), np.tile((0, 0, 1), (8, 8, 1)), atol=1e-6)


def test_high_to_low():
    """In the low mesh's space, what the high one sees: on a plane that is the world's."""
    low, high = plate("Low"), plate("High", steps=24)
    at = positions(high)
    at[:, 2] = 0.15 * np.cos(4 * at[:, 0]) * np.cos(5 * at[:, 1])
    high.data.vertices.foreach_set("co", at.astype(np.float32).ravel())
    change_settings(target="TEXTURE", bounces="FITTED", resolution=32, margin=0, samples=64, use_material_nodes=False)
    change_settings(use_bent_normal_map=True, map_format="OPEN_EXR", use_selected_to_active=True, cage_extrusion=0.5)
    select(low, high)
    assert bpy.ops.multibounce_ao.bake() == {"FINISHED"}
    found = pixels(bpy.data.images[f"Low {MAP}"])[..., :3] * 2.0 - 1.0
    expected, held = bent_cone(low)
    assert held.all() and degrees_between(expected, (0, 0, 1)).max() > 20
    np.testing.assert_allclose(found, unit(expected), atol=1e-5)


def test_background_is_flat():
    """As in Blender's own bakes of normals."""
    obj = plate()
    obj.data.uv_layers[0].uv.foreach_set("vector", read(obj.data.uv_layers[0].uv, "vector", 2).ravel() * 0.25)
    np.testing.assert_allclose(bake_map(obj, resolution=16)[8:, 8:], np.tile((0, 0, 1), (8, 8, 1)))


def test_file_and_clear(tmp_path):
    obj = plate()
    bake_map(obj, resolution=16, output_directory=str(tmp_path))
    made = bpy.data.images[f"Plate {MAP}"]
    assert made.colorspace_settings.name == "Non-Color"
    with OpenEXR.File(str(tmp_path / "Plate_bent_normal.exr"), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
    assert set(channels) == set("RGBA")
    np.testing.assert_allclose(channels["B"], 1.0, atol=1e-6)
    clear(obj)
    assert MAP not in "".join(bpy.data.images.keys())


@pytest.mark.parametrize(("map_format", "bits"), [("PNG_8", 8), ("PNG_16", 16)])
@pytest.mark.parametrize("use_udim", [False, True])
@pytest.mark.parametrize("to_files", [False, True])
def test_png(map_format, bits, use_udim, to_files, tmp_path):
    """Within half a step of the floats that the same bake leaves as OpenEXR."""
    obj = plate()
    box("Wall", low=(-1.2, -3, -1), high=(-1.0, 3, 4))
    made = {"resolution": 16, "samples": 16, "use_udim": use_udim}
    expected = bake_map(obj, **made)
    assert np.ptp(expected[..., 0]) > 0.3
    folder = str(tmp_path) if to_files else ""
    found = bake_map(obj, **made, map_format=map_format, output_directory=folder)
    step = 2 / (2**bits - 1)  # of components, which reach from -1 to 1
    np.testing.assert_allclose(found, expected, atol=0.5 * step + 1e-6)
    image = bpy.data.images[f"Plate {MAP}"]
    assert image.colorspace_settings.name == "Non-Color"
    assert image.file_format == "PNG"
    assert bool(image.packed_files) != to_files
    if to_files:
        data = (tmp_path / f"Plate_bent_normal{'.1001' if use_udim else ''}.png").read_bytes()
        assert struct.unpack_from(">IIBB", data, 16) == (16, 16, bits, 2)  # RGB
        assert not list(tmp_path.glob("*bent_normal*.exr"))


def test_an_artists_image_of_that_name_stays():
    obj = plate()
    bpy.data.images.new(f"Plate {MAP}", 4, 4)
    change_settings(use_bent_normal_map=True, target="TEXTURE", samples=1, resolution=4)
    select(obj)
    assert "would replace the image 'Plate Bent Normal'" in error_of(bpy.ops.multibounce_ao.bake)
