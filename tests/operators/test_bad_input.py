# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be baked gets one sentence that names the object and the remedy, and the file stays as it was."""

import math
import re

import bpy
import numpy as np
import pytest

from .bakes import bake, change_settings, f0, reports, select
from .meshes import add, add_mesh, plate, positions
from .refusals import assert_one_sentence, error_of
from .snapshot import differences, snapshot

TEXTURE = {"target": "TEXTURE", "resolution": 8}


def no_faces():
    return plate_without("faces")


def no_vertices():
    return plate_without("vertices")


def plate_without(what):
    obj = plate("Bad")
    if what == "faces":
        obj.data.clear_geometry()
        obj.data.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    else:
        obj.data.clear_geometry()
    return obj


def no_uv_map():
    obj = plate("Bad")
    obj.data.uv_layers.remove(obj.data.uv_layers[0])
    return obj


def set_uv(obj, change):
    layer = obj.data.uv_layers[0]
    uv = np.empty(2 * len(layer.uv), np.float32)
    layer.uv.foreach_get("vector", uv)
    layer.uv.foreach_set("vector", np.float32(change(uv)))
    return obj


def uvs_without_area():
    return set_uv(plate("Bad"), lambda uv: 0 * uv + 0.5)


def uvs_on_a_line():
    return set_uv(plate("Bad"), lambda uv: np.repeat(uv[::2], 2))


def uvs_outside():
    return set_uv(plate("Bad"), lambda uv: uv + 3)


def uvs_not_finite():
    return set_uv(plate("Bad"), lambda uv: uv * float("nan"))


def not_a_number():
    obj = plate("Bad")
    obj.data.vertices[3].co = (math.nan, 0, 0)
    return obj


def infinite():
    obj = plate("Bad")
    coordinates = np.float32(positions(obj))
    coordinates[3:5] = np.inf
    obj.data.vertices.foreach_set("co", coordinates.ravel())  # one by one, Blender would clamp them
    return obj


def nan_in_a_shape_key():
    obj = plate("Bad")
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Torn")
    key.data[3].co = (math.nan, 0, 0)
    key.value = 1
    return obj


def scale_of_zero():
    obj = plate("Bad")
    obj.scale = (1, 0, 1)
    return obj


def all_scales_zero():
    obj = plate("Bad")
    obj.scale = (0, 0, 0)
    return obj


def transform_not_finite():
    obj = plate("Bad")
    parent = add("Parent", None)
    obj.parent = parent
    obj.scale = parent.scale = (1e30, 1e30, 1e30)  # the product is more than a float holds
    return obj


def modifier_removes_all():
    obj = plate("Bad")
    obj.modifiers.new("Mask", "MASK").vertex_group = obj.vertex_groups.new(name="Nothing").name
    return obj


def uv_map_in_the_way():
    obj = plate("Bad")
    obj.data.uv_layers[0].name = "Multibounce AO"
    return obj


def vertex_group_in_the_way():
    obj = plate("Bad")
    obj.vertex_groups.new(name="Bent Cone").add([0, 1], 0.5, "REPLACE")
    return obj


def image_in_the_way():
    """A picture that somebody has painted."""
    bpy.data.images.new("Bad Multibounce AO", 4, 4).use_fake_user = True
    return plate("Bad")


CASES = [
    (no_faces, {}, "has no faces"),
    (no_vertices, {}, "has no faces"),
    (no_uv_map, TEXTURE, "no UV map: unwrap"),
    (uvs_without_area, TEXTURE, "no area in UV map 'UVMap': unwrap"),
    (uvs_on_a_line, TEXTURE, "no area in UV map 'UVMap': unwrap"),
    (uvs_outside, TEXTURE, "outside the 0-1 tile in UV map 'UVMap': pack"),
    (uvs_not_finite, TEXTURE, "UV map 'UVMap': unwrap"),
    (lambda: plate("Bad"), TEXTURE | {"uv_map": "Missing"}, "no UV map 'Missing': choose one of 'UVMap'"),
    (not_a_number, {}, "1 vertex whose coordinates are not finite.*: delete or move"),
    (infinite, {}, "2 vertices whose coordinates are not finite.*: delete or move"),
    (nan_in_a_shape_key, {}, "not finite.*: delete or move"),
    (not_a_number, TEXTURE, "not finite.*: delete or move"),
    (scale_of_zero, {}, "scale of zero: "),
    (all_scales_zero, {}, "scale of zero: "),
    (transform_not_finite, {}, "not finite: reset"),
    (modifier_removes_all, {}, "no faces left after its modifiers: "),
    (uv_map_in_the_way, {}, "'Multibounce AO'.*: rename"),
    (vertex_group_in_the_way, {}, "'Bent Cone'.*: rename"),
    (image_in_the_way, TEXTURE, "image 'Bad Multibounce AO'.*: rename"),
]


@pytest.mark.parametrize(("make", "settings", "expected"), CASES, ids=lambda value: getattr(value, "__name__", ""))
def test_object_that_cannot_be_baked(make, settings, expected):
    obj = make()
    change_settings(samples=8, **settings)
    select(obj)
    before = snapshot()
    message = error_of(bpy.ops.multibounce_ao.bake)
    assert_one_sentence(message)
    assert re.search(expected, message)
    assert differences(before, snapshot()) == []


@pytest.mark.parametrize(("make", "settings", "expected"), CASES, ids=lambda value: getattr(value, "__name__", ""))
def test_the_others_of_the_selection_are_baked(make, settings, expected):
    bad, good = make(), plate("Good", location=(50, 0, 0))
    if settings.get("uv_map"):
        good.data.uv_layers[0].name = settings["uv_map"]
    report_of_bad, report_of_good = reports(bad, good, **settings)
    assert_one_sentence(report_of_bad.error)
    assert re.search(expected, report_of_bad.error)
    assert (report_of_bad.rays, report_of_bad.f0, report_of_bad.outputs) == (0, None, [])
    assert report_of_good.error is None
    assert report_of_good.f0["mean"] == 1
    assert "multibounce_ao" in good
    assert "multibounce_ao" not in bad


def test_the_button_finishes_when_some_could_be_baked(capfd):
    bake(no_faces(), plate("Good"))
    output = "".join(capfd.readouterr())
    assert "Object 'Bad' has no faces" in output
    assert "Baked 'Good'" in output


def test_selection_without_a_mesh():
    select(add("Lamp", bpy.data.lights.new("Lamp", "POINT")))
    before = snapshot()
    for operator in (bpy.ops.multibounce_ao.bake, bpy.ops.multibounce_ao.clear):
        assert not operator.poll()
        assert re.search("No mesh is selected.*: select the objects", error_of(operator))
    select()
    assert not bpy.ops.multibounce_ao.bake.poll()
    select(bpy.data.objects["Lamp"])
    assert differences(before, snapshot()) == []


def test_edit_mode():
    obj = plate()
    select(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    before = snapshot()
    for operator in (bpy.ops.multibounce_ao.bake, bpy.ops.multibounce_ao.clear):
        assert "Object Mode" in error_of(operator)
    assert differences(before, snapshot()) == []


def test_object_hidden_in_the_viewport():
    """Blender does not evaluate it; scripts can ask for it all the same."""
    obj = plate("Bad")
    obj.hide_viewport = True
    (report,) = reports(obj)
    assert_one_sentence(report.error)
    assert "show it" in report.error


def test_degenerate_faces_do_no_harm():
    """Faces without area, of one point thrice, and two faces in one place."""
    obj = plate("Plate", steps=2)
    points = positions(obj)
    faces = [tuple(face.vertices) for face in obj.data.polygons]
    torn = add_mesh("Torn", [*points, (5, 0, 0), (6, 0, 0), (7, 0, 0), (5, 5, 0)], [*faces, (9, 10, 11), faces[0]])
    bake(torn)
    values = f0(torn)
    assert np.isfinite(values).all()
    assert ((values >= 0) & (values <= 1)).all()
    np.testing.assert_array_equal(values[4:9], 1)  # away from the doubled face
