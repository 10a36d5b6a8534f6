# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Spherical Cap Occlusion`` rendered against core.cap and against what is known of caps."""

import importlib

import numpy as np
import pytest

from .grid_render import render_grid


@pytest.fixture
def group(extension, empty_scene):
    return importlib.import_module(extension.__name__ + ".shader_nodes.spherical_cap").ensure()


def render(group, solid_angle, cosine, folder):
    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        for name in ("Solid Angle", "Cosine"):
            tree.links.new(sockets[name], node.inputs[name])
        return node.outputs["Occlusion"]

    values = {"Solid Angle": np.float32(solid_angle), "Cosine": np.float32(cosine)}
    return render_grid(values, connect, folder)[..., 0]


def test_agrees_with_core(group, tmp_path):
    """All caps and tilts on a grid, with the ends, and values that are out of range."""
    from core.cap import occlusion

    solid_angle, cosine = np.meshgrid(np.linspace(0, 4 * np.pi, 193), np.linspace(-1, 1, 129))
    solid_angle[:, -2:] = (-1, 20)
    cosine[-2:] = np.array([(-1.5,), (1.5,)])
    solid_angle, cosine = np.float32(solid_angle).astype(float), np.float32(cosine).astype(float)
    error = np.abs(render(group, solid_angle, cosine, tmp_path) - occlusion(solid_angle, cosine)).max()
    print(f"Spherical Cap Occlusion in Cycles against core.cap: {error:.1e}")
    assert error < 1e-5


def test_caps_that_the_horizon_does_not_cut(group, tmp_path):
    """They block sin(half angle)^2 k: half angles up to 90 degrees less the tilt."""
    half, part = np.meshgrid(np.radians(np.linspace(0, 90, 91)), np.linspace(0, 1, 31))
    tilt = part * (np.pi / 2 - half)
    found = render(group, 2 * np.pi * (1 - np.cos(half)), np.cos(tilt), tmp_path)
    np.testing.assert_allclose(found, np.sin(half) ** 2 * np.cos(tilt), rtol=0, atol=1e-5)


def test_hemispheres(group, tmp_path):
    """Half a sphere of directions blocks (1 + k) / 2."""
    cosine = np.linspace(-1, 1, 201)[None, :]
    found = render(group, np.full_like(cosine, 2 * np.pi), cosine, tmp_path)
    np.testing.assert_allclose(found, (1 + cosine) / 2, rtol=0, atol=1e-5)


def test_unconnected_it_blocks_nothing(group, tmp_path):
    def connect(tree, sockets):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        return node.outputs["Occlusion"]

    found = render_grid({"nothing": np.zeros((4, 4), np.float32)}, connect, tmp_path)
    np.testing.assert_allclose(found, 0, atol=1e-6)
