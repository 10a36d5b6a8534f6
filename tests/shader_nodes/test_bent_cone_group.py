# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Bent Cone Irradiance`` rendered against core.bent_cone and core.specular_occlusion."""

import importlib

import bpy
import numpy as np
import pytest

from .grid_render import render_grid
from .receivers import Plates, render_plates

SIZE = (24, 25)


@pytest.fixture
def modules(extension, empty_scene):
    return [
        importlib.import_module(f"{extension.__name__}.shader_nodes.{name}") for name in ("bent_cone", "cone_light")
    ]


@pytest.fixture
def world(empty_scene):
    """A colourful World with a bright side, stored on the scene, as coefficients (9, 3)."""
    from core import spherical_harmonics as sh

    directions, _ = sh.equirectangular(16, 32)
    radiance = 3.0 + directions @ np.array([(2.0, 0.1, -1.0), (0.5, 1.0, 0.3), (-0.3, 0.6, 1.5)])
    radiance += 4.0 * np.maximum(directions @ np.array((0.6, 0.0, 0.8)), 0)[..., None] ** 8
    coefficients = sh.project_panorama(radiance)
    store(coefficients)
    return coefficients


def store(coefficients):
    channels = dict(zip(("red", "green", "blue"), np.transpose(coefficients).tolist(), strict=True))
    bpy.context.scene["multibounce_ao_world"] = channels


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def seen(seed=0):
    """Normals (r, c, 3), and b and alpha of random sets of directions above their horizon."""
    rng = np.random.default_rng(seed)
    count = SIZE[0] * SIZE[1]
    normals, directions = unit(rng.normal(size=(count, 3))), unit(rng.normal(size=(2048, 3)))
    up = normals @ directions.T > 0
    axes, least = rng.normal(size=(count, 3)), rng.uniform(-1.5, 1.0, count)
    visible = up & (axes @ directions.T > least[:, None])
    visible[visible.sum(axis=1) < 20] = True
    visible &= up
    bent = (visible @ directions) / visible.sum(axis=1, keepdims=True)
    alpha = visible.sum(axis=1) / up.sum(axis=1)
    normals, bent, alpha = (np.float32(each).astype(float) for each in (normals, bent, alpha))
    return normals.reshape(*SIZE, 3), bent.reshape(*SIZE, 3), alpha.reshape(SIZE)


def render(group, folder, output, **values):
    """Sockets by their names, with _ for a space."""

    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        for name, socket in sockets.items():
            tree.links.new(socket, node.inputs[name])
        return node.outputs[output]

    return render_grid({name.replace("_", " "): each for name, each in values.items()}, connect, folder)


def in_core(coefficients, normals, bent, alpha):
    from core.bent_cone import sky_light

    light = sky_light(coefficients, bent.reshape(-1, 3), alpha.ravel(), normals.reshape(-1, 3))
    return [each.reshape(*SIZE, 3) for each in light]


@pytest.mark.parametrize("output", ["Irradiance", "Sky Light", "Relative Light"])
def test_agrees_with_core(modules, world, tmp_path, output):
    normals, bent, alpha = seen()
    found = render(modules[0].ensure(), tmp_path, output, Normal=normals, Bent_Cone=bent, Alpha=alpha)
    expected = in_core(world, normals, bent, alpha)[("Irradiance", "Sky Light", "Relative Light").index(output)]
    error = np.abs(found - expected) / np.maximum(np.abs(expected), 1.0)
    print(f"{output} in Cycles against core.bent_cone: {error.max():.1e}")
    assert error.max() < 1e-3


def test_white_world_gives_f0(modules, tmp_path):
    """Without a projection the World is white. All of the light is in Irradiance, and nothing in what it multiplies."""
    normals, bent, alpha = seen()
    values = {"Normal": normals, "Bent_Cone": bent, "Alpha": alpha}
    f0 = np.maximum(2 * alpha * (normals * bent).sum(axis=-1), 0)[..., None]
    np.testing.assert_allclose(render(modules[0].ensure(), tmp_path, "Irradiance", **values) - f0, 0, atol=1e-4)
    for output in ("Sky Light", "Relative Light"):
        np.testing.assert_allclose(render(modules[0].ensure(), tmp_path, output, **values), 1.0, atol=1e-3)


def test_open_surfaces_have_the_plain_irradiance(modules, world, tmp_path):
    from core.spherical_harmonics import irradiance

    normals, _, _ = seen()
    expected = irradiance(world, normals)
    values = {"Normal": normals, "Bent_Cone": 0.5 * normals, "Alpha": np.ones(SIZE)}
    for output in ("Irradiance", "Sky Light"):
        found = render(modules[0].ensure(), tmp_path, output, **values)
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)
    # A mesh without the attribute: black, alpha 1.
    values["Bent_Cone"] = np.zeros_like(normals)
    np.testing.assert_allclose(
        render(modules[0].ensure(), tmp_path, "Irradiance", **values), expected, rtol=1e-3, atol=1e-3
    )


def test_own_normal(modules, world, tmp_path):
    """Nothing plugged in: an open plate that faces up."""
    from core.spherical_harmonics import irradiance

    found = render(modules[0].ensure(), tmp_path, "Irradiance", Alpha=np.ones((4, 4)))
    np.testing.assert_allclose(found[1, 1], irradiance(world, np.array((0.0, 0.0, 1.0))), rtol=1e-4)


def test_closed_points_are_dark(modules, world, tmp_path):
    normals = seen()[0]
    values = {"Normal": normals, "Bent_Cone": np.zeros_like(normals), "Alpha": np.zeros(SIZE)}
    np.testing.assert_allclose(render(modules[0].ensure(), tmp_path, "Irradiance", **values), 0, atol=1e-5)


def test_direction_and_aperture(modules, tmp_path):
    normals, bent, alpha = seen()
    values = {"Normal": normals, "Bent_Cone": bent, "Alpha": alpha}
    np.testing.assert_allclose(render(modules[0].ensure(), tmp_path, "Bent Normal", **values), unit(bent), atol=1e-5)
    aperture = render(modules[0].ensure(), tmp_path, "Aperture", **values)[..., 0]
    np.testing.assert_allclose(aperture, np.arccos(1 - alpha), atol=1e-4)


def test_specular_occlusion(modules, tmp_path):
    """The camera of the grid looks straight down."""
    from core.specular_occlusion import specular_occlusion

    normals, bent, alpha = seen()
    roughness = np.float32(np.random.default_rng(5).uniform(0, 1, SIZE)).astype(float)
    values = {"Normal": normals, "Bent_Cone": bent, "Alpha": alpha, "Roughness": roughness}
    found = render(modules[0].ensure(), tmp_path, "Specular Occlusion", **values)[..., 0]
    views = np.broadcast_to((0.0, 0.0, 1.0), normals.shape).reshape(-1, 3)
    lists = unit(bent).reshape(-1, 3), alpha.ravel(), normals.reshape(-1, 3), views, roughness.ravel()
    error = np.abs(found.ravel() - specular_occlusion(*lists))
    error = error[(normals[..., 2] > 0).ravel()]
    print(f"Specular Occlusion in Cycles against core: {error.max():.1e}")
    assert error.max() < 5e-3


def test_group_follows_the_scene(modules, world):
    """Built with the scene's World, shown another, and white once that is forgotten; also one far too bright for a
    socket."""
    group, light = modules
    tree = bpy.data.node_groups[group.ensure().nodes["Light seen"].node_tree.name]

    def coefficients():
        scale = tree.nodes["World Scale"].outputs[0].default_value
        names = ("L 0 0", "L 1 -1", "L 1 0", "L 1 1", "L 2 -2", "L 2 -1", "L 2 0", "L 2 1", "L 2 2")
        return scale * np.array([[socket.default_value for socket in tree.nodes[name].inputs] for name in names])

    np.testing.assert_allclose(coefficients(), world, rtol=1e-5, atol=1e-5)
    store(1e9 * world)
    light.show_world(bpy.context.scene)
    np.testing.assert_allclose(coefficients(), 1e9 * world, rtol=1e-5, atol=1e4)
    del bpy.context.scene["multibounce_ao_world"]
    light.show_world(bpy.context.scene)
    np.testing.assert_allclose(coefficients()[0], 2 * np.sqrt(np.pi), rtol=1e-6)
    assert (coefficients()[1:] == 0).all()


def test_the_chain_keeps_multibounce_ao_as_it_is_under_a_white_world(modules, extension, tmp_path):
    multibounce = importlib.import_module(f"{extension.__name__}.shader_nodes.multibounce_ao").ensure()
    normals, bent, alpha = seen()
    f0 = np.clip(2 * alpha * (normals * bent).sum(axis=-1), 0, 1)
    bounces = np.stack((f0, 0.5 * (1 - f0), 0.2 * (1 - f0)), axis=-1)

    def color(is_chained):
        def connect(tree, sockets):
            last = tree.nodes.new("ShaderNodeGroup")
            last.node_tree = multibounce
            tree.links.new(sockets["Bounces"], last.inputs["Bounces"])
            last.inputs["Tail"].default_value = 0.4
            if is_chained:
                cone = tree.nodes.new("ShaderNodeGroup")
                cone.node_tree = modules[0].ensure()
                for name in ("Normal", "Bent Cone", "Alpha"):
                    tree.links.new(sockets[name], cone.inputs[name])
                tree.links.new(cone.outputs["Sky Light"], last.inputs["Irradiance"])
            return last.outputs["Color"]

        values = {"Bounces": bounces, "Normal": normals, "Bent Cone": bent, "Alpha": alpha}
        return render_grid(values, connect, tmp_path)

    np.testing.assert_allclose(color(True), color(False), rtol=1e-3)


def test_any_place_and_engine(modules, world, tmp_path, engine):
    """Plates of any tilt, with one cone for all and their own normals."""
    from core.bent_cone import sky_light

    plates = Plates.random(np.random.default_rng(3), 48, 6.0)
    bent, alpha = (0.1, -0.2, 0.7), 0.45

    def connect(tree):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = modules[0].ensure()
        node.inputs["Bent Cone"].default_value, node.inputs["Alpha"].default_value = bent, alpha
        return node.outputs["Irradiance"]

    normals = plates.normals()
    light = sky_light(world, np.broadcast_to(bent, normals.shape), np.full(len(normals), alpha), normals)
    error = np.abs(render_plates(plates, connect, tmp_path, engine) - light.irradiance[:, 0])
    print(f"{engine} against core.bent_cone: largest {error.max():.1e}")
    # Places and directions turn in float32: .00012 is the most in Blender 5.2.
    assert error.max() < (2e-4 if engine == "CYCLES" else 0.02)


@pytest.fixture(params=["bent_cone", "cone_light"])
def tree(modules, request):
    return modules[request.param == "cone_light"].ensure()


def test_sockets_explain_themselves(tree):
    for item in tree.interface.items_tree:
        assert item.description and not item.description.endswith(".")


def test_reads_from_left_to_right(tree):
    def left(node):
        return node.location.x + (left(node.parent) if node.parent else 0)

    assert all(left(link.from_node) + link.from_node.width < left(link.to_node) for link in tree.links)
    assert all(node.parent or node.bl_idname in {"NodeFrame", "NodeGroupOutput"} for node in tree.nodes)
    assert all(len(node.label.encode()) < 63 for node in tree.nodes)


def test_second_call_changes_nothing(modules):
    tree = modules[0].ensure()
    count = len(tree.nodes)
    assert modules[0].ensure() == tree and len(tree.nodes) == count
    assert {group.name for group in bpy.data.node_groups} == {"Bent Cone Irradiance", "Cone Light"}
