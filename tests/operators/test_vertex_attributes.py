# SPDX-License-Identifier: GPL-3.0-or-later
"""Which attributes a vertex bake leaves, and what it leaves alone."""

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, attribute, bake
from .meshes import box, plate, smooth_by_angle


def domains(obj):
    attributes = obj.data.attributes
    return {(attributes[name].data_type, attributes[name].domain) for name in (MULTIBOUNCE_AO, BENT_CONE)}


def smooth_box():
    return box(smooth=True)


def flat_box():
    return box(smooth=False)


def box_with_one_flat_face():
    obj = box(smooth=True)
    obj.data.polygons[3].use_smooth = False
    return obj


def box_with_one_sharp_edge():
    obj = box(smooth=True)
    obj.data.edges[0].use_edge_sharp = True
    return obj


def box_with_custom_normals():
    obj = box(smooth=True)
    obj.data.normals_split_custom_set([(0, 0, 1)] * 12 + [(1, 0, 0)] * 12)
    return obj


def box_smooth_by_angle():
    obj = box(smooth=True)
    smooth_by_angle(obj)
    return obj


@pytest.mark.parametrize(
    ("make", "domain"),
    [
        (smooth_box, "POINT"),
        (flat_box, "CORNER"),
        (box_with_one_flat_face, "CORNER"),
        (box_with_one_sharp_edge, "CORNER"),
        (box_with_custom_normals, "CORNER"),
        (box_smooth_by_angle, "CORNER"),
    ],
)
def test_one_value_a_vertex_only_where_it_has_one_normal(make, domain):
    obj = make()
    bake(obj)
    assert domains(obj) == {("FLOAT_COLOR", domain)}
    assert len(attribute(obj)) == {"POINT": 8, "CORNER": 24}[domain]
    assert [a.name for a in obj.data.attributes if "Multibounce" in a.name or "Bent" in a.name] == [
        MULTIBOUNCE_AO,
        BENT_CONE,
    ]


def test_domain_follows_the_shading_when_baked_again():
    obj = box(smooth=True)
    bake(obj)
    obj.data.shade_flat()
    bake(obj)
    assert domains(obj) == {("FLOAT_COLOR", "CORNER")}
    obj.data.shade_smooth()
    bake(obj)
    assert domains(obj) == {("FLOAT_COLOR", "POINT")}


def test_artists_colours_stay_active_and_unchanged():
    obj = plate()
    colours = obj.data.color_attributes
    painted = np.linspace(0, 1, 25 * 4).astype(np.float32)
    colours.new("Rendered", "BYTE_COLOR", "CORNER")
    colours.new("Painted", "FLOAT_COLOR", "POINT").data.foreach_set("color", painted)
    attributes = obj.data.attributes
    attributes.active_color_name, attributes.default_color_name = "Painted", "Rendered"
    for _ in range(2):
        bake(obj)
        attributes = obj.data.attributes
        assert (attributes.active_color_name, attributes.default_color_name) == ("Painted", "Rendered")
        np.testing.assert_array_equal(attribute(obj, "Painted").ravel(), painted)


def test_a_mesh_without_active_colours_stays_so():
    """Else Vertex Paint would paint over the bake."""
    obj = plate()
    before = obj.data.attributes.active_color_name, obj.data.attributes.default_color_name
    bake(obj)
    assert (obj.data.attributes.active_color_name, obj.data.attributes.default_color_name) == before


def test_bakes_over_an_attribute_of_the_wrong_type():
    """A colour attribute that came with the file, say from an older export, as bytes on corners."""
    obj = plate()
    obj.data.color_attributes.new(MULTIBOUNCE_AO, "BYTE_COLOR", "CORNER")
    bake(obj)
    assert domains(obj) == {("FLOAT_COLOR", "POINT")}
    np.testing.assert_allclose(attribute(obj)[:, 0], 1.0, atol=1e-6)


def test_result_is_recorded_on_the_object():
    obj = plate()
    bake(obj, samples=128, seed=3)
    record = obj["multibounce_ao"].to_dict()
    assert record["points"] == 25
    assert record["rays"] == 25 * 128
    assert record["seconds"] > 0
    assert record["samples"] == 128
    assert record["seed"] == 3
    assert record["target"] == "VERTEX"
    assert record["f0"] == {"min": 1.0, "mean": 1.0, "max": 1.0}
    names = {p.identifier for p in bpy.context.scene.multibounce_ao.bl_rna.properties} - {"rna_type", "name"}
    others = {"height_map", "height_map_amplitude", "field_resolution", "use_field_volume"}  # of fits and fields
    assert names - others < set(record)
    assert not others & set(record)
    manifest_version = record["version"].split(".")
    assert len(manifest_version) == 3
    assert all(part.isdigit() for part in manifest_version)
