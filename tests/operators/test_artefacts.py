# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry that makes bakes go dark or blotched elsewhere: what it comes to here, in numbers."""

import bpy
import pytest

from .bakes import bake, f0, pixels


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
