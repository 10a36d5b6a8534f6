# SPDX-License-Identifier: GPL-3.0-or-later
"""The images and files that a texture bake leaves."""

import json
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, bake, change_settings, pixels, reports
from .meshes import plate, suzanne

NAMES = {MULTIBOUNCE_AO: "_multibounce_ao.exr", BENT_CONE: "_bent_cone.exr"}


def image(obj, channel=MULTIBOUNCE_AO):
    return bpy.data.images[f"{obj.name} {channel}"]


def bake_texture(*objects, **settings):
    bake(*objects, **{"target": "TEXTURE", "resolution": 32, **settings})


def read_exr(path):
    """{channel: (h, w)}, top row first as the file has it."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels.copy() for name, channel in file.channels().items()}


@pytest.mark.parametrize("channel", NAMES)
@pytest.mark.parametrize("to_files", [False, True])
def test_how_images_are_set_up(channel, to_files, tmp_path):
    obj = plate()
    bake_texture(obj, resolution=48, output_directory=str(tmp_path) if to_files else "")
    made = image(obj, channel)
    assert tuple(made.size) == (48, 48)
    assert made.is_float
    assert made.depth == 128  # four channels of 32 bits
    assert made.colorspace_settings.name == "Non-Color"
    assert made.alpha_mode == "CHANNEL_PACKED"
    assert (made.packed_file is None) == to_files
    assert len(bpy.data.images) == 2


def test_channels_are_those_of_the_vertex_bake():
    """An open plate: F0 = 1, F1 = F2 = 0; the mean direction is (0, 0, 1/2) and alpha = 1."""
    obj = plate()
    bake_texture(obj, samples=1024, resolution=8)
    np.testing.assert_array_equal(pixels(image(obj))[..., :3], np.tile((1, 0, 0), (8, 8, 1)))
    np.testing.assert_allclose(pixels(image(obj, BENT_CONE)), np.tile((0, 0, 0.5, 1), (8, 8, 1)), atol=0.006)


def test_files_hold_what_the_images_show(tmp_path):
    """Read by OpenEXR itself: 32-bit R, G, B and A, the rows from the top."""
    obj = suzanne()
    bake_texture(obj)
    packed = {channel: pixels(image(obj, channel)) for channel in NAMES}
    (report,) = reports(obj, target="TEXTURE", resolution=32, output_directory=str(tmp_path / "new" / "maps"))
    files = [tmp_path / "new" / "maps" / f"Suzanne{suffix}" for suffix in NAMES.values()]
    assert sorted((tmp_path / "new" / "maps").iterdir()) == sorted(files)
    assert [Path(path) for path in report.outputs] == files
    for channel, path in zip(NAMES, files, strict=True):
        channels = read_exr(path)
        assert set(channels) == set("RGBA")
        assert all(plane.dtype == np.float32 for plane in channels.values())
        rows = np.stack([channels[name] for name in "RGBA"], axis=-1)[::-1]
        np.testing.assert_array_equal(rows, packed[channel])
        np.testing.assert_array_equal(pixels(image(obj, channel)), packed[channel])
        assert Path(bpy.path.abspath(image(obj, channel).filepath)) == path


def test_files_as_the_settings_ask(tmp_path):
    obj = suzanne()
    bake_texture(obj, samples=8)
    exact = pixels(image(obj))
    bake_texture(obj, samples=8, output_directory=str(tmp_path), color_depth="16", exr_codec="PIZ", uv_map="UVMap")
    path = tmp_path / "Suzanne_multibounce_ao.exr"
    assert all(plane.dtype == np.float16 for plane in read_exr(path).values())
    np.testing.assert_array_equal(pixels(image(obj)), exact.astype(np.float16))
    with OpenEXR.File(str(path), header_only=True) as file:
        header = dict(file.header())
    assert header["compression"] == OpenEXR.PIZ_COMPRESSION
    assert header["software"].startswith("Multibounce AO ")
    told = json.loads(header["multibounce_ao"])
    assert told["channels"] == {"R": "F0", "G": "F1", "B": "F2", "A": "T"}
    assert (told["object"], told["uv_map"]) == ("Suzanne", "UVMap")
    assert told["settings"].items() >= {"samples": 8, "resolution": 32, "color_depth": "16", "seed": 0}.items()


def test_an_untitled_blend_packs_and_says_so():
    obj = plate()
    (report,) = reports(obj, target="TEXTURE", resolution=8, output_directory="//maps")
    assert report.error is None
    assert image(obj).packed_file is not None
    assert report.outputs == ["Plate Multibounce AO", "Plate Bent Cone"]
    (warning,) = report.warnings
    assert "'//maps'" in warning and "packed" in warning and "Save it" in warning
    assert obj["multibounce_ao"]["warnings"] == [warning]
    assert reports(obj, target="VERTEX")[0].warnings == []


def test_images_of_another_type_are_replaced_with_all_their_users():
    """The artist has turned the baked image into bytes, keeps it, and shows it in a texture and a compositor's input
    of a scene's own."""
    obj = plate()
    bake_texture(obj, resolution=8)
    made = image(obj)
    made.source, made.generated_width, made.use_generated_float = "GENERATED", 4, False
    made.unpack(method="REMOVE") if made.packed_file else None
    made.use_fake_user = True
    texture = bpy.data.textures.new("Reader", "IMAGE")
    texture.image = made
    brush = bpy.data.objects.new("Reference", None)
    brush.empty_display_type, brush.data = "IMAGE", made
    assert not made.is_float
    bake_texture(obj, resolution=16)
    assert image(obj).is_float and tuple(image(obj).size) == (16, 16)
    assert texture.image == brush.data == image(obj)
    assert image(obj).use_fake_user
    assert len(bpy.data.images) == 2


@pytest.mark.parametrize("folder", ["", "//maps", "absolute"])
def test_pixels_survive_saving_and_reopening(folder, tmp_path):
    obj = suzanne()
    name = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=name)
    bake_texture(obj, output_directory=str(tmp_path / "elsewhere") if folder == "absolute" else folder)
    expected = {channel: pixels(image(obj, channel)) for channel in NAMES}
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=name)
    obj = bpy.data.objects["Suzanne"]
    assert np.ptp(expected[MULTIBOUNCE_AO][..., 0]) > 0.5
    for channel in NAMES:
        np.testing.assert_array_equal(pixels(image(obj, channel)), expected[channel])
        assert image(obj, channel).colorspace_settings.name == "Non-Color"
        assert image(obj, channel).alpha_mode == "CHANNEL_PACKED"
    if folder == "//maps":
        assert {path.name for path in (tmp_path / "maps").iterdir()} == {
            "Suzanne" + suffix for suffix in NAMES.values()
        }
        assert image(obj).filepath.startswith("//")  # the folder may move with the .blend


def test_baking_again_replaces_the_images_where_they_are_used(tmp_path):
    obj = plate()
    bake_texture(obj, resolution=8)
    reader = bpy.data.materials.new("Reader")
    if reader.node_tree is None:
        reader.use_nodes = True
    node = reader.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = image(obj)
    for settings in ({"resolution": 16}, {"resolution": 16, "output_directory": str(tmp_path)}, {"resolution": 4}):
        change_settings(output_directory="")
        bake_texture(obj, **settings)
        assert node.image == image(obj)
        assert tuple(node.image.size) == (settings["resolution"],) * 2
        assert len(bpy.data.images) == 2


def test_objects_whose_names_differ_only_in_what_file_names_cannot_show(tmp_path):
    names = ("A/B", "A:B", "a_b", "../../x", "..", "Ünïcødé 物", "x" * 63)
    objects = [plate(name, location=(9 * i, 0, 0)) for i, name in enumerate(names)]
    folder = tmp_path / "deep" / "maps"
    bake_texture(*objects, resolution=4, output_directory=str(folder))
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) == 2 * len(objects)
    assert {path.parent for path in files} == {folder}
    assert len({path.name.lower() for path in files}) == len(files)  # also where case does not count
    for obj in objects:
        reader = next(node for node in obj.active_material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage")
        assert Path(bpy.path.abspath(reader.image.filepath)).is_file()


def test_only_meshes_have_files(tmp_path):
    obj, empty = plate("Wall"), bpy.data.objects.new("WALL", None)
    bpy.context.scene.collection.objects.link(empty)
    bake_texture(obj, resolution=4, output_directory=str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {"Wall" + suffix for suffix in NAMES.values()}


def test_packed_images_that_no_material_has_are_saved(tmp_path):
    obj = plate()
    bake_texture(obj, resolution=4, use_material_nodes=False)
    expected = pixels(image(obj))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    obj = bpy.data.objects["Plate"]
    np.testing.assert_array_equal(pixels(image(obj)), expected)
    bpy.data.objects.remove(obj)
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert not bpy.data.images  # as with anything else in a .blend that nothing uses


def test_long_names_that_begin_alike_keep_their_own_images():
    """Blender cuts names after 63 bytes."""
    one, two = plate("x" * 60 + "one"), plate("x" * 60 + "two", location=(0, 0, -5))
    bake_texture(one, two, resolution=4)
    sources = {
        next(node for node in obj.active_material.node_tree.nodes if node.bl_idname == "ShaderNodeTexImage").image
        for obj in (one, two)
    }
    assert len(sources) == 2
    assert None not in sources
