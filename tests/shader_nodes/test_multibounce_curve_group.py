# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Curve`` rendered against its formula, the other two curves, and core."""

import importlib

import numpy as np
import pytest

from .grid_render import render_grid


@pytest.fixture
def group(extension, empty_scene):
    return importlib.import_module(extension.__name__ + ".shader_nodes.multibounce_curve").ensure()


def render(group, ao, base_color, output, folder, openness=None, irradiance=(1, 1, 1)):
    """``openness``: one number, an array like ``ao``, or the socket's default."""
    values = {"AO": np.float32(ao), "Base Color": np.float32(base_color)}
    if np.ndim(openness):
        values["Openness"] = np.float32(openness)

    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        node.inputs["Irradiance"].default_value = (*irradiance, 1)
        if openness is not None and not np.ndim(openness):
            node.inputs["Openness"].default_value = openness
        for name, socket in sockets.items():
            tree.links.new(socket, node.inputs[name])
        return node.outputs[output]

    return render_grid(values, connect, folder)


def grid():
    """k_A down the rows, dense at both ends, albedo along the columns; another albedo in each channel. float32
    values."""
    t = np.linspace(0, 1, 129)
    k = np.repeat((0.5 - 0.5 * np.cos(np.pi * t))[:, None], 129, axis=1)
    albedo = np.stack(np.broadcast_arrays(t, 1 - t, t**2), axis=-1)
    albedo = np.broadcast_to(albedo, (129, 129, 3))
    return np.float32(k).astype(float), np.float32(albedo).astype(float)


@pytest.mark.parametrize("openness", [1e-6, 0.05, 0.3, 0.7, 1.0])
def test_factor_over_the_whole_range(group, openness, tmp_path):
    """E/E0 = k + rho (1 - k) E' with E' of a pit of openness sqrt(k m); in [k, 1], rising with albedo and with k."""
    from core import multibounce

    k, albedo = grid()
    factor = render(group, k, albedo, "Factor", tmp_path, openness)
    openness = float(np.float32(openness))
    around = np.sqrt(k * openness)[..., None]
    closed = 1 - albedo * (1 - around)
    safe = np.where(closed > 0, closed, 1)
    expected = k[..., None] + albedo * (1 - k[..., None]) * around / safe
    error = np.abs(factor - expected).max()
    print(f"openness {openness:g}: largest difference from the closed form {error:.1e}")
    assert error < 1e-5
    np.testing.assert_allclose(factor, multibounce.surface_curve(k[..., None], openness, albedo), rtol=0, atol=1e-5)
    assert np.isfinite(factor).all()
    assert (factor >= k[..., None] - 1e-6).all() and (factor <= 1 + 1e-6).all()
    assert (np.diff(factor, axis=1) * np.sign(np.diff(albedo, axis=1)) >= -1e-6).all()
    assert (np.diff(factor, axis=0) >= -1e-6).all()


def test_without_openness_it_is_the_curve_of_a_pit(group, tmp_path):
    """Exact in every spherical pit: E/E0 = f / (1 - rho (1 - f))."""
    k, albedo = grid()
    factor = render(group, k, albedo, "Factor", tmp_path)
    inside = k > 0
    expected = (k[..., None] / (1 - albedo * (1 - k[..., None]) + (~inside)[..., None]))[inside]
    error = np.abs(factor[inside] - expected).max()
    print(f"openness not given: largest difference from f / (1 - rho (1 - f)) {error:.1e}")
    assert error < 1e-5 and (factor[~inside] == 0).all()
    np.testing.assert_allclose(factor, render(group, k, albedo, "Pit Factor", tmp_path, 0.3), rtol=0, atol=2e-6)


@pytest.mark.parametrize("albedo", [0.2, 0.9])
def test_openness_of_the_point_itself_is_that_pit_too(group, albedo, tmp_path):
    """Where the openness is known to be the point's own, nothing changes: no step between known and not known."""
    k, _ = grid()
    base_color = np.full((*k.shape, 3), albedo)
    known = render(group, k, base_color, "Factor", tmp_path, openness=k)
    np.testing.assert_allclose(known, render(group, k, base_color, "Factor", tmp_path), rtol=0, atol=2e-6)


@pytest.mark.parametrize("output", ["Pit Factor", "Jimenez Factor"])
def test_published_curves(group, output, tmp_path):
    from core import multibounce

    k, albedo = grid()
    rendered = render(group, k, albedo, output, tmp_path, openness=0.4)
    curve = {"Pit Factor": multibounce.equal_neighbours, "Jimenez Factor": multibounce.jimenez_2016}[output]
    error = np.abs(rendered - curve(k[..., None], albedo)).max()
    print(f"{output}: largest difference from core {error:.1e}")
    assert error < 1e-5
    assert (rendered >= k[..., None] - 1e-6).all()
    assert (np.diff(rendered, axis=1) * np.sign(np.diff(albedo, axis=1)) >= -1e-6).all()


def test_hostile_inputs(group, tmp_path):
    """Filters and wrong maps leave values past [0, 1]: the nearest in it are taken."""
    from core import multibounce

    rng = np.random.default_rng(2)
    k, openness = rng.uniform(-0.5, 1.5, (2, 65, 65))
    k[:, ::5], k[:, 1::7], openness[:, ::3], openness[:, 1::8] = 0, 1, 1, -1
    k[0, :4], openness[0, :4] = (1e-30, 1e30, -1e30, 1e-30), (1e30, 1e-30, 1, 1e-30)
    albedo = np.clip(rng.uniform(-0.1, 1.1, (65, 65, 3)), 0, 1) * 1.5 - 0.25
    k, openness, albedo = (np.float32(each).astype(float) for each in (k, openness, albedo))
    factor = render(group, k, albedo, "Factor", tmp_path, openness)
    assert np.isfinite(factor).all()
    direct = np.clip(k, 0, 1)[..., None]
    assert (factor >= direct - 1e-6).all() and (factor <= 1 + 1e-6).all()
    meant = np.where(openness > 0, openness, k)[..., None]
    error = np.abs(factor - multibounce.surface_curve(k[..., None], meant, albedo)).max()
    print(f"hostile inputs: largest difference from core {error:.1e}")
    assert error < 1e-5


@pytest.mark.parametrize("openness", [0.0, 0.3])
def test_no_noise_near_closed(group, openness, tmp_path):
    """White walls lose nothing: E/E0 = 1 at albedo 1 however little comes in."""
    k = np.geomspace(1e-12, 1e-3, 128).reshape(1, 128)
    factor = render(group, k, np.ones((1, 128, 3)), "Factor", tmp_path, openness)
    np.testing.assert_allclose(factor, 1, rtol=0, atol=1e-5)


def test_color_takes_base_color_unclamped(group, tmp_path):
    base_color = np.array([[(-0.25, 0.5, 1.5), (2.0, 0.0, 1.0), (0.125, 4.0, -1.0)]])
    irradiance = np.array((0.5, 2.0, 3.0))
    k = np.full((1, 3), 0.5)
    factor = render(group, k, base_color, "Factor", tmp_path, 0.25)
    around = np.sqrt(0.5 * 0.25)
    albedo = np.clip(base_color, 0, 1)
    np.testing.assert_allclose(factor, 0.5 + albedo * 0.5 * around / (1 - albedo * (1 - around)), rtol=0, atol=1e-5)
    color = render(group, k, base_color, "Color", tmp_path, 0.25, irradiance)
    np.testing.assert_allclose(color, base_color * factor * irradiance, rtol=0, atol=1e-5)


def test_unplugged_changes_nothing(group, tmp_path):
    base_color = np.random.default_rng(3).random((4, 4, 3))

    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(sockets["base color"], node.inputs["Base Color"])
        return node.outputs["Color"]

    color = render_grid({"base color": base_color}, connect, tmp_path)
    np.testing.assert_array_equal(color, np.float32(base_color))
