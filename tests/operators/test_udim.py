# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiled images: every tile that a UV map reaches into."""

import tempfile

import bpy
import numpy as np
import pytest

from core.exr import read_exr

from .bakes import bake, clear, operators, pixels, reports
from .meshes import box, plate, positions, read
from .snapshot import differences, snapshot

SIZE = 16
MADE = {"target": "TEXTURE", "resolution": SIZE, "margin": 0, "use_udim": True, "samples": 64}


def floor_in_two_tiles():
    """Its left half fills tile 1002, its right half, which stands in a closed box, the upper half of 1011."""
    floor = plate("Floor", steps=2)
    box(low=(0, -2, -1), high=(2, 2, 1), inward=True)
    uv = []
    for face in floor.data.polygons:
        for vertex in face.vertices:
            x, y = positions(floor)[vertex, :2]
            uv.append((x, 1.5 + (y + 1) / 4) if face.center.x > 0 else (1 + x + 1, (y + 1) / 2))
    floor.data.uv_layers[0].uv.foreach_set("vector", np.float32(uv).ravel())
    return floor


def move(obj, by):
    """Move its UVs."""
    layer = obj.data.uv_layers[0].uv
    layer.foreach_set("vector", np.float32(read(layer, "vector", 2) + by).ravel())


def shown_by_cycles(obj, image):
    """(corners,): the image's red at the face corners of ``obj``, a little inside of their faces."""
    material = bpy.data.materials.new("Shown")
    if material.node_tree is None:
        material.use_nodes = True
    tree = material.node_tree
    texture, emission = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
    texture.image = image
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    obj.data.materials.clear()
    obj.data.materials.append(material)
    colours = obj.data.color_attributes.new("Shown", "FLOAT_COLOR", "CORNER")
    obj.data.color_attributes.active_color = colours
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.samples = 1
    bpy.ops.object.bake(type="EMIT", target="VERTEX_COLORS")
    values = np.empty(4 * len(obj.data.loops), np.float32)
    obj.data.color_attributes["Shown"].data.foreach_get("color", values)
    return values.reshape(-1, 4)[:, 0]


@pytest.mark.parametrize("to_files", [False, True])
def test_two_tiles(to_files, tmp_path):
    floor = floor_in_two_tiles()
    move(floor, (-1, 0))
    bake(floor, **(MADE | {"use_udim": False}), ignore_backfaces=True, use_material_nodes=False)
    left = pixels(bpy.data.images["Floor Multibounce AO"])[..., 0]
    move(floor, (1, 0))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    folder = "//my übermaps" if to_files else ""  # Blender finds no tiles by their pattern there
    (report,) = reports(
        floor, **MADE, ignore_backfaces=True, output_directory=folder, use_ao_map=True, use_material_nodes=False
    )
    assert report.warnings == []
    assert report.points == SIZE * SIZE * 3 // 2
    if to_files:
        names = [f"Floor_{what}.{n}" for what in ("multibounce_ao", "bent_cone", "ao") for n in (1002, 1011)]
        files = {f"{name}.{'png' if '_ao.' in name and 'multi' not in name else 'exr'}" for name in names}
        assert {path.name for path in (tmp_path / "my übermaps").iterdir()} == files
        assert len(report.outputs) == 6
        for number, red in ((1002, left), (1011, 0 * left)):
            values = read_exr(tmp_path / "my übermaps" / f"Floor_multibounce_ao.{number}.exr")
            np.testing.assert_array_equal(values[..., 0], red)
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    floor = bpy.data.objects["Floor"]
    for name in ("Multibounce AO", "AO"):
        image = bpy.data.images[f"Floor {name}"]
        assert image.source == "TILED"
        assert [tile.number for tile in image.tiles] == [1002, 1011]
        assert {tuple(tile.size) for tile in image.tiles} == {(SIZE, SIZE)}
        assert len(image.packed_files) == (0 if to_files else 2)
        assert image.colorspace_settings.name == "Non-Color"
        shown = shown_by_cycles(floor, image).reshape(len(floor.data.polygons), 4)
        is_left = np.array([face.center.x < 0 for face in floor.data.polygons])
        assert left.min() - 0.01 <= shown[is_left].min() < shown[is_left].max() <= left.max() + 0.01
        assert shown[~is_left].max() < 0.01 < 0.4 < left.min()
    clear(floor)
    assert not [image for image in bpy.data.images if image.source == "TILED"]


def test_tiles_agree_with_one_image():
    """The same layout, wholly in the tile 1001 and wholly in 1013: the same pixels; and the nodes read them."""
    floor = plate("Floor", steps=2)
    box("Wall", low=(1.1, -2, -1), high=(1.3, 2, 1))
    bake(floor, **(MADE | {"use_udim": False}), use_material_nodes=True)
    one = pixels(bpy.data.images["Floor Multibounce AO"])
    move(floor, (2, 1))
    bake(floor, **MADE, color_depth="16")  # which is of files alone
    image = bpy.data.images["Floor Multibounce AO"]
    assert [tile.number for tile in image.tiles] == [1013]
    np.testing.assert_array_equal(pixels(image), one)
    node = next(node for node in floor.active_material.node_tree.nodes if getattr(node, "image", None) == image)
    assert node.outputs["Color"].is_linked
    assert np.ptp(one[..., 0]) > 0.2


def test_which_tiles_are_touched():
    touched = operators("uv_layout").touched_tiles
    square = np.array([(0, 0), (1, 0), (0, 1)], float)
    assert touched(square[None]) == [1001]  # its border is not in the next ones
    assert touched(square[None] + (9, 99)) == [2000]
    assert touched(np.stack((np.add(square, (3.5, 0)), np.add(square, (0, 2))))) == [1004, 1005, 1021]
    assert touched(square[None] - 0.5) == [1001]
    assert touched(np.stack((square - 5, square + 50, square * np.nan))) == []


def test_which_triangles_are_in_a_tile():
    square = np.array([(0, 0), (1, 0), (0, 1)], float)
    triangles = np.stack([np.add(square, by) for by in ((0, 0), (1, 0), (2, 1), (-0.1, -0.1))])
    in_tile = operators("uv_layout").in_tile
    assert in_tile(triangles, 1001).tolist() == [True, False, False, True]
    assert in_tile(triangles, 1013).tolist() == [False, False, True, False]


def test_what_lies_outside_of_all_tiles_is_told():
    floor = plate("Floor", steps=2)
    move(floor, (9.5, 0))
    (report,) = reports(floor, **MADE)
    assert "reach out of the UDIM tiles" in report.warnings[0]
    move(floor, (-13, 0))
    before = snapshot()
    (report,) = reports(floor, **MADE)
    assert "lies outside the UDIM tiles" in report.error
    assert {line for line in differences(before, snapshot()) if "multibounce" not in line} == set()
    (report,) = reports(floor, **(MADE | {"use_udim": False}))
    assert "or bake UDIM tiles" in report.error


def test_files_of_an_object_that_was_renamed_stay_its_own(tmp_path):
    made = MADE | {"output_directory": str(tmp_path), "use_ao_map": True, "map_format": "OPEN_EXR", "samples": 1}
    for tiles in (True, False):
        first = plate("Floor", steps=2)
        bake(first, **(made | {"use_udim": tiles}))
        first.name = f"Renamed {tiles}"
        before = {file: file.read_bytes() for file in tmp_path.iterdir()}
        second = plate("Floor", steps=2, location=(5, 0, 0))
        bake(second, **(made | {"use_udim": tiles}))
        assert {file: file.read_bytes() for file in before} == before
        assert len(list(tmp_path.iterdir())) == len(before) + 3
        second.name = f"Second {tiles}"


def test_a_bake_to_tiles_in_files_is_known_again_while_they_are_all_there(tmp_path):
    floor = floor_in_two_tiles()
    bake(floor, **MADE, output_directory=str(tmp_path))
    known = operators("bake_record").baked_fingerprint
    assert known(floor)
    (tmp_path / "Floor_bent_cone.1011.exr").unlink()
    assert not known(floor)


def test_what_is_packed_forgets_the_temporary_folder():
    """Unpacked, the files go beside the .blend, under the names that they have as files."""
    floor = floor_in_two_tiles()
    bake(floor, **MADE, output_directory="", use_ao_map=True)
    paths = {packed.filepath for image in bpy.data.images for packed in image.packed_files}
    assert paths == {
        f"//Floor_{name}.{number}.{extension}"
        for name, extension in (("multibounce_ao", "exr"), ("bent_cone", "exr"), ("ao", "png"))
        for number in (1002, 1011)
    }


def test_packing_on_a_full_disk(monkeypatch):
    """It is packed by way of files in the temporary folder: that is what the message names."""
    floor = floor_in_two_tiles()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(operators("texture_result"), "write_exr", full)
    (report,) = reports(floor, **MADE, output_directory="")
    assert report.error == (
        f"Object 'Floor' cannot be packed by way of the temporary folder '{tempfile.gettempdir()}' (no space left on "
        "device): make room there"
    )
    assert not bpy.data.images
    assert "multibounce_ao" not in floor
