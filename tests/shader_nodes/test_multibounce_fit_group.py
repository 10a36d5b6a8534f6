# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Fit`` rendered against equations (7) to (12) of "Improved Ambient Occlusion"."""

import importlib

import bpy
import numpy as np
import pytest

from .grid_render import render_grid

A, B = 27.576937094210385, 3.3364392003423804


@pytest.fixture
def module(extension, empty_scene):
    return importlib.import_module(extension.__name__ + ".shader_nodes.multibounce_fit")


@pytest.fixture
def group(module):
    return module.ensure()


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


# Coefficients as a fit may find them: near the published, for little relief, and at the ends of what it looks through.
FITS = {
    "published": {"a": A, "b": B, "f0_factor": 0.5, "f0_exponent": 0.75},
    "wall": {"a": 4.25, "b": 1.42, "f0_factor": 0.15, "f0_exponent": 6e-9},
    "closed": {"a": 0.3, "b": -1.2, "f0_factor": -0.6, "f0_exponent": 2.0},
    "dark": {"a": np.exp(-50.0), "b": 50.0, "f0_factor": -1.0, "f0_exponent": 0.0},
    "bright": {"a": np.exp(50.0), "b": -50.0, "f0_factor": 1e6, "f0_exponent": 40.0},
}


def random_fit(seed):
    rng = np.random.default_rng(seed)
    values = np.exp(rng.uniform(-5, 5)), rng.uniform(-5, 10), rng.uniform(-1, 2), rng.uniform(0, 3)
    return dict(zip(("a", "b", "f0_factor", "f0_exponent"), map(float, values), strict=True))


@pytest.mark.parametrize("fit", [*FITS.values(), *map(random_fit, range(3))], ids=[*FITS, *"123"])
def test_stored_fit(module, fit, tmp_path):
    """Values of core with the same coefficients, and the guards: finite, in [F0, 1], rising with albedo."""
    from core import multibounce

    bpy.context.scene["multibounce_ao_fit"] = fit | {"source": "Wall"}
    alpha, albedo = grid()
    coefficients = multibounce.Coefficients(**fit)
    group = module.ensure()
    factor = render(group, alpha, albedo, "Factor", tmp_path)
    direct = render(group, alpha, albedo, "F0", tmp_path)
    assert np.isfinite(factor).all()
    assert (factor >= direct - 1e-6).all()
    assert (factor <= 1 + 1e-6).all()
    assert (np.diff(factor, axis=1) * np.sign(np.diff(albedo, axis=1)) >= -1e-6).all()
    np.testing.assert_allclose(direct[..., 0], multibounce.f0(alpha, coefficients), rtol=0, atol=1e-5)
    expected = multibounce.irradiance(alpha[..., None], albedo, coefficients)
    # White walls keep all light, but for a bounce that float32 takes for none.
    lost = (albedo == 1) & (multibounce.f1(alpha, coefficients)[..., None] < np.finfo(np.float32).tiny)
    error = np.abs(factor - expected)[~lost].max()
    print(f"largest difference from core: {error:.1e}")
    assert error < 1e-5


def test_a_new_fit_reaches_the_group_and_leaves_with_it(module, tmp_path):
    """In place: what uses the group goes on using it."""
    from core import multibounce

    scene, group = bpy.context.scene, module.ensure()
    alpha, albedo = np.full((1, 5), 0.4), np.full((1, 5, 3), 0.6)

    def rendered():
        return render(group, alpha, albedo, "Factor", tmp_path)[0, 0, 0]

    scene["multibounce_ao_fit"] = FITS["wall"]
    module.show_fit(scene)
    fitted = multibounce.irradiance(0.4, 0.6, multibounce.Coefficients(**FITS["wall"]))
    assert rendered() == pytest.approx(fitted, abs=1e-5)
    assert fitted < multibounce.irradiance(0.4, 0.6) - 0.02
    del scene["multibounce_ao_fit"]
    module.show_fit(scene)
    assert rendered() == pytest.approx(multibounce.irradiance(0.4, 0.6), abs=1e-5)
    assert list(bpy.data.node_groups) == [group]


def test_no_group_is_made_for_a_fit_alone(module):
    bpy.context.scene["multibounce_ao_fit"] = FITS["wall"]
    module.show_fit(bpy.context.scene)
    assert not bpy.data.node_groups


def test_a_group_that_is_up_to_date_keeps_what_an_artist_set(module):
    group = module.ensure()
    group.nodes["B"].outputs[0].default_value = 3
    bpy.context.scene["multibounce_ao_fit"] = FITS["wall"]
    assert module.ensure().nodes["B"].outputs[0].default_value == 3
    group.nodes.remove(group.nodes["A"])
    module.show_fit(bpy.context.scene)
    assert group.nodes["B"].outputs[0].default_value == pytest.approx(1.42)


@pytest.mark.parametrize("broken", [{}, {"a": 1.0, "b": 2.0}, {"b": float("nan")}, {"a": float("inf")}, {"a": 1e35}])
def test_a_stored_fit_that_shaders_cannot_use_is_not_used(module, broken):
    stored = broken if len(broken) != 1 else FITS["wall"] | broken
    bpy.context.scene["multibounce_ao_fit"] = stored
    nodes = module.ensure().nodes
    assert nodes["A"].outputs[0].default_value == pytest.approx(A)
    assert nodes["F0 exponent"].outputs[0].default_value == pytest.approx(0.75)
