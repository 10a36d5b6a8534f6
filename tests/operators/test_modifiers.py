# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes sit on the evaluated surface: what the artist sees, not what the mesh holds."""

import bpy
import numpy as np
import pytest

from .bakes import attribute, bake, f0, pixels, reports
from .meshes import add_mesh, add_uv_map, box, plate, positions


def warns_of_topology(report):
    return any("topology" in warning.lower() for warning in report.warnings)


@pytest.mark.parametrize(("inward", "expected"), [(True, 0), (False, 1)])
def test_subdivision_of_a_box(inward, expected):
    """Subdivided it is a ball: nothing of the sky is seen inside, all of it outside. Its cage lies further out."""
    obj = box(inward=inward)
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 3
    (report,) = reports(obj)
    np.testing.assert_allclose(f0(obj), expected, atol=1e-3)
    assert warns_of_topology(report)
    assert report.error is None
    assert len(attribute(obj)) == 24  # of the mesh, not of the modified one


def test_texture_of_a_subdivided_box():
    obj = box(inward=True)
    add_uv_map(obj.data, [(0.1, 0.1)] * 8).uv.foreach_set(
        "vector", np.array([[(i / 6, 0), (i / 6 + 0.15, 0), (i / 6 + 0.15, 1), (i / 6, 1)] for i in range(6)]).ravel()
    )
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    (report,) = reports(obj, target="TEXTURE", resolution=32, margin=0)
    assert "topology" not in " ".join(report.warnings)  # texels know nothing of it
    assert report.points > 500
    np.testing.assert_array_equal(pixels(bpy.data.images["Box Multibounce AO"])[..., 0], 0)


def test_mirrored_half_of_a_box():
    """Half a box, open at x = 0, is closed by its mirror image."""
    obj = box(low=(0, -1, -1), inward=True)
    bake(obj)
    obj.data.clear_geometry()
    corners = positions(whole := box("Whole", low=(0, -1, -1), inward=True))
    faces = [
        tuple(face.vertices) for face in whole.data.polygons if not np.all(corners[list(face.vertices)][:, 0] == 0)
    ]
    bpy.data.objects.remove(whole)
    obj.data.from_pydata(corners.tolist(), [], faces)
    assert len(faces) == 5
    bake(obj)
    assert f0(obj).min() > 0.02  # open
    obj.modifiers.new("Mirror", "MIRROR")
    (report,) = reports(obj)
    np.testing.assert_array_equal(f0(obj), 0)
    assert warns_of_topology(report)


def in_a_closet(obj):
    """Around the object where its mesh is: whoever bakes there gets black."""
    box("Closet", low=(-3, -3, -1), high=(3, 3, 1), inward=True)
    bake(obj)
    np.testing.assert_array_equal(f0(obj), 0)
    return obj


def displaced():
    obj = plate()
    modifier = obj.modifiers.new("Displace", "DISPLACE")
    modifier.direction, modifier.mid_level, modifier.strength = "Z", 0, 5
    return obj


def shape_key():
    obj = plate()
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Up")
    key.data.foreach_set("co", np.add(positions(obj), (0, 0, 5)).ravel())
    key.value = 1
    return obj


def armature():
    obj = plate()
    bones = bpy.data.armatures.new("Bones")
    rig = bpy.data.objects.new("Rig", bones)
    bpy.context.scene.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bones.edit_bones.new("Bone").tail = (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    rig.pose.bones["Bone"].location.y = 5  # along the bone
    obj.vertex_groups.new(name="Bone").add(range(25), 1.0, "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    return obj


@pytest.mark.parametrize("make", [displaced, shape_key, armature])
def test_deformed_surface_is_what_is_sampled(make):
    obj = make()
    box("Closet", low=(-3, -3, -1), high=(3, 3, 1), inward=True)
    (report,) = reports(obj)
    np.testing.assert_array_equal(f0(obj), 1)
    assert not warns_of_topology(report)
    assert obj.data.attributes["Multibounce AO"].domain == "POINT"
    obj.modifiers.clear()
    obj.shape_key_clear()
    bake(obj)
    np.testing.assert_array_equal(f0(obj), 0)


def test_modifier_off_in_the_viewport_does_not_count():
    """The bake shows what the viewport shows: as Blender's own bake of what is on screen would."""
    obj = displaced()
    obj.modifiers[0].show_viewport = False
    box("Closet", low=(-3, -3, -1), high=(3, 3, 1), inward=True)
    bake(obj)
    np.testing.assert_array_equal(f0(obj), 0)


def test_loose_vertices_and_edges():
    """They have no face, so no light to receive; the faces beside them are baked as ever."""
    obj = add_mesh("Mixed", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (5, 5, 5), (6, 6, 6)], [(0, 1, 2)])
    obj.data.edges.add(1)
    obj.data.edges[-1].vertices = (3, 4)
    obj.data.update()
    bake(obj)
    assert len(attribute(obj)) == 5
    np.testing.assert_array_equal(f0(obj)[:3], 1)
    assert np.isfinite(attribute(obj)).all()


def test_topology_of_a_surface_as_large_as_floats_hold():
    """The same bits at a scale whose squares overflow single precision."""
    found = []
    for name, scale in (("Plain", 1.0), ("Huge", 2.0**90)):
        obj = box(name, inward=True)
        obj.modifiers.new("Array", "ARRAY").count = 2
        obj.scale = (scale,) * 3
        (report,) = reports(obj, occluders="SELF")
        assert report.error is None and warns_of_topology(report)
        found.append(attribute(obj))
    np.testing.assert_allclose(*found, atol=1e-5)
