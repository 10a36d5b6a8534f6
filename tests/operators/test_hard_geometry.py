# SPDX-License-Identifier: GPL-3.0-or-later
"""What real files hold: concave faces, thin sheets, stray vertices, far neighbours, deformed cages."""

import bpy
import numpy as np
import pytest

from .bakes import bake, f0, reports
from .meshes import add_mesh, box, corner_vertices, plate


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def geometry_nodes(obj, kind):
    """A geometry-nodes modifier of one node."""
    tree = bpy.data.node_groups.new(kind, "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    start, node, end = (tree.nodes.new(name) for name in ("NodeGroupInput", kind, "NodeGroupOutput"))
    tree.links.new(start.outputs[0], node.inputs[0])
    tree.links.new(node.outputs[0], end.inputs[0])
    obj.modifiers.new(kind, "NODES").node_group = tree


def test_concave_face_with_walls():
    """A U-shaped floor of one face: each outer corner lies between two walls, so at most a quarter of its sky is open.
    The face's own centre lies outside of it, behind a wall."""
    outline = [(0, 0), (6, 0), (6, 5), (5, 5), (5, 1), (1, 1), (1, 5), (0, 5)]
    count = len(outline)
    vertices = [(x, y, 0) for x, y in outline] + [(x, y, 3) for x, y in outline]
    walls = [(i, i + count, (i + 1) % count + count, (i + 1) % count) for i in range(count)]
    obj = add_mesh("U", vertices, [tuple(range(count)), *walls], smooth=False)
    bake(obj, samples=1024)
    floor = dict(zip(corner_vertices(obj.data)[:count].tolist(), f0(obj)[:count], strict=True))
    convex = [floor[i] for i in (0, 1, 2, 3, 6, 7)]
    assert max(convex) < 0.25
    # mirrored in x = 3: the same light
    for left, right in ((0, 1), (7, 2), (6, 3), (5, 4)):
        assert floor[left] == pytest.approx(floor[right], abs=0.02)


@pytest.mark.parametrize("offset", [-1, 0, 1])
def test_thickened_plate_is_baked_on_the_side_that_it_faces(offset):
    """The upper sheet sees the whole sky, the lower one only the floor close below."""
    obj = plate(steps=8)
    plate("Floor", half=5, steps=1, location=(0, 0, -0.2))
    modifier = obj.modifiers.new("Solidify", "SOLIDIFY")
    modifier.thickness, modifier.offset = 0.02, offset
    bake(obj)
    # the rim has tilted normals of its own
    inner = np.abs(np.array([v.co[:2] for v in obj.data.vertices])).max(axis=1) < 0.99
    np.testing.assert_allclose(f0(obj)[inner], 1.0, atol=1e-6)


def test_shape_key_under_subdivision():
    """A plate that its shape key slides out from under a roof: the cage's vertices are baked where they end up."""
    obj = plate(steps=4)
    box("Roof", low=(-1.2, -1.2, 0.1), high=(1.2, 1.2, 0.3))
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Out")
    key.data.foreach_set("co", np.add([v.co for v in obj.data.vertices], (3, 0, 0)).ravel())
    key.value = 1
    bake(obj, samples=256)
    plain = f0(obj)
    obj.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    (report,) = reports(obj, samples=256)
    assert rms(f0(obj) - plain) < 0.01
    assert "topology" in report.warnings[0]


def test_subdivided_cage_has_the_values_of_its_vertices_on_the_smooth_surface():
    """Not those of the nearest surface point: what the artist sees at a cage's vertex is where subdivision drew it."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.active_object
    obj.data.shade_smooth()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bake(obj, samples=256)
    cage = f0(obj)
    applied = bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    obj.modifiers.clear()
    obj.data = applied
    bake(obj, samples=256)
    assert rms(cage - f0(obj)[: len(cage)]) < 0.01


def test_the_way_to_a_far_surface_is_told():
    obj = plate(steps=1)
    obj.modifiers.new("Triangulate", "TRIANGULATE")  # another topology, the same surface
    obj.modifiers.new("Displace", "DISPLACE").strength = 0.4
    obj.modifiers["Displace"].mid_level = 0.0
    (report,) = reports(obj)
    assert "0.4 away" in report.warnings[0]


def test_flipped_faces_keep_the_values_of_their_vertices():
    """Equal counts, another order of corners. A wall of height h = 90 stands at x = -1: at its foot half of the sky is
    open, at distance d = 2 (1 + d / sqrt(d^2 + h^2)) / 2 of it (closed form of an endless wall)."""
    obj = plate(steps=1)
    obj.data.polygons[0].use_smooth = False
    add_mesh("Wall", [(-1, -90, -90), (-1, 90, -90), (-1, 90, 90), (-1, -90, 90)], [(0, 1, 2, 3)])
    geometry_nodes(obj, "GeometryNodeFlipFaces")
    bake(obj, samples=1024)
    x = np.array([obj.data.vertices[i].co.x for i in corner_vertices(obj.data)])
    np.testing.assert_allclose(f0(obj)[x < 0], 0.5, atol=0.01)
    np.testing.assert_allclose(f0(obj)[x > 0], (1 + 2 / np.hypot(2, 90)) / 2, atol=0.01)


def test_stray_vertex_does_not_blur_contacts():
    """The ray offset follows the faces; so does the ground plane."""
    obj = plate(steps=8)
    box("Lid", low=(-0.5, -0.5, 0.01), high=(0.5, 0.5, 0.3))
    bake(obj, samples=256)
    clean = f0(obj)
    obj.data.vertices.add(1)
    obj.data.vertices[-1].co = (1000, 0, -1000)
    bake(obj, samples=256, use_ground_plane=True)
    assert rms(f0(obj)[:-1] - clean) < 0.01


@pytest.mark.parametrize("distance", [1e5, 1e7])
def test_a_far_neighbour_changes_nothing(distance):
    obj = plate(steps=8)
    box("Lid", low=(-0.5, -0.5, 0.1), high=(0.5, 0.5, 0.3))
    bake(obj, samples=256)
    clean = f0(obj)
    box("Far", location=(distance, 0, 0))
    bake(obj, samples=256)
    assert np.abs(f0(obj) - clean).max() < 0.01


def test_an_object_that_casts_no_shadow_blocks_itself_alone():
    room = box("Room", inward=True)
    room.visible_shadow = False
    inside = plate(half=0.5)
    bake(room, occluders="SELF")
    np.testing.assert_array_equal(f0(room), 0)
    bake(inside, occluders="VISIBLE")
    np.testing.assert_array_equal(f0(inside), 1)


def test_zero_scale_under_a_rotated_parent_is_refused():
    obj = plate()
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    parent.rotation_euler = (0.3, 0.4, 0.5)
    obj.parent = parent
    obj.scale = (1, 0, 1)
    (report,) = reports(obj)
    assert "scale of zero" in report.error and "'Plate'" in report.error
    obj.scale = (1e-3, 1e-3, 1e-3)
    (report,) = reports(obj)
    assert report.error is None


def test_overlapping_layouts_are_told_and_others_are_not():
    def warnings(corners):
        obj = plate(steps=2)
        layer = obj.data.uv_layers[0]
        for face in obj.data.polygons:
            for loop, corner in zip(face.loop_indices, corners, strict=True):
                layer.uv[loop].vector = corner
        (report,) = reports(obj, target="TEXTURE", resolution=32)
        bpy.data.objects.remove(obj)
        return " ".join(report.warnings)

    assert "overlaps itself" in warnings([(0.1, 0.1), (0.4, 0.1), (0.4, 0.4), (0.1, 0.4)])  # four faces on one spot
    flat = plate(steps=2)
    (report,) = reports(flat, target="TEXTURE", resolution=32)
    assert report.warnings == []
    reaching = warnings([(0.5, 0.5), (3, 0.5), (3, 3), (0.5, 3)])
    assert "out of the 0-1 tile" in reaching
