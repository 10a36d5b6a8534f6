# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Fit`` rendered against equations (7) to (12) of "Improved Ambient Occlusion"."""

import importlib

import numpy as np
import pytest

from .grid_render import render_grid

A, B = 27.576937094210385, 3.3364392003423804


@pytest.fixture
def group(extension, empty_scene):
    return importlib.import_module(extension.__name__ + ".shader_nodes.multibounce_fit").ensure()


def grid():
    """Alpha down the rows, dense near 1, albedo along the columns; another albedo in each channel. float32 values."""
    t = np.linspace(0, 1, 129)
    alpha = np.repeat((1 - (1 - t) ** 2)[:, None], 129, axis=1)
    albedo = np.stack(np.broadcast_arrays(t, 1 - t, t**2), axis=-1)
    albedo = np.broadcast_to(albedo, (129, 129, 3))
    return np.float32(alpha).astype(float), np.float32(albedo).astype(float)


def render(group, alpha, base_color, output, folder, irradiance=(1, 1, 1)):
    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        node.inputs["Irradiance"].default_value = (*irradiance, 1)
        tree.links.new(sockets["alpha"], node.inputs["AO"])
        tree.links.new(sockets["base color"], node.inputs["Base Color"])
        if isinstance(output, str):
            return node.outputs[output]
        combine = tree.nodes.new("ShaderNodeCombineXYZ")
        for name, socket in zip(output, combine.inputs, strict=True):
            tree.links.new(node.outputs[name], socket)
        return combine.outputs[0]

    return render_grid({"alpha": alpha, "base color": base_color}, connect, folder)


def published(alpha):
    """F0, F1, tau as printed: (7), (11), (9). Valid below alpha = 0.949, where F0 passes 1."""
    f0 = alpha * (1 + (1 - alpha) / (2 * np.sqrt(np.sqrt(1 - alpha))))
    f1 = A * alpha * (1 - alpha) ** 1.5 * np.exp(-B * np.sqrt(np.sqrt(alpha)))
    return f0, f1, 1 - f1 / (1 - f0)


def test_factor_over_the_whole_range(group, tmp_path):
    alpha, albedo = grid()
    factor = render(group, alpha, albedo, "Factor", tmp_path)

    # E/E0 = F0 + rho F1 / (1 - rho tau), eq. (12). At alpha = 0 nothing comes in, whatever the albedo.
    rows = (alpha[:, 0] > 0) & (alpha[:, 0] < 0.76)
    f0, f1, tau = published(alpha[rows][..., None])
    expected = f0 + albedo[rows] / (1 - albedo[rows] * tau) * f1
    assert rows.sum() > 60
    print(f"largest difference from the closed form where alpha < .76: {np.abs(factor[rows] - expected).max():.1e}")
    np.testing.assert_allclose(factor[rows], expected, rtol=0, atol=1e-4)
    assert (factor[alpha[:, 0] == 0] == 0).all()

    # Above it the printed tau is negative or has its pole; energy still bounds the result.
    assert np.isfinite(factor).all()
    direct = np.minimum(1, alpha + alpha * (1 - alpha) ** 0.75 / 2)[..., None]
    assert (factor >= direct - 1e-5).all()
    assert (factor <= 1 + 1e-5).all()
    assert (factor[alpha[:, 0] == 1] == 1).all()

    rise = np.diff(factor, axis=1) * np.sign(np.diff(albedo, axis=1))
    assert (rise >= -1e-6).all()
    near = (alpha[..., None] > 0.75) & (albedo < 0.9)
    for axis in (0, 1):
        both = near[1:] & near[:-1] if axis == 0 else near[:, 1:] & near[:, :-1]
        assert both.any()
        print(f"largest step where alpha > .75 and albedo < .9: {np.abs(np.diff(factor, axis=axis))[both].max():.4f}")
        assert np.abs(np.diff(factor, axis=axis))[both].max() < 0.03


def test_no_sparkles_between_the_cells(group, tmp_path):
    """16641 values of alpha within 1e-7 to 0.06 of 1, across F0 = 1 at 0.949: E/E0 stays within what F0 alone spans."""
    alpha = np.float32(1 - np.geomspace(1e-7, 0.06, 129 * 129)).reshape(129, 129).astype(float)
    albedo = np.full((129, 129, 3), (0.3, 0.9, 1.0))
    factor = render(group, alpha, albedo, "Factor", tmp_path)
    assert factor.max() <= 1 + 1e-6
    # F0(0.94) = 0.997: all that is left to the bounces is 0.003
    assert factor.min() >= published(0.94)[0] - 1e-6


def test_no_noise_near_closed(group, tmp_path):
    """White walls lose nothing: E/E0 = 1 at albedo 1 however little comes in, where 1 - tau has no digits left."""
    alpha = np.float32(np.geomspace(1e-12, 1e-3, 128)).reshape(1, 128)
    factor = render(group, alpha, np.ones((1, 128, 3)), "Factor", tmp_path)
    np.testing.assert_allclose(factor, 1, rtol=0, atol=1e-5)


def test_f0_f1_tau(group, tmp_path):
    alpha, albedo = grid()
    rendered = render(group, alpha, albedo, ("F0", "F1", "Tau"), tmp_path)[:, 0]
    alpha = alpha[:, 0]
    rows = alpha < 0.76
    np.testing.assert_allclose(rendered[rows], np.stack(published(alpha[rows]), axis=-1), rtol=0, atol=1e-5)
    # F0 + F1 (1 + tau + tau^2 ...) = 1: with tau = 0 the one bounce brings all that F0 leaves
    np.testing.assert_allclose(rendered[~rows, 0] + rendered[~rows, 1], 1, rtol=0, atol=2e-2)
    assert (rendered.sum(axis=1) <= 2 + 1e-5).all()
    assert (rendered[alpha > 0.78, 2] == 0).all()
    assert rendered[-1, 0] == 1 and rendered[-1, 1] == 0


def test_agrees_with_core(group, tmp_path):
    from core import multibounce

    alpha, albedo = grid()
    factor = render(group, alpha, albedo, "Factor", tmp_path)
    np.testing.assert_allclose(factor, multibounce.irradiance(alpha[..., None], albedo), rtol=0, atol=1e-5)


def test_color_takes_base_color_unclamped(group, tmp_path):
    """Sharpening filters leave colours past [0, 1]: the bounces take the nearest albedo, Color keeps what came in."""
    alpha = np.full((1, 3), 0.5)
    base_color = np.array([[(-0.25, 0.5, 1.5), (2.0, 0.0, 1.0), (0.125, 4.0, -1.0)]])
    irradiance = np.array((0.5, 2.0, 3.0))
    factor = render(group, alpha, base_color, "Factor", tmp_path)
    f0, f1, tau = published(0.5)
    albedo = np.clip(base_color, 0, 1)
    np.testing.assert_allclose(factor, f0 + albedo * f1 / (1 - albedo * tau), rtol=0, atol=1e-5)
    color = render(group, alpha, base_color, "Color", tmp_path, irradiance)
    np.testing.assert_allclose(color, base_color * factor * irradiance, rtol=0, atol=1e-5)


def test_alpha_is_clamped(group, tmp_path):
    alpha = np.array([[-3.0, -1e-3, 1.001, 17.0]])
    factor = render(group, alpha, np.full((1, 4, 3), 0.5), "Factor", tmp_path)
    np.testing.assert_array_equal(factor[0, :, 0], (0, 0, 1, 1))


def test_unplugged_changes_nothing(group, tmp_path):
    base_color = np.random.default_rng(3).random((4, 4, 3))

    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(sockets["base color"], node.inputs["Base Color"])
        return node.outputs["Color"]

    color = render_grid({"base color": base_color}, connect, tmp_path)
    np.testing.assert_array_equal(color, np.float32(base_color))
