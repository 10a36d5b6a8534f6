# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry that makes bakes go dark or blotched elsewhere: what it comes to here, in numbers."""

import bpy
import numpy as np
import pytest

from .bakes import bake, f0, pixels, reports
from .meshes import add_mesh, add_uv_map, box, plate, positions


def texels(obj):
    """F0 of the texels that are baked (k,): beyond the margin, which is off, all channels are 0."""
    values = pixels(bpy.data.images[f"{obj.name} Multibounce AO"]).reshape(-1, 4)
    return values[values.any(axis=1), 0]


def cylinder():
    bpy.ops.mesh.primitive_cylinder_add(vertices=16)


def tube():
    bpy.ops.mesh.primitive_cylinder_add(vertices=16, end_fill_type="NOTHING")


def ball():
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6)


@pytest.mark.parametrize("add", [cylinder, tube, ball])
def test_coarse_smooth_meshes_have_no_terminator(add):
    """They are convex: every point of them sees all of the sky, the cylinder's rounded rims included."""
    add()
    obj = bpy.context.active_object
    obj.data.shade_smooth()
    bake(obj, samples=1024)
    vertices = f0(obj)
    bake(obj, samples=256, target="TEXTURE", resolution=96, margin=0)
    image = texels(obj)
    print(f"{obj.name}: lowest F0 of vertices {vertices.min():.4f}, of {len(image)} texels {image.min():.4f}")
    assert vertices.min() > 0.995
    assert len(image) > 3000
    assert image.min() > 0.995


def image_f0(obj):
    """(h, w), row 0 at the bottom."""
    return pixels(bpy.data.images[f"{obj.name} Multibounce AO"])[..., 0]


@pytest.mark.parametrize("gap", [1e-2, 1e-3, 2e-4])
def test_parallel_sheets(gap):
    """Two plates of size 2, one just above the other, both facing up. Inside the gap light comes through slits alone:
    at a distance d from a border no ray that rises more than gap / d gets out, sin^2 of it is less than (gap / d)^2."""
    lower, upper = plate("Lower", steps=8), plate("Upper", steps=8, location=(0, 0, gap))
    bake(lower, samples=1024)
    inner = np.abs(positions(lower)[:, :2]).max(axis=1) < 0.8
    assert f0(lower)[inner].max() <= (gap / 0.25) ** 2
    bake(upper, target="TEXTURE", resolution=16)
    assert image_f0(upper).min() == 1.0  # nothing lies above, however close what lies below


def test_sheets_in_one_place():
    """The same plate twice: neither darkens the other."""
    one, two = plate("One"), plate("Two")
    bake(one, two)
    assert f0(one).min() == f0(two).min() == 1.0


@pytest.mark.parametrize("shared", [False, True])
def test_double_sided_leaf(shared):
    """A leaf of two faces back to back over a wide floor: one sees all of the sky, the other nothing but the floor."""
    corners = [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    faces = [(0, 1, 2, 3), (3, 2, 1, 0)] if shared else [(0, 1, 2, 3), (7, 6, 5, 4)]
    leaf = add_mesh("Leaf", corners if shared else corners * 2, faces, smooth=False)
    add_uv_map(leaf.data, np.zeros((len(leaf.data.vertices), 2)))
    uv = np.float32([(0, 0), (0.5, 0), (0.5, 1), (0, 1), (1, 1), (0.5, 1), (0.5, 0), (1, 0)])
    leaf.data.uv_layers[0].uv.foreach_set("vector", uv.ravel())
    bake(leaf, use_ground_plane=True)
    np.testing.assert_array_equal(f0(leaf), [1] * 4 + [0] * 4)
    bake(leaf, target="TEXTURE", resolution=16, margin=0, use_ground_plane=True)
    np.testing.assert_array_equal(image_f0(leaf), np.tile(np.arange(16) < 8, (16, 1)))


def test_intersecting_meshes_have_no_black_seam():
    """A post stands in a floor, also below it; its sides lie within texels. Outside of it, but for its corners, a point
    by a side is that of a wall's foot: F0 = 1/2. Inside, nothing is seen, and nobody sees it."""
    floor = plate("Floor", half=2.0, steps=16)
    box("Post", low=(-0.53, -0.53, -1), high=(0.53, 0.53, 9))
    (report,) = reports(floor, target="TEXTURE", resolution=64, samples=256, margin=0)
    wide = 0.53 * 16  # half the post in texels
    inside = (2 * int(wide)) ** 2  # texels that lie in it altogether
    (warning,) = report.warnings
    print(warning, f"lowest F0 {image_f0(floor).min():.3f}")
    assert warning.startswith(f"{inside} of 4,096 texels lie inside of other surfaces")
    middle = image_f0(floor)[32 - 6 : 32 + 6, 32 - int(wide) - 1]  # the texels that its left side cuts
    np.testing.assert_allclose(middle, 0.5, atol=0.06)
    assert image_f0(floor).min() > 0.4
    assert report.f0["min"] > 0.4


def test_vertices_inside_other_meshes_take_the_values_around():
    floor = plate("Floor", half=2.0, steps=16)
    box("Post", low=(-0.6, -0.6, -1), high=(0.6, 0.6, 9))
    (report,) = reports(floor, samples=256)
    assert report.warnings[0].startswith("25 of 289 points lie inside of other surfaces")
    inside = np.abs(positions(floor)[:, :2]).max(axis=1) < 0.6
    ring = np.isclose(np.abs(positions(floor)[:, :2]).max(axis=1), 0.75)
    assert f0(floor)[ring].min() <= f0(floor)[inside].min() < f0(floor)[inside].max() <= f0(floor)[ring].max()


def test_a_flipped_face_takes_the_values_around():
    """One face of a ball looks inwards: it would be black."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6)
    obj = bpy.context.active_object
    obj.data.polygons[30].flip()
    obj.data.update()
    (report,) = reports(obj, target="TEXTURE", resolution=64)
    (warning,) = report.warnings
    print(warning)
    assert "lie inside of other surfaces" in warning
    assert image_f0(obj).min() > 0.99


def test_a_mesh_turned_inside_out_is_told():
    """As rooms are made; an object whose faces were turned by mistake is black, and hears why."""
    inward = box("Inward", inward=True)
    (report,) = reports(inward)
    assert report.f0["max"] == 0.0
    assert "Recalculate Outside" in report.warnings[0]
    outward = box("Outward", location=(9, 0, 0))
    assert reports(outward)[0].warnings == []
