# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a bake that goes on: a sketch near the truth, at the end the bake itself, and the same bits."""

import bpy
import numpy as np
import pytest

from .bakes import RADIOSITY, attribute, change_settings, f0, operators, pixels, select
from .meshes import box, corner_vertices, plate, positions, suzanne


def bake_seen(*objects, samples=64, **settings):
    """Bake as the window does. Returns what each picture showed after every step, and the preview."""
    change_settings(samples=samples, **settings)
    select(*objects)
    preview = operators("preview").Preview()
    chosen = operators("settings").BakeSettings.of(bpy.context.scene)
    shown = {obj: [] for obj in objects}
    for _ in operators("bake_job").bake(bpy.context, list(objects), chosen, preview=preview):
        for obj in objects:
            picture = preview.pictures.get(obj.session_uid)
            if picture is not None and picture.version:
                shown[obj].append(colours(picture))
    return shown, preview


def colours(picture):
    return picture.colours() if hasattr(picture, "colours") else {n: t.copy() for n, t in picture.tiles.items()}


def rms(difference):
    return float(np.sqrt(np.square(difference).mean()))


@pytest.mark.parametrize("smooth", [True, False], ids=["vertices", "corners"])
def test_vertices(smooth):
    """A floor under a box: at once about what it will be, and in the end exactly that."""
    floor = plate("Floor", half=3.0, steps=48)
    floor.data.polygons.foreach_set("use_smooth", [smooth] * 48**2)
    box("Box", low=(-1, -1, 0.2), high=(1, 1, 2))
    shown, preview = bake_seen(floor, samples=256)
    with_preview = attribute(floor)
    truth = with_preview[:, :1]
    sketch = shown[floor][0]
    assert sketch.shape == (len(truth), 3)
    assert 0.0 < rms(sketch - truth) < 0.06 < 0.2 < np.ptp(truth)
    np.testing.assert_array_equal(shown[floor][-1], np.repeat(truth, 3, axis=1).astype(np.float32))
    geometry = preview.pictures[floor.session_uid].geometry
    expected = positions(floor) if smooth else positions(floor)[corner_vertices(floor.data)]
    np.testing.assert_array_equal(geometry.positions, expected.astype(np.float32))
    a, b, c = np.moveaxis(expected[geometry.triangles], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(36.0)

    change_settings(samples=256)
    bpy.ops.multibounce_ao.bake()
    np.testing.assert_array_equal(attribute(floor), with_preview)


def test_modifiers_that_make_vertices(fitted):
    """The modified surface is shown: the original vertices as they are baked, between them what is between."""
    monkey = suzanne()
    monkey.modifiers.new("Subdivision", "SUBSURF").levels = 2
    shown, _ = bake_seen(monkey)
    last, truth = shown[monkey][-1], f0(monkey)
    assert len(last) == 7958
    assert np.quantile(np.abs(last[: len(truth), 0] - truth), 0.9) < 0.01
    assert last.min() >= truth.min() - 1e-6 and last.max() <= truth.max() + 1e-6


@pytest.mark.parametrize("largest", [1024, 32], ids=["all texels", "some texels"])
def test_texels(fitted, monkeypatch, largest):
    monkeypatch.setattr(operators("preview"), "LARGEST_IMAGE", largest)
    floor = plate("Floor", half=3.0)
    box("Box", low=(-1, -1, 0.2), high=(1, 1, 2))
    shown, _ = bake_seen(floor, samples=512, target="TEXTURE", resolution=64)
    truth = pixels(bpy.data.images["Floor Multibounce AO"])[:: 64 // min(64, largest), :: 64 // min(64, largest), :1]
    assert list(shown[floor][0]) == [1001]
    assert 0.0 < rms(shown[floor][0][1001][..., :3] - truth) < 0.1 < 0.2 < np.ptp(truth)
    np.testing.assert_allclose(shown[floor][-1][1001][..., :3], np.repeat(truth, 3, axis=2), atol=1e-6)


def test_radiosity_is_coloured():
    """Grey at first, then as it will be."""
    floor, wall = plate("Floor", half=2.0, steps=16), box("Wall", low=(0.5, -2, 0.1), high=(1, 2, 2))
    material = bpy.data.materials.new("Red")
    material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = 0.8, 0.1, 0.1, 1.0
    wall.data.materials.append(material)
    shown, _ = bake_seen(floor, bounces="RADIOSITY")
    truth = attribute(floor, RADIOSITY)[:, :3]
    assert np.ptp(shown[floor][0], axis=1).max() == 0.0
    assert np.ptp(truth, axis=1).max() > 0.1
    np.testing.assert_allclose(shown[floor][-1], truth, atol=1e-6)


def test_pictures_are_few_where_they_are_large(fitted, monkeypatch):
    """Two plates of 32 triangles, and one of 128."""
    first, second, large = plate("First"), plate("Second", location=(9, 0, 0)), plate("Large", steps=8)
    monkeypatch.setattr(operators("preview"), "MOST_TRIANGLES", 100)
    shown, preview = bake_seen(first, second, large, samples=16)
    assert set(preview.pictures) == {first.session_uid, second.session_uid}
    assert not shown[large]
    monkeypatch.setattr(operators("preview"), "MOST_TRIANGLES", 40)
    _, preview = bake_seen(first, second, samples=16)
    assert set(preview.pictures) == {second.session_uid}


def test_images_are_small_where_they_are_many(fitted, monkeypatch):
    """Two objects with two tiles each share what one image of 32 x 32 may take."""
    monkeypatch.setattr(operators("preview"), "MOST_TEXELS", 32**2)
    floors = plate("First"), plate("Second", location=(9, 0, 0))
    for floor in floors:
        uv = floor.data.uv_layers[0].uv
        for corner in uv[: len(uv) // 2]:
            corner.vector.x += 1
    shown, _ = bake_seen(*floors, target="TEXTURE", resolution=64, use_udim=True)
    for floor in floors:
        assert {number: image.shape for number, image in shown[floor][-1].items()} == dict.fromkeys(
            (1001, 1002), (16, 16, 4)
        )


@pytest.mark.parametrize("points", [1, 10**4, 10**6, 10**8])
@pytest.mark.parametrize("samples", [1, 16, 256, 4096])
def test_a_sketch_takes_a_small_part_of_the_rays(fitted, points, samples):
    change_settings(samples=samples)
    preview, chosen = operators("preview"), operators("settings").BakeSettings.of(bpy.context.scene)
    tracer = operators("tracer").Tracer(None, chosen, None, None)
    for most in (np.inf, 10**3):
        each, step = preview._effort(tracer, points, most)
        assert 1 <= each <= min(samples, 32)
        assert step >= 1.0
        assert points / step <= most
        assert points / step * each <= 1.0001 * max(preview.LEAST_RAYS, 0.02 * points * samples)


def test_all_are_sketched_before_the_first_is_baked(fitted):
    """One that cannot be baked does not stand in the way."""
    first, bad, last = plate("First"), box("No UV map", location=(9, 0, 0)), plate("Last", location=(18, 0, 0))
    change_settings(samples=256, target="TEXTURE", resolution=32)
    select(first, bad, last)
    preview = operators("preview").Preview()
    chosen = operators("settings").BakeSettings.of(bpy.context.scene)
    work = operators("bake_job").bake(bpy.context, [first, bad, last], chosen, preview=preview)
    next(step for step in work if step.rays)
    assert set(preview.pictures) == {first.session_uid, last.session_uid}
    assert all(picture.version for picture in preview.pictures.values())
    done = operators("progress").drive(work, lambda step: None)
    assert [report.error is None for report in done] == [True, False, True]
    assert len(done[0].warnings) == len(set(done[0].warnings))
