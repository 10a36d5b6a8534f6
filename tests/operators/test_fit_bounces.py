# SPDX-License-Identifier: GPL-3.0-or-later
"""Fitting bounce curves: what is simulated, and what is left behind."""

import csv
import io
from pathlib import Path

import bpy
import numpy as np
import pytest

from .bakes import bake, operators, pixels, select
from .fits import FIT, fit, relief, report_of, set_heights, trench
from .meshes import add_mesh, box, plate
from .refusals import error_of

COEFFICIENTS = {"a", "b", "f0_factor", "f0_exponent"}


def curves(text):
    """Columns by name; empty cells are NaN."""
    rows = list(csv.DictReader(io.StringIO(text)))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def test_mesh():
    select(trench())
    stored = fit()
    assert stored["source"] == "Trench"
    assert (stored["samples"], stored["bounces"], stored["bins"]) == (16, 20, 100)
    assert all(np.isfinite(stored[name]) for name in COEFFICIENTS)
    text = curves(bpy.data.texts["Trench Bounce Curves"].as_string())
    assert text["count"].sum() == stored["points"] > 10000
    assert not np.isnan(text["F0"][text["count"] > 0]).any()


def test_residuals_are_those_of_the_curves():
    """The stored rms are the weighted differences of the CSV's own columns, and less than the published fit's."""
    from core import multibounce

    select(trench())
    stored = fit(samples=64)
    text = curves(bpy.data.texts["Trench Bounce Curves"].as_string())
    used = text["count"] > 0
    ao, count = text["ao"][used], text["count"][used]
    coefficients = multibounce.Coefficients(**{name: stored[name] for name in COEFFICIENTS})

    def rms(fitted, measured):
        return np.sqrt(np.average(np.square(fitted - measured), weights=count))

    for name, form in (("F0", multibounce.f0), ("F1", multibounce.f1)):
        mine, published = rms(form(ao, coefficients), text[name][used]), rms(form(ao), text[name][used])
        print(f"{name}: rms {mine:.4f}, of the published fit {published:.4f}")
        assert stored[f"{name.lower()}_rms"] == pytest.approx(mine, abs=1e-5)
        assert mine < published
        np.testing.assert_allclose(text[f"fitted_{name}"][used], form(ao, coefficients), atol=1e-6)
    assert (text["sum"][used] <= 1 + 1e-5).all()


@pytest.mark.parametrize("is_float", [True, False])
def test_height_map(is_float):
    """It comes before the active object."""
    select(plate())
    stored = fit(height_map=relief(is_float=is_float), height_map_amplitude=0.3)
    assert (stored["source"], stored["points"]) == ("Relief", 24 * 16)
    flat = fit(height_map_amplitude=0.15)
    assert flat["a"] != stored["a"]
    assert {"Relief Bounce Curves", "Relief"} == {image.name for image in bpy.data.images}


def test_height_map_against_core():
    """The image reaches the simulation the right way round, with the amplitude that is set."""
    from core.bounce_curves import bin_bounces, fit_curves
    from core.height_map import HeightMap
    from core.simulation import simulate_height_map

    heights = np.random.default_rng(0).random((12, 20)).astype(np.float32)
    set_heights(image := bpy.data.images.new("Relief", 20, 12, float_buffer=True), heights)
    stored = fit(height_map=image, height_map_amplitude=0.2, seed=3)
    work = simulate_height_map(
        HeightMap(heights, bpy.context.scene.multibounce_ao.height_map_amplitude), samples=16, seed=3
    )
    expected = fit_curves(bin_bounces(operators("progress").drive(work, lambda progress: None)))
    assert {name: stored[name] for name in COEFFICIENTS} == {name: getattr(expected, name) for name in COEFFICIENTS}


def test_colours_of_a_height_map_are_averaged():
    heights = np.random.default_rng(1).random((8, 8)).astype(np.float32)
    set_heights(grey := bpy.data.images.new("Grey", 8, 8, float_buffer=True), heights)
    colour = bpy.data.images.new("Colour", 8, 8, float_buffer=True)
    rgba = np.stack((1.5 * heights, heights, 0.5 * heights, np.zeros_like(heights)), axis=-1)
    colour.pixels.foreach_set(rgba.ravel())
    read = operators("fit_sources")._read_heights
    np.testing.assert_allclose(read(colour), read(grey), rtol=0, atol=1e-6)


def test_large_height_map_is_scaled_down():
    image = relief(size=(1024, 256))
    report = report_of(image, samples=2, height_map_amplitude=0.1)
    limit = operators("fit_sources").IMAGE_POINTS
    assert 0.9 * limit < report.points <= limit
    (warning,) = report.warnings
    assert "1024 x 256" in warning


def coefficients(**settings):
    stored = fit(**settings)
    return {name: stored[name] for name in COEFFICIENTS}


def test_modifiers_and_instances_count():
    """A plate becomes trenches by what its modifiers and instances make."""
    parent, wall = plate("Floor", half=2), box("Wall", low=(-1.8, -0.05, 0), high=(1.8, 0.05, 1))
    collection = bpy.data.collections.new("Walls")
    collection.objects.link(wall)
    bpy.context.scene.collection.objects.unlink(wall)
    bpy.context.scene.collection.children.link(collection)
    array = wall.modifiers.new("Array", "ARRAY")
    array.count, array.use_relative_offset, array.use_constant_offset = 6, False, True
    array.constant_offset_displace = (0, 0.3, 0)
    select(wall)
    assert np.isfinite(list(coefficients(occluders="SELF").values())).all()
    select(parent)
    assert "cannot be fitted" in error_of(bpy.ops.multibounce_ao.fit_bounces)  # nothing shades a plane


@pytest.mark.parametrize(
    ("settings", "roof", "shaded"),
    [
        ({"occluders": "SELF"}, "visible", False),
        ({"occluders": "SELECTED"}, "visible", False),
        ({"occluders": "SELECTED"}, "selected", True),
        ({"occluders": "VISIBLE"}, "visible", True),
        ({"occluders": "VISIBLE"}, "hidden", False),
        ({"occluders": "SELF", "use_ground_plane": True}, "visible", True),
    ],
)
def test_occluders(settings, roof, shaded):
    """Alone, or among a roof or a floor: what they take of the sky, and give back, is in the curves."""
    obj, over = trench(), plate("Roof", half=20, location=(0, 0, 3))
    select(obj)
    alone = coefficients(occluders="SELF")
    over.hide_render = roof == "hidden"
    select(*([obj, over] if roof == "selected" else [obj]))
    among = coefficients(**settings)
    assert (among != alone) == shaded


def test_the_wall_of_a_trench_among_the_rest_of_it():
    """Of a square trench's opening a wall sees 1 - 1/sqrt(2) (Hottel's crossed strings). The other wall and the floor
    send their light back: all bounces sum to 1."""
    sides = {"Wall": ((0, 1), (0, 0)), "Floor": ((0, 0), (1, 0)), "Far Wall": ((1, 0), (1, 1))}
    made = []
    for name, ((x0, z0), (x1, z1)) in sides.items():
        half = 1 if name == "Wall" else 100
        corners = [(x0, half, z0), (x0, -half, z0), (x1, -half, z1), (x1, half, z1)]
        made.append(add_mesh(name, corners, [(0, 1, 2, 3)], smooth=False))
    select(made[0])
    fit(samples=64, occluders="VISIBLE")
    text = curves(bpy.data.texts["Wall Bounce Curves"].as_string())
    used = text["count"] > 0
    direct, total = (np.average(text[name][used], weights=text["count"][used]) for name in ("F0", "sum"))
    print(f"mean F0 of the wall {direct:.5f} of {1 - 0.5**0.5:.5f}, sum of 20 bounces {total:.5f}")
    assert direct == pytest.approx(1 - 0.5**0.5, abs=0.002)
    assert total == pytest.approx(1, abs=0.005)


def test_same_bits_whatever_the_threads():
    obj = trench()
    one, three = (report_of(obj, threads=threads) for threads in (1, 3))
    assert one.fit == three.fit
    assert report_of(obj, seed=1).fit != one.fit


def test_the_plot_is_packed_and_saved(tmp_path):
    select(trench())
    stored = fit()
    image = bpy.data.images["Trench Bounce Curves"]
    assert stored["image"] == image
    assert tuple(image.size) == (1280, 960)
    assert (image.colorspace_settings.name, image.is_float, bool(image.packed_file)) == ("sRGB", False, True)
    before = pixels(image)
    np.testing.assert_array_equal(before[:12], 1)  # paper below the axes' label
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    np.testing.assert_array_equal(pixels(bpy.data.images["Trench Bounce Curves"]), before)
    assert bpy.context.scene[FIT]["a"] == stored["a"]
    assert "Trench Bounce Curves" in bpy.data.texts


def test_files(tmp_path):
    folder = tmp_path / "curves"
    select(trench("A/b:c"))
    report = report_of(bpy.context.active_object, output_directory=str(folder))
    csv_path, png_path = report.outputs
    assert sorted(str(path) for path in folder.iterdir()) == sorted(report.outputs)
    assert csv_path.endswith("_bounce_curves.csv") and png_path.endswith("_bounce_curves.png")
    assert curves(Path(csv_path).read_text(encoding="utf-8"))["count"].sum() == report.points
    (image,) = bpy.data.images
    assert image.name == "A/b:c Bounce Curves"
    assert bpy.path.abspath(image.filepath) == png_path
    assert not bpy.data.texts
    in_file = pixels(image)

    packed = report_of(bpy.context.active_object, output_directory="")
    assert packed.outputs == ["A/b:c Bounce Curves"] * 2
    (image,) = bpy.data.images
    np.testing.assert_array_equal(pixels(image), in_file)


def test_again_replaces_what_was_there():
    obj = trench()
    select(obj)
    first = fit()
    material = bpy.data.materials.new("Shows the plot")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5.0
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = first["image"]
    second = fit(samples=8)
    assert second["a"] != first["a"]
    assert [image.name for image in bpy.data.images] == ["Trench Bounce Curves"]
    assert node.image == second["image"]
    assert len(bpy.data.texts) == 1


def test_materials_follow_the_fit_and_its_removal():
    obj = trench()
    obj.data.materials.append(bpy.data.materials.new("Stone"))
    bake(obj, samples=8, bounces="FITTED")
    nodes = bpy.data.node_groups["Multibounce AO Fit"].nodes
    published = nodes["A"].outputs[0].default_value
    select(obj)
    stored = fit()
    assert nodes["A"].outputs[0].default_value == pytest.approx(stored["a"], rel=1e-6)
    assert nodes["F0 factor"].outputs[0].default_value == pytest.approx(stored["f0_factor"], rel=1e-6)
    assert bpy.ops.multibounce_ao.clear_fit() == {"FINISHED"}
    assert FIT not in bpy.context.scene
    assert nodes["A"].outputs[0].default_value == published
    assert not bpy.ops.multibounce_ao.clear_fit.poll()


def test_shown_in_an_open_image_editor():
    windows = bpy.context.window_manager.windows
    if not windows:
        pytest.skip("no window to show it in")
    area = windows[0].screen.areas[0]
    area.ui_type = "IMAGE_EDITOR"
    select(trench())
    fit()
    assert area.spaces.active.image == bpy.data.images["Trench Bounce Curves"]
