# SPDX-License-Identifier: GPL-3.0-or-later
"""`bake_field`: what it leaves, what is refused, and that the field is that of the object."""

import itertools
import re

import bpy
import numpy as np
import pytest

from ..shader_nodes.receivers import Plates, render_plates
from .bakes import change_settings, clear, pixels, select
from .meshes import add, add_mesh, apply_modifiers, box, plate
from .props import FIELD, bake_field, ball, field_generator, report_of
from .refusals import assert_one_sentence, error_of
from .snapshot import differences, snapshot


def rendered(group, plates, folder):
    def connect(tree):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        return node.outputs["Occlusion"]

    return render_plates(plates, connect, folder)


def test_ball_over_a_floor(tmp_path):
    """A ball of radius R at height h over a floor takes (R/d)^2 h/d of the light at distance d from its middle, as
    long as the floor does not cut it."""
    radius, height, extent = 0.5, 0.8, 3.0
    obj = ball(radius=radius, subdivisions=5)
    group = bake_field(obj, samples=256, field_resolution=16)
    obj.location.z = height
    bpy.context.view_layer.update()
    plates = Plates.flat(32, extent, 0.0)
    x, y, _ = plates.positions().T
    d = np.sqrt(x * x + y * y + height * height)
    error = rendered(group, plates, tmp_path) - (radius / d) ** 2 * height / d * fade(d, 4 * radius, 8 * radius)
    print(f"Ball over a floor in Cycles: rms {np.sqrt(np.mean(error**2)):.4f}, largest {np.abs(error).max():.4f}")
    assert np.sqrt(np.mean(error**2)) < 0.01


def fade(r, near, far):
    s = np.clip((r - near) / (far - near), 0, 1)
    return 1 - s * s * (3 - 2 * s)


def test_no_new_bake_for_moves_turns_and_even_scales(tmp_path):
    """Against a field that is baked in the new place: the object's own space is what counts."""
    obj = box(low=(-0.3, -0.5, -0.2), high=(0.6, 0.4, 0.5))
    group = bake_field(obj)
    obj.location, obj.rotation_euler, obj.scale = (0.2, 0.1, 0.4), (0.4, 1.0, -0.6), (1.3, 1.3, 1.3)
    bpy.context.view_layer.update()
    plates = Plates.random(np.random.default_rng(0), 16, 4.0)
    before = rendered(group, plates, tmp_path)
    bake_field(obj)
    np.testing.assert_allclose(rendered(group, plates, tmp_path), before, atol=2e-3)


def cup(high):
    """An open box, 2 wide."""
    corners = [(x, y, z) for z in (0, high) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return add_mesh("Cup", corners, [(0, 1, 2, 3), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)])


def test_volume_within_a_cup(tmp_path):
    """On the bottom of an open box: what its walls block is 1 less the form factor of the opening, a sum over its four
    corners of rectangles (Hottel)."""
    high = 1.2
    obj = cup(high)
    plates = Plates.flat(24, 1.6, 0.1)
    x, y, z = plates.positions().T
    opening = 0.0
    for a in (1 - x, 1 + x):
        for b in (1 - y, 1 + y):
            h = high - z
            opening += (
                a / np.hypot(a, h) * np.arctan(b / np.hypot(a, h)) + b / np.hypot(b, h) * np.arctan(a / np.hypot(b, h))
            ) / (2 * np.pi)
    rms = {}
    for volume in (True, False):
        group = bake_field(obj, samples=256, field_resolution=8, use_field_volume=volume)
        rms[volume] = np.sqrt(np.mean((rendered(group, plates, tmp_path) - (1 - opening)) ** 2))
    print(f"In a cup: rms {rms[True]:.4f} with the volume, {rms[False]:.4f} without")
    assert rms[True] < 0.08 and rms[True] < 0.5 * rms[False]


def test_uneven_scale_is_baked_with_a_warning(tmp_path):
    """The same as the scale applied."""
    obj = box(low=(-0.3, -0.5, -0.2), high=(0.6, 0.4, 0.5))
    obj.scale = (1.5, 1.0, 0.5)
    bpy.context.view_layer.update()
    report = report_of(obj)
    assert any("scaled unevenly" in warning for warning in report.warnings)
    plates = Plates.random(np.random.default_rng(0), 16, 4.0)
    before = rendered(bpy.data.node_groups["AO Field Box"], plates, tmp_path)
    select(obj)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    assert not report_of(obj).warnings
    np.testing.assert_allclose(rendered(bpy.data.node_groups["AO Field Box"], plates, tmp_path), before, atol=1e-4)


def test_modifiers_count(tmp_path):
    obj = box()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bake_field(obj)
    with_modifier = pixels(obj[FIELD]["image"])
    apply_modifiers(obj)
    bake_field(obj)
    np.testing.assert_array_equal(pixels(obj[FIELD]["image"]), with_modifier)


def test_what_it_leaves():
    obj = ball()
    bake_field(obj, field_resolution=9)
    image = bpy.data.images["Ball AO Field"]
    assert obj[FIELD]["image"] == image
    assert image.packed_file is not None and image.is_float and not image.use_half_precision
    assert image.colorspace_settings.name == "Non-Color"
    assert tuple(image.size) == (12 * 11, 4 * 11)
    assert len(obj.data.materials) == 0  # the object itself is not darkened
    record = obj[FIELD].to_dict()
    assert (record["resolution"], record["samples"], record["seed"]) == (9, 4, 0)
    assert record["radius"] == pytest.approx(1, abs=1e-6)


def test_volume_comes_and_goes():
    obj = cup(1)
    for _ in range(2):
        group = bake_field(obj, use_field_volume=True)
        assert set(bpy.data.images.keys()) == {"Cup AO Field", "Cup AO Field Volume"}
    volume = bpy.data.images["Cup AO Field Volume"]
    assert volume.packed_file is not None and volume.is_float
    assert [group.nodes[f"Volume {i}"].image for i in range(1, 5)] == [volume] * 4
    assert bake_field(obj, use_field_volume=False) == group
    assert set(bpy.data.images.keys()) == {"Cup AO Field"} and "Volume 1" not in group.nodes
    bake_field(obj, use_field_volume=True)
    clear(obj)
    assert not bpy.data.images and "AO Field Cup" not in bpy.data.node_groups


def test_no_volume_where_no_space_is_free():
    bake_field(ball(), use_field_volume=True)
    assert set(bpy.data.images.keys()) == {"Ball AO Field"}


def test_survives_saving_and_loading(tmp_path):
    bake_field(ball())
    before = pixels(bpy.data.images["Ball AO Field"])
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Ball"]
    np.testing.assert_array_equal(pixels(obj[FIELD]["image"]), before)
    group = obj[FIELD]["group"]
    assert group.name == "AO Field Ball"
    assert {node.image for node in group.nodes if node.bl_idname == "ShaderNodeTexEnvironment"} == {obj[FIELD]["image"]}


def test_baked_again_replaces():
    obj = ball()
    group = bake_field(obj)
    assert bake_field(obj, field_resolution=16) == group
    (image,) = bpy.data.images
    assert image.name == "Ball AO Field" and image.size[1] == 4 * 18
    assert group.nodes["Resolution"].outputs[0].default_value == 16


def test_linked_duplicates_share_the_field():
    one = ball("One")
    two = add("Two", one.data, location=(3, 0, 0))
    squeezed = add("Squeezed", one.data, location=(6, 0, 0))
    squeezed.scale.z = 0.5
    bpy.context.view_layer.update()
    bake_field(one)
    assert two[FIELD]["image"] == one[FIELD]["image"]
    assert FIELD not in squeezed
    bake_field(two)
    (image,) = bpy.data.images
    assert two[FIELD]["image"] == one[FIELD]["image"] == image
    clear(one)
    assert FIELD not in one and two[FIELD]["image"] == image
    clear(two)
    assert not bpy.data.images


def test_same_seed_same_field_whatever_the_threads():
    obj = ball()
    found = []
    for threads in (1, 3):
        report_of(obj, threads=threads, seed=5)
        found.append((pixels(obj[FIELD]["image"]), obj[FIELD]["numbers"].to_dict()))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    assert found[0][1] == found[1][1]


def test_files(tmp_path):
    obj = ball()
    report = report_of(obj, output_directory=str(tmp_path))
    names = {"Ball_ao_field.json", "Ball_ao_field_occlusion.exr", "Ball_ao_field_direction.exr"}
    assert names <= {path.name for path in tmp_path.iterdir()}
    assert report.outputs[0] == "Ball AO Field"
    assert sorted(report.outputs[1:]) == sorted(str(path) for path in tmp_path.iterdir())
    clear(obj)
    assert len(list(tmp_path.iterdir())) == len(report.outputs) - 1


def test_names_that_files_cannot_tell_apart(tmp_path):
    one, two = ball("A/B"), ball("a:b", location=(3, 0, 0))
    for obj in (one, two):
        report_of(obj, output_directory=str(tmp_path))
    assert len([path for path in tmp_path.iterdir() if path.suffix == ".json"]) == 2


def test_closing_leaves_everything_as_it_was(tmp_path):
    obj = ball()
    work = field_generator(obj, output_directory=str(tmp_path))
    before = snapshot()
    fractions = [step.fraction for step in work]
    assert fractions == sorted(fractions) and fractions[0] == 0 and fractions[-1] <= 1
    clear(obj)
    for path in tmp_path.iterdir():
        path.unlink()
    bpy.data.node_groups.remove(bpy.data.node_groups["Spherical Cap Occlusion"])
    for steps in (1, 2, len(fractions) // 2):
        work = field_generator(obj, output_directory=str(tmp_path))
        list(itertools.islice(work, steps))
        work.close()
        assert differences(before, snapshot()) == []
        assert list(tmp_path.iterdir()) == []


def flat_to_a_point():
    return add_mesh("Bad", np.zeros((3, 3)), [(0, 1, 2)])


def without_faces():
    return add_mesh("Bad", np.eye(3), [])


def of_no_scale():
    obj = box("Bad")
    obj.scale = (1, 0, 1)
    return obj


def hidden():
    obj = box("Bad")
    obj.hide_set(True)
    return obj


def sheared():
    parent = add("Parent", None)
    parent.scale = (1, 3, 1)
    obj = box("Bad")
    obj.parent, obj.rotation_euler = parent, (0, 0, 0.7)
    return obj


def emptied():
    obj = box("Bad")
    obj.modifiers.new("Mask", "MASK")
    return obj


def not_finite():
    return add_mesh("Bad", [(0, 0, float("nan")), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (flat_to_a_point, ""),
        (without_faces, "no faces: add"),
        (of_no_scale, "scale of zero: set"),
        (hidden, "hidden"),
        (sheared, ""),
        (emptied, "no faces left after its modifiers"),
        (not_finite, "1 vertex whose coordinates are not finite"),
    ],
)
def test_refused(make, expected):
    obj = make()
    change_settings(samples=4, field_resolution=8)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = obj
    before = snapshot()
    message = error_of(bpy.ops.multibounce_ao.bake_field)
    assert_one_sentence(message)
    assert re.search(expected, message)
    assert differences(before, snapshot()) == []


def test_no_mesh_no_button():
    lamp = add("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    select(lamp)
    assert not bpy.ops.multibounce_ao.bake_field.poll()
    select(plate())
    assert bpy.ops.multibounce_ao.bake_field.poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not bpy.ops.multibounce_ao.bake_field.poll()
    bpy.ops.object.mode_set(mode="OBJECT")


def test_output_that_cannot_be_written(tmp_path):
    obj = ball()
    (tmp_path / "file").write_text("")
    change_settings(samples=4, field_resolution=8, output_directory=str(tmp_path / "file" / "below"))
    select(obj)
    assert re.search("choose another folder", error_of(bpy.ops.multibounce_ao.bake_field))
    assert FIELD not in obj and not bpy.data.images
