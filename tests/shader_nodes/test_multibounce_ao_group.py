# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO`` rendered against E/E0 = F0 + rho F1 + rho^2 F2 / (1 - rho T)."""

import importlib

import numpy as np
import pytest

from .grid_render import render_grid


@pytest.fixture
def group(extension, empty_scene):
    return importlib.import_module(extension.__name__ + ".shader_nodes.multibounce_ao").ensure()


def render(group, bounces, tail, base_color, folder, output="Factor"):
    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        for name in ("Bounces", "Tail", "Base Color"):
            tree.links.new(sockets[name], node.inputs[name])
        return node.outputs[output]

    values = {"Bounces": bounces, "Tail": tail, "Base Color": base_color}
    return render_grid({name: np.float32(value) for name, value in values.items()}, connect, folder)


def random_albedo(rng, shape):
    """Uniform, with a good share of exact 0 and 1."""
    return np.clip(rng.uniform(-0.1, 1.1, (*shape, 3)), 0, 1)


def as_stored(*arrays):
    return [np.float32(array).astype(float) for array in arrays]


def test_bounces_that_keep_energy_are_taken_as_they_are(group, tmp_path):
    """Channels of a real bake: F0 + F1 + F2 / (1 - T) <= 1. No guard may touch them."""
    rng = np.random.default_rng(1)
    shape = (65, 65)
    share = rng.dirichlet((1, 1, 1, 1), shape)  # F0, F1, all further bounces, lost
    tail = rng.uniform(0, 0.999, shape)
    bounces = np.stack([share[..., 0], share[..., 1], share[..., 2] * (1 - tail)], axis=-1)
    albedo = random_albedo(rng, shape)
    bounces, tail, albedo = as_stored(bounces, tail, albedo)
    factor = render(group, bounces, tail, albedo, tmp_path)
    f0, f1, f2 = (bounces[..., [channel]] for channel in range(3))
    expected = f0 + albedo * f1 + albedo**2 * f2 / (1 - albedo * tail[..., None])
    np.testing.assert_allclose(factor, expected, rtol=0, atol=1e-5)


def hostile():
    """Any sums, negative channels, T = 1 and beyond, and all of {-1, 0, 1, 2}^4 with albedo 0, 1 and between."""
    rng = np.random.default_rng(2)
    bounces = rng.uniform(-0.5, 1.5, (97, 97, 3))
    tail = rng.uniform(-0.5, 1.5, (97, 97))
    tail[:, ::5] = 1
    albedo = random_albedo(rng, (97, 97)) * 1.5 - 0.25
    corners = np.stack(np.meshgrid(*[(-1, 0, 1, 2)] * 4), axis=-1).reshape(-1, 4)
    bounces.reshape(-1, 3)[: len(corners)] = corners[:, :3]
    tail.reshape(-1)[: len(corners)] = corners[:, 3]
    albedo.reshape(-1, 3)[: len(corners)] = (0, 1, 0.5)
    return as_stored(bounces, tail, albedo)


def test_hostile_channels_keep_energy(group, tmp_path):
    bounces, tail, albedo = hostile()
    factor = render(group, bounces, tail, albedo, tmp_path)
    assert np.isfinite(factor).all()
    f0 = np.clip(bounces[..., [0]], 0, 1)
    assert (factor >= f0 - 1e-5).all()
    assert (factor <= 1 + 1e-5).all()

    # F0 first, then F1 and F2 from what is left. Up to albedo 0.9 the bounces after them add up to no more than
    # rho^3 of what is left then, T being lowered; past it the sum keeps below the straight line to 1 at albedo 1.
    f1 = np.minimum(np.maximum(bounces[..., [1]], 0), 1 - f0)
    f2 = np.minimum(np.maximum(bounces[..., [2]], 0), 1 - f0 - f1)
    left = 1 - f0 - f1 - f2
    highest = np.divide(left, f2 + 0.9 * left, out=np.zeros_like(f2), where=left > 0)
    decay = np.clip(tail[..., None], 0, np.minimum(highest, 1 - 2**-10))
    rho = np.minimum(np.maximum(albedo, 0), 1)
    factor_at = [f0 + x * f1 + x**2 * f2 / (1 - x * decay) for x in (rho, 0.9)]
    line = factor_at[1] + (1 - factor_at[1]) * (rho - 0.9) / 0.1
    expected = np.where(rho > 0.9, np.minimum(factor_at[0], line), factor_at[0])
    np.testing.assert_allclose(factor, expected, rtol=0, atol=1e-5)


def test_agrees_with_core(group, tmp_path):
    from core import multibounce

    bounces, tail, albedo = hostile()
    factor = render(group, bounces, tail, albedo, tmp_path)
    f0, f1, f2 = (bounces[..., [channel]] for channel in range(3))
    expected = multibounce.irradiance_from_bounces(f0, f1, f2, tail[..., None], albedo)
    np.testing.assert_allclose(factor, expected, rtol=0, atol=1e-5)


def test_rises_with_albedo(group, tmp_path):
    rng = np.random.default_rng(4)
    bounces = np.repeat(rng.uniform(-0.2, 1.0, (64, 1, 3)), 65, axis=1)
    tail = np.repeat(rng.uniform(0, 1.2, (64, 1)), 65, axis=1)
    albedo = np.broadcast_to(np.linspace(0, 1, 65)[None, :, None], (64, 65, 3))
    factor = render(group, bounces, tail, albedo, tmp_path)
    assert (np.diff(factor, axis=1) >= -1e-6).all()


def test_spherical_pit(group, tmp_path):
    """In a spherical pit whose opening is the fraction f of the sphere every point sees f of the sky and 1 - f of the
    pit: F_n = f (1 - f)^n, T = 1 - f, and E/E0 = f / (1 - rho (1 - f)) exactly."""
    f = np.repeat(np.linspace(0, 1, 65)[:, None], 65, axis=1)
    albedo = np.linspace(0, 1, 65)[None, :, None] * np.array((1, 0.5, 0.25))
    albedo = np.broadcast_to(albedo, (65, 65, 3))
    bounces = np.stack([f, f * (1 - f), f * (1 - f) ** 2], axis=-1)
    factor = render(group, bounces, 1 - f, albedo, tmp_path)
    expected = f[..., None] / np.where(f[..., None] > 0, 1 - albedo * (1 - f[..., None]), 1)
    np.testing.assert_allclose(factor, expected, rtol=0, atol=2e-6)


def test_ao_output_is_f0(group, tmp_path):
    bounces = np.array([[(0.25, 0.5, 0.1), (-1, 0.5, 0.1), (3, 0.5, 0.1)]])
    ambient_occlusion = render(group, bounces, np.zeros((1, 3)), np.ones((1, 3, 3)), tmp_path, output="AO")
    np.testing.assert_array_equal(ambient_occlusion[0, :, 0], (0.25, 0, 1))


def test_unplugged_changes_nothing(group, tmp_path):
    base_color = np.random.default_rng(3).random((4, 4, 3))

    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        tree.links.new(sockets["base color"], node.inputs["Base Color"])
        return node.outputs["Color"]

    color = render_grid({"base color": base_color}, connect, tmp_path)
    np.testing.assert_array_equal(color, np.float32(base_color))
