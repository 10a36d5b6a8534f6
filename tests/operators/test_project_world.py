# SPDX-License-Identifier: GPL-3.0-or-later
"""Project World: the light of all kinds of Worlds, and nothing left behind."""

import bpy
import numpy as np
import pytest

from .bakes import operators
from .refusals import error_of
from .snapshot import differences, snapshot
from .worlds import background, directions_world, picture_world, world

STORED = "multibounce_ao_world"
Y0, Y1 = 0.5 / np.sqrt(np.pi), np.sqrt(3 / np.pi) / 2


def project():
    """The button; returns the coefficients (9, 3)."""
    assert bpy.ops.multibounce_ao.project_world() == {"FINISHED"}
    stored = bpy.context.scene[STORED]
    return np.transpose([list(stored[name]) for name in ("red", "green", "blue")])


def of_plain(*colour):
    return np.vstack((np.array(colour) / Y0, np.zeros((8, 3))))


def test_plain_colour():
    world((0.2, 0.5, 1.0), strength=3)
    np.testing.assert_allclose(project(), of_plain(0.6, 1.5, 3.0), rtol=1e-6)
    assert bpy.context.scene[STORED]["world"] == "World"


def test_directions_are_those_of_the_world():
    directions_world()
    found = project()
    expected = np.zeros((9, 3))
    expected[0] = 2 / Y0
    expected[3, 0] = expected[1, 1] = expected[2, 2] = 1 / Y1
    error = np.abs(found - expected).max()
    print(f"projection of a World of directions: within {error:.1e}")
    assert error < 2e-3


@pytest.mark.parametrize(
    ("kind", "by"), [("POINT", "pixels"), ("TEXTURE", "pixels"), (None, "pixels"), ("POINT", "panorama")]
)
def test_picture(kind, by, monkeypatch):
    """Any picture, turned by its Mapping node: a point lookup at w is one at R w, so that the light turns back. The
    pixels' own sum and Cycles' panorama are one."""
    from core import spherical_harmonics as sh
    from core.panorama import project_picture

    pixels = np.random.default_rng(0).uniform(0, 1, (16, 32, 3)) ** 2
    made = picture_world(pixels, 0.7)
    background(made).inputs["Strength"].default_value = 3.0
    mapping = next(node for node in made.node_tree.nodes if node.bl_idname == "ShaderNodeMapping")
    if kind is None:
        made.node_tree.nodes.remove(mapping)
    else:
        mapping.vector_type = kind
    radiance = operators("world_radiance")
    if by == "panorama":
        monkeypatch.setattr(radiance, "read_picture", lambda colour, strength: None)
    else:
        monkeypatch.setattr(radiance, "render_panorama", None)
    cos, sin = np.cos(0.7), np.sin(0.7)
    turn = {"POINT": np.array(((cos, sin, 0), (-sin, cos, 0), (0, 0, 1))), None: np.eye(3)}
    turn["TEXTURE"] = turn["POINT"].T
    expected = 3 * sh.rotate(project_picture(pixels), turn[kind])
    error = np.abs(project() - expected).max()
    print(f"projection of a picture turned as a {kind} by its {by}: within {error:.1e}")
    assert error < (1e-5 if by == "pixels" else 5e-3)


def test_bytes_are_srgb():
    made = picture_world(np.ones((4, 8, 3)))
    node = next(node for node in made.node_tree.nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    node.image = bpy.data.images.new("Bytes", 8, 4, alpha=True)
    node.image.pixels.foreach_set(np.tile(np.float32((0.5, 0.5, 1.0, 1.0)), 32))
    linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
    np.testing.assert_allclose(project(), of_plain(linear, linear, 1.0), atol=1e-4)


@pytest.mark.parametrize("change", ["tint", "stretched", "noise"])
def test_other_nodes_take_the_panorama(change, monkeypatch):
    """Whatever is more than a turned picture."""
    made = picture_world(np.ones((4, 8, 3)))
    nodes, links = made.node_tree.nodes, made.node_tree.links
    texture = next(node for node in nodes if node.bl_idname == "ShaderNodeTexEnvironment")
    if change == "tint":
        gamma = nodes.new("ShaderNodeGamma")
        links.new(texture.outputs["Color"], gamma.inputs["Color"])
        links.new(gamma.outputs[0], background(made).inputs["Color"])
    elif change == "stretched":
        next(node for node in nodes if node.bl_idname == "ShaderNodeMapping").inputs["Scale"].default_value = (1, 2, 1)
    else:
        links.new(nodes.new("ShaderNodeTexNoise").outputs["Color"], texture.inputs["Vector"])
    rendered = []

    def panorama(scene, strips):
        yield 0.0
        rendered.append(scene)
        return np.ones((2, 4, 3))

    monkeypatch.setattr(operators("world_radiance"), "render_panorama", panorama)
    project()
    assert rendered


def test_sky_with_a_sun():
    """The sun comes from where it stands, and brings the most."""
    made = world()
    nodes, links = made.node_tree.nodes, made.node_tree.links
    sky = nodes.new("ShaderNodeTexSky")
    sky.sun_elevation, sky.sun_rotation = np.radians(30), np.radians(90)
    links.new(sky.outputs["Color"], background(made).inputs["Color"])
    found = project()
    slope = found[[3, 1, 2]].sum(axis=1)
    assert slope[2] > 0
    assert np.degrees(np.arctan2(slope[0], slope[1])) == pytest.approx(90, abs=5)
    # However it lies among the panorama's pixels, and however small it is: its light is the same.
    sky.sun_rotation, sky.sun_size = np.radians(17), np.radians(0.1)
    turned = project()
    print(f"a sun turned by 73 degrees and made smaller: mean {found[0, 1]:.4f} and {turned[0, 1]:.4f}")
    np.testing.assert_allclose(turned[0], found[0], rtol=5e-3)
    assert sky.sun_size == pytest.approx(np.radians(0.1))


def test_light_and_not_what_the_camera_sees():
    """A common trick: another background for the camera, by Light Path nodes, also in a group."""
    made = directions_world()
    tree = made.node_tree
    light = background(made)
    group = bpy.data.node_groups.new("Camera Only", "ShaderNodeTree")
    group.interface.new_socket("Fac", in_out="OUTPUT", socket_type="NodeSocketFloat")
    path, out = group.nodes.new("ShaderNodeLightPath"), group.nodes.new("NodeGroupOutput")
    group.links.new(path.outputs["Is Camera Ray"], out.inputs[0])
    user, mix, seen = (tree.nodes.new(f"ShaderNode{name}") for name in ("Group", "MixShader", "Background"))
    user.node_tree = group
    seen.inputs["Color"].default_value = (9, 0, 9, 1)
    output = tree.get_output_node("CYCLES")
    tree.links.new(user.outputs[0], mix.inputs["Fac"])
    tree.links.new(light.outputs[0], mix.inputs[1])
    tree.links.new(seen.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    np.testing.assert_allclose(project()[0], 2 / Y0, rtol=1e-3)
    made.cycles_visibility.camera = False
    np.testing.assert_allclose(project()[0], 2 / Y0, rtol=1e-3)


@pytest.mark.parametrize("kind", ["plain", "directions", "picture"])
def test_nothing_else_changes(kind):
    make = {"plain": world, "directions": directions_world, "picture": lambda: picture_world(np.ones((4, 8, 3)))}
    make[kind]()
    bpy.context.scene.frame_current = 7
    before = snapshot()
    project()
    after = snapshot()
    assert not [line for line in differences(before, after) if STORED not in line]
    assert bpy.context.scene[STORED]["frame"] == 7


def in_strips(count):
    return operators("project_world").projecting(bpy.context.scene, count)


def test_strips_are_the_whole(monkeypatch):
    """In the window the panorama is rendered in several; nothing of them is in the file between or after."""
    for name, size in (("HEIGHT", 32), ("WIDTH", 64)):
        monkeypatch.setattr(operators("world_radiance"), name, size)
    made = world()
    noise = made.node_tree.nodes.new("ShaderNodeTexNoise")
    made.node_tree.links.new(noise.outputs["Color"], background(made).inputs["Color"])
    before = snapshot()
    work = in_strips(4)
    fractions = []
    for step in work:
        fractions.append(step.fraction)
        assert not differences(before, snapshot())
        if len(fractions) == 3:
            work.close()
    assert not differences(before, snapshot())
    assert fractions == [0, 0.25, 0.5]
    whole = project()
    del bpy.context.scene[STORED]
    operators("progress").drive(in_strips(4), lambda step: None)
    stored = bpy.context.scene[STORED]
    np.testing.assert_array_equal(np.transpose([list(stored[name]) for name in ("red", "green", "blue")]), whole)


def test_again_after_a_change():
    made = world()
    first = project()
    background(made).inputs["Strength"].default_value = 2
    np.testing.assert_allclose(project(), 2 * first, rtol=1e-6)


def test_forgotten():
    assert not bpy.ops.multibounce_ao.clear_world.poll()
    world((0.5, 0.5, 0.5))
    project()
    assert bpy.ops.multibounce_ao.clear_world() == {"FINISHED"}
    assert STORED not in bpy.context.scene


def test_scene_without_a_world():
    bpy.context.scene.world = None
    before = snapshot()
    message = error_of(bpy.ops.multibounce_ao.project_world)
    assert "has no World: add one" in message
    assert not differences(before, snapshot())


def test_world_that_is_infinitely_bright():
    world(strength=3e38)
    message = error_of(bpy.ops.multibounce_ao.project_world)
    assert message.startswith("World 'World' is infinitely bright somewhere: look")
    assert STORED not in bpy.context.scene


def test_saved_with_the_file(tmp_path):
    world((0.25, 0.5, 1.0))
    before = project()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    stored = bpy.context.scene[STORED]
    np.testing.assert_array_equal(np.transpose([list(stored[name]) for name in ("red", "green", "blue")]), before)


def test_world_without_nodes():
    if bpy.app.version >= (5, 0, 0):
        pytest.skip("all Worlds have nodes")
    made = world()
    made.use_nodes = False
    made.color = (0.1, 0.2, 0.3)
    np.testing.assert_allclose(project(), of_plain(0.1, 0.2, 0.3), rtol=1e-6)
