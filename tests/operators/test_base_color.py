# SPDX-License-Identifier: GPL-3.0-or-later
"""Base colours of the triangles that rays meet, in the order that rays number them by."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from .bakes import bake, operators
from .base_colors import GREY, TINT, image, image_node, matte, middles, mixed, paint, painted_material, read_albedo
from .materials import bsdf, material
from .meshes import add, add_mesh, add_uv_map, corner_vertices, plate, read


def read_occluders(*objects):
    """Vertices and triangles."""
    bpy.context.view_layer.update()
    return operators("occluder_reader").read_occluders(bpy.context.evaluated_depsgraph_get(), set(objects))[:2]


def at_corners(obj):
    """(corners, 3) of a mesh object without modifiers, and the warnings."""
    albedo, warnings = read_albedo(obj)
    obj.data.calc_loop_triangles()
    loops = read(obj.data.loop_triangles, "loops", 3, np.int32)
    colours = np.full((len(obj.data.loops), 3), np.nan)
    triangle = np.arange(len(loops))
    for corner, (v, w) in enumerate(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))):
        colours[loops[:, corner]] = albedo.at(triangle, np.full(len(loops), v), np.full(len(loops), w))
    return colours, warnings


def marked_mesh(kind):
    """An object whose colour is its local position, which is irregular and within the unit cube."""
    random = np.random.default_rng(5)
    vertices = random.uniform(0.05, 0.95, (60, 3)).astype(np.float32)
    obj = add_mesh("Marked", vertices, random.permuted(np.tile(np.arange(60), (40, 1)), axis=1)[:, :3])
    if kind == "attribute":
        paint(obj.data, vertices)
        obj.data.materials.append(painted_material())
        return obj
    # A ramp between the middles of four pixels: red along x, green along y.
    shown = image([[(0, 0, 0), (1, 0, 0)], [(0, 1, 0), (1, 1, 0)]])
    add_uv_map(obj.data, 0.25 + 0.5 * vertices[:, :2])
    made = matte("Ramp")
    node = image_node(made.node_tree, shown)
    made.node_tree.links.new(node.outputs["Color"], bsdf(made).inputs["Base Color"])
    obj.data.materials.append(made)
    return obj


def test_two_objects():
    first, second = plate("First", steps=1), plate("Second", steps=2, location=(5, 0, 0))
    first.data.materials.append(material(colour=(1, 0, 0, 1)))
    second.data.materials.append(material(colour=(0, 0.25, 0.5, 1)))
    vertices, triangles = read_occluders(first, second)
    is_second = vertices[triangles].mean(axis=1)[:, 0] > 2
    assert is_second.sum() == 8
    np.testing.assert_allclose(middles(first, second), np.where(is_second[:, None], (0, 0.25, 0.5), (1, 0, 0)))
    np.testing.assert_allclose(middles(second), [(0, 0.25, 0.5)] * 8)


@pytest.mark.parametrize("kind", ["attribute", "image"])
def test_every_point_of_every_instance(kind):
    """The colour of a point of the ray scene is its position before the instance's matrix, at x = 0, 100, 200 ..."""
    marked = marked_mesh(kind)
    collection = bpy.data.collections.new("Source")
    collection.objects.link(marked)
    turn = Matrix.Rotation(0.7, 4, (1, 2, 3))
    mirror = Matrix.Diagonal((-1, 1, 1, 1))
    matrices = [Matrix.Identity(4), turn, mirror, turn @ Matrix.Diagonal((2, -0.5, 1, 1)), mirror @ turn @ mirror]
    matrices = [Matrix.Translation((100 * i, 0, 0)) @ matrix for i, matrix in enumerate(matrices)]
    objects = [marked]
    for i, matrix in enumerate(matrices[1:]):
        if i % 2:
            obj = add(f"Instance {i}", None)
            obj.instance_type, obj.instance_collection = "COLLECTION", collection
        else:
            obj = add(f"Copy {i}", marked.data)
        obj.matrix_world = matrix
        objects.append(obj)
    # Others between them, one of which loses a face.
    plain = plate("Plain", steps=3, location=(-100, 0, 0))
    torn_vertices = [(0, 0, 0), (1, 0, 0), (np.nan, 1, 0), (0, 2, 0), (1, 2, 0), (0, 3, 0)]
    torn = add_mesh("Torn", torn_vertices, [(0, 1, 2), (3, 4, 5)])
    torn.location.x = -100
    objects += [plain, torn]

    vertices, triangles = read_occluders(*objects)
    albedo, _ = read_albedo(*objects)
    assert len(albedo) == len(triangles) == len(matrices) * 40 + 18 + 1
    random = np.random.default_rng(6)
    triangle = np.repeat(np.arange(len(triangles)), 4)
    v, w = random.dirichlet((1, 1, 1), len(triangle)).T[1:]
    corners = vertices[triangles[triangle]]
    point = (1 - v - w)[:, None] * corners[:, 0] + v[:, None] * corners[:, 1] + w[:, None] * corners[:, 2]
    expected = np.full((len(point), 3), GREY)
    number = np.rint(point[:, 0] / 100).astype(int)
    for i, matrix in enumerate(matrices):
        inverse = np.linalg.inv(np.array(matrix))
        expected[number == i] = point[number == i] @ inverse[:3, :3].T + inverse[:3, 3]
    if kind == "image":
        expected[number >= 0, 2] = 0
    error = np.abs(albedo.at(triangle, v, w) - expected).max()
    print(f"{kind}: largest error {error:.1e}")
    assert error < 2e-5  # the float32 of positions about 400


def test_several_slots():
    """Of the mesh, of the object, an empty one; faces beyond the last slot have the last, as in renders."""
    obj = plate(steps=2)
    red, green, blue = (material(name, (*colour, 1)) for name, colour in zip("RGB", np.eye(3), strict=True))
    for each in (red, None, green):
        obj.data.materials.append(each)
    obj.material_slots[2].link = "OBJECT"
    obj.material_slots[2].material = blue
    obj.data.polygons.foreach_set("material_index", [2, 0, 1, 9])
    expected = np.repeat([(0, 0, 1), (1, 0, 0), [GREY] * 3, (0, 0, 1)], 2, axis=0)
    np.testing.assert_array_equal(middles(obj), expected)


def test_materials_after_modifiers():
    obj = plate(steps=1)
    obj.data.materials.append(material(colour=(1, 0, 0, 1)))
    obj.data.materials.append(material(colour=(0, 1, 0, 1)))
    solidify = obj.modifiers.new("Solidify", "SOLIDIFY")
    solidify.thickness, solidify.material_offset, solidify.use_rim = 1, 1, False
    vertices, triangles = read_occluders(obj)
    is_lower = vertices[triangles].mean(axis=1)[:, 2] < -0.5
    assert is_lower.sum() == 2
    np.testing.assert_array_equal(middles(obj), np.where(is_lower[:, None], (0, 1, 0), (1, 0, 0)))


def geometry_nodes(obj, build):
    """``obj`` becomes what ``build`` links to the output of a node tree."""
    tree = bpy.data.node_groups.new("Made", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    build(tree, tree.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Nodes", "NODES").node_group = tree
    return obj


def test_material_that_geometry_nodes_set():
    def grid(tree, output):
        painted = tree.nodes.new("GeometryNodeSetMaterial")
        painted.inputs["Material"].default_value = material(colour=TINT)
        tree.links.new(tree.nodes.new("GeometryNodeMeshGrid").outputs["Mesh"], painted.inputs["Geometry"])
        tree.links.new(painted.outputs["Geometry"], output)

    carrier = geometry_nodes(add_mesh("Carrier", [], []), grid)
    carrier.data.materials.append(material(colour=(0, 0, 0, 1)))
    np.testing.assert_allclose(middles(carrier), [TINT[:3]] * 8)


def test_instances_of_geometry_nodes_have_the_materials_of_their_source():
    source = plate("Source", steps=2)
    source.data.materials.append(material(colour=TINT))

    def instance(tree, output):
        info = tree.nodes.new("GeometryNodeObjectInfo")
        info.inputs["Object"].default_value = source
        info.inputs["As Instance"].default_value = True
        tree.links.new(info.outputs["Geometry"], output)

    carrier = geometry_nodes(add_mesh("Carrier", [], []), instance)
    carrier.data.materials.append(material(colour=(0, 0, 0, 1)))
    np.testing.assert_allclose(middles(carrier), [TINT[:3]] * 8)


def test_text_and_curve():
    text = add("Text", bpy.data.curves.new("Text", "FONT"))
    text.data.body = "AO"
    curve = add("Curve", bpy.data.curves.new("Curve", "CURVE"))
    curve.data.bevel_depth = 0.1
    curve.data.splines.new("POLY").points.add(1)
    curve.data.splines[0].points[1].co = (1, 0, 0, 1)
    text.data.materials.append(material(colour=(0.25, 0.5, 1, 1)))
    colours = middles(text)
    assert len(colours) == len(read_occluders(text)[1]) > 50
    np.testing.assert_array_equal(colours, [(0.25, 0.5, 1)] * len(colours))
    colours = middles(curve)
    assert len(colours) == len(read_occluders(curve)[1]) > 0
    np.testing.assert_allclose(colours, GREY)


def test_nothing():
    albedo, warnings = read_albedo(add("Empty", None))
    assert len(albedo) == 0 and warnings == []


def test_bilinear_image():
    """2x2 pixels on a square: the colour at its middle is their mean, and at a pixel's middle that pixel."""
    pixels = np.array([[(1, 0, 0), (0, 1, 0)], [(0, 0, 1), (1, 1, 1)]], float)
    floor = plate(steps=1)
    made = matte()
    made.node_tree.links.new(image_node(made.node_tree, image(pixels)).outputs[0], bsdf(made).inputs["Base Color"])
    floor.data.materials.append(made)
    albedo, _ = read_albedo(floor)
    vertices, triangles = read_occluders(floor)
    random = np.random.default_rng(3)
    triangle, (v, w) = random.integers(0, 2, 500), random.dirichlet((1, 1, 1), 500).T[1:]
    a, b, c = np.moveaxis(vertices[triangles[triangle]], 1, 0)
    place = a + v[:, None] * (b - a) + w[:, None] * (c - a)
    x, y = np.clip((place[:, :2].T + 1) / 2 * 2 - 0.5, 0, 1)[..., None]
    expected = (1 - x) * (1 - y) * pixels[0, 0] + x * (1 - y) * pixels[0, 1]
    expected += (1 - x) * y * pixels[1, 0] + x * y * pixels[1, 1]
    np.testing.assert_allclose(albedo.at(triangle, v, w), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("space", "is_float", "expected"),
    [
        ("sRGB", False, ((128 / 255 + 0.055) / 1.055) ** 2.4),
        ("Non-Color", False, 128 / 255),
        ("Linear Rec.709", False, 128 / 255),
        ("Linear Rec.709", True, 128 / 255),
    ],
)
def test_colour_spaces(space, is_float, expected):
    floor = plate(steps=1)
    shown = image(np.full((2, 2, 3), 128 / 255), is_float=is_float, space=space)
    made = matte()
    made.node_tree.links.new(image_node(made.node_tree, shown).outputs[0], bsdf(made).inputs["Base Color"])
    floor.data.materials.append(made)
    np.testing.assert_allclose(middles(floor), expected, atol=1e-6)


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
def test_attributes(kind, domain):
    floor = plate(steps=3)
    colours = np.random.default_rng(4).random((16, 3))
    paint(floor.data, colours, kind=kind, domain=domain)
    floor.data.materials.append(painted_material())
    # A byte is 1/255 of the encoded range, whose slope is 2.4/1.055 at most.
    tolerance = 1e-6 if kind == "FLOAT_COLOR" else 0.5 / 255 * 2.4 / 1.055
    found, _ = at_corners(floor)
    np.testing.assert_allclose(found, colours[corner_vertices(floor.data)], atol=tolerance)


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
def test_what_comes_into_our_group(bounces):
    """A bake must not darken the colours of the next one."""
    floor = plate(steps=1)
    plate("Roof", location=(0, 0, 0.5))
    floor.data.materials.append(matte(colour=(0.9, 0.5, 0.3, 1)))
    made = matte()
    pixels = image(np.full((2, 2, 3), 0.25))
    made.node_tree.links.new(image_node(made.node_tree, pixels).outputs[0], bsdf(made).inputs["Base Color"])
    floor.data.materials.append(made)
    for index, expected in enumerate([(0.9, 0.5, 0.3), (0.25, 0.25, 0.25)]):
        floor.data.polygons[0].material_index = index
        bake(floor, bounces=bounces)
        np.testing.assert_allclose(middles(floor), [expected] * 2, atol=1e-6)


def test_our_factor_is_light_not_colour():
    floor = plate(steps=1)
    made = matte()
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = operators("material_nodes").GROUPS["FITTED"][0].ensure()
    mixed(tree, bsdf(made).inputs["Base Color"], "ShaderNodeMix", "MULTIPLY", 1.0, TINT, node.outputs["Factor"])
    floor.data.materials.append(made)
    np.testing.assert_allclose(middles(floor), [TINT[:3]] * 2, atol=1e-6)


def test_animated_colours_are_those_of_the_frame():
    floor = plate(steps=1)
    made = matte()
    socket = bsdf(made).inputs["Base Color"]
    for frame, value in ((1, 0.0), (11, 1.0)):
        socket.default_value = (value, value, value, 1)
        socket.keyframe_insert("default_value", frame=frame)
    floor.data.materials.append(made)
    bpy.context.scene.frame_set(11)
    np.testing.assert_allclose(middles(floor), 1)
    bpy.context.scene.frame_set(1)
    np.testing.assert_allclose(middles(floor), 0, atol=1e-6)


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="materials always have nodes")
def test_material_without_nodes():
    floor = plate(steps=1)
    made = bpy.data.materials.new("Plain")
    made.diffuse_color = TINT
    floor.data.materials.append(made)
    np.testing.assert_allclose(middles(floor), [TINT[:3]] * 2)
