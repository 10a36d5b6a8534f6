# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects block rays. A floor of 2 m under a roof of 20 km, a metre above it, sees nothing; else it sees all."""

import math

import bpy
import numpy as np
import pytest

from .bakes import bake, f0, reports
from .meshes import add, add_mesh, plate, suzanne

HALF = 1e4


@pytest.fixture
def floor(scene):
    return plate("Floor")


def roof(collection=None, **options):
    obj = plate("Roof", half=HALF, location=(0, 0, 1), **options)
    if collection is not None:
        bpy.context.scene.collection.objects.unlink(obj)
        collection.objects.link(obj)
    return obj


def new_collection(name="Roofs", linked=True):
    collection = bpy.data.collections.new(name)
    if linked:
        bpy.context.scene.collection.children.link(collection)
    return collection


def is_dark(floor):
    """Whether the roof was seen. Nothing between all and nothing can come out here."""
    values = f0(floor)
    assert np.ptp(values) < 1e-3
    assert values[0] < 1e-3 or values[0] == 1
    return values[0] < 1e-3


@pytest.mark.parametrize(
    ("hide", "dark"),
    [
        (lambda roof: None, True),
        (lambda roof: setattr(roof, "hide_render", True), False),
        (lambda roof: setattr(roof, "hide_viewport", True), False),
        (lambda roof: roof.hide_set(True), False),
        (lambda roof: setattr(roof.users_collection[0], "hide_render", True), False),
        (lambda roof: setattr(roof.users_collection[0], "hide_viewport", True), False),
        (lambda roof: setattr(bpy.context.view_layer.layer_collection.children["Roofs"], "exclude", True), False),
        (lambda roof: setattr(roof, "visible_camera", False), True),
        (lambda roof: setattr(roof, "hide_select", True), True),
        (lambda roof: setattr(roof, "display_type", "WIRE"), True),
    ],
    ids=[
        "as it is",
        "in renders",
        "in viewports",
        "by H",
        "collection in renders",
        "collection in viewports",
        "excluded",
        "from the camera",
        "from selection",
        "as wires",
    ],
)
def test_what_is_hidden_blocks_nothing(floor, hide, dark):
    hide(roof(new_collection()))
    bake(floor, occluders="VISIBLE")
    assert is_dark(floor) == dark


def test_an_object_in_a_hidden_and_in_a_shown_collection_is_shown(floor):
    hidden = new_collection("Hidden")
    obj = roof(hidden)
    new_collection("Shown").objects.link(obj)
    hidden.hide_render = True
    bake(floor)
    assert is_dark(floor)


@pytest.mark.parametrize(
    ("occluders", "roof_selected", "dark"),
    [
        ("SELF", False, False),
        ("SELF", True, False),
        ("SELECTED", False, False),
        ("SELECTED", True, True),
        ("VISIBLE", False, True),
        ("VISIBLE", True, True),
    ],
)
def test_occluders(floor, occluders, roof_selected, dark):
    over = roof()
    bake(*([floor, over] if roof_selected else [floor]), occluders=occluders)
    assert is_dark(floor) == dark


def test_selected_occluders_may_be_hidden_in_renders(floor):
    """Who says "the selected objects" means them."""
    obj = roof()
    obj.hide_render = True
    bake(floor, obj, occluders="SELECTED")
    assert is_dark(floor)


def curve_roof():
    curve = bpy.data.curves.new("Roof", "CURVE")
    curve.dimensions = "2D"
    curve.fill_mode = "BOTH"
    spline = curve.splines.new("POLY")
    spline.points.add(3)
    spline.points.foreach_set("co", [-HALF, -HALF, 0, 1, HALF, -HALF, 0, 1, HALF, HALF, 0, 1, -HALF, HALF, 0, 1])
    spline.use_cyclic_u = True
    return add("Roof", curve, (0, 0, 1))


def surface_instance():
    """A triangle that carries the roof on its face."""
    carrier = add_mesh("Carrier", [(-3e-4, -1e-4, 1), (3e-4, -1e-4, 1), (0, 2e-4, 1)], [(0, 1, 2)])
    carrier.instance_type = "FACES"
    child = plate("Roof", half=HALF)
    child.parent = carrier
    return carrier


def collection_instance(source=None):
    collection = new_collection(linked=False)
    source = source or plate("Roof", half=HALF)
    bpy.context.scene.collection.objects.unlink(source)
    collection.objects.link(source)
    empty = add("Instance", None, (0, 0, 1))
    empty.instance_type = "COLLECTION"
    empty.instance_collection = collection
    return empty


def geometry_nodes(obj, *, instance_of=None):
    """``obj`` becomes: a grid made by nodes, or an instance of an object."""
    tree = bpy.data.node_groups.new("Roof", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    if instance_of is None:
        source = tree.nodes.new("GeometryNodeMeshGrid")
        source.inputs["Size X"].default_value = source.inputs["Size Y"].default_value = 2 * HALF
        geometry = source.outputs["Mesh"]
    else:
        source = tree.nodes.new("GeometryNodeObjectInfo")
        source.inputs["Object"].default_value = instance_of
        source.inputs["As Instance"].default_value = True
        geometry = source.outputs["Geometry"]
    tree.links.new(geometry, tree.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree
    return obj


def geometry_nodes_mesh():
    return geometry_nodes(add_mesh("Carrier", [], [], location=(0, 0, 1)))


def geometry_nodes_instance():
    source = plate("Roof", half=HALF)
    source.hide_render = True  # as artists keep what they scatter
    return geometry_nodes(add_mesh("Carrier", [], [], location=(0, 0, 1)), instance_of=source)


def nested_instance():
    inner = collection_instance()
    inner.location = (0, 0, 0)
    return collection_instance(inner)


@pytest.mark.parametrize(
    "make",
    [curve_roof, surface_instance, collection_instance, geometry_nodes_mesh, geometry_nodes_instance, nested_instance],
)
def test_everything_with_faces_blocks(floor, make):
    carrier = make()
    bake(floor)
    assert is_dark(floor)
    carrier.hide_render = True
    bake(floor)
    assert not is_dark(floor)


def test_instances_of_the_baked_object_belong_to_it(floor):
    """SELF means the object with the instances that it makes."""
    source = plate("Roof", half=HALF)
    source.location.z = 1
    tree = geometry_nodes(floor, instance_of=source).modifiers[0].node_group
    join = tree.nodes.new("GeometryNodeJoinGeometry")
    group_input = tree.nodes.new("NodeGroupInput")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    info, output = tree.nodes["Object Info"], tree.nodes["Group Output"]
    info.transform_space = "RELATIVE"
    tree.links.new(info.outputs["Geometry"], join.inputs[0])
    tree.links.new(group_input.outputs[0], join.inputs[0])
    tree.links.new(join.outputs[0], output.inputs[0])
    bake(floor, occluders="SELF")
    assert is_dark(floor)


def test_child_hidden_in_renders_is_left_out_of_collection_instances(floor):
    empty = collection_instance()
    empty.instance_collection.objects[0].hide_render = True
    bake(floor)
    assert not is_dark(floor)


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize(("turned", "dark"), [(True, True), (False, False)])
def test_ignore_backfaces(floor, turned, dark, mirror):
    """The roof's front is its upper side: turned over, it faces the floor. A mirroring scale leaves it where it is."""
    obj = roof()
    obj.rotation_euler.x = np.pi if turned else 0
    obj.scale = (mirror, 1, 1)
    bake(floor, ignore_backfaces=True)
    assert is_dark(floor) == dark


def test_backfaces_of_mirrored_instances(floor):
    empty = collection_instance()
    empty.scale = (1, -1, 1)
    bake(floor, ignore_backfaces=True)
    assert not is_dark(floor)
    empty.rotation_euler.x = np.pi
    bake(floor, ignore_backfaces=True)
    assert is_dark(floor)


def test_ground_plane_lies_under_the_lowest_of_all_baked_objects(floor):
    ceiling = plate("Ceiling", location=(100, 0, 0))
    ceiling.rotation_euler = (np.pi, 0, 0)
    bake(floor, ceiling, use_ground_plane=True)
    np.testing.assert_array_equal(f0(floor), 1)
    np.testing.assert_allclose(f0(ceiling), 0, atol=1e-6)
    # Lower still, but not baked.
    plate("Cellar", location=(0, 0, -5), half=0.01)
    bake(ceiling, use_ground_plane=True, max_distance=1.0)
    np.testing.assert_allclose(f0(ceiling), 0, atol=1e-6)


def test_baked_object_that_is_hidden_in_renders(floor):
    """It is baked, with a warning, and blocks its own light but not that of others."""
    obj = suzanne()
    bake(obj)
    expected = f0(obj)
    obj.hide_render = True
    (report,) = reports(obj)
    assert any("renders" in warning for warning in report.warnings)
    np.testing.assert_array_equal(f0(obj), expected)

    hidden_roof = roof()
    hidden_roof.hide_render = True
    bake(floor, hidden_roof)
    assert not is_dark(floor)
    assert hidden_roof["multibounce_ao"]["f0"]["max"] == 1


def test_occluder_with_bad_coordinates_is_told(floor):
    low, high = (-HALF, -HALF, 2), (HALF, -HALF, 2)
    vertices = [(0, 0, 1), (1, 0, 1), (math.nan, 1, 1), low, high, (0, HALF, 2)]
    obj = add_mesh("Torn", vertices, [(0, 1, 2), (3, 4, 5)])
    (report,) = reports(floor)
    assert any("'Torn'" in warning for warning in report.warnings)
    assert is_dark(floor)
    bpy.data.objects.remove(obj)
    (report,) = reports(floor)
    assert report.warnings == []
