# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of Suzanne against brute force."""

import bpy
import numpy as np

from .bakes import bake, f0, rms
from .brute_force import brute_force, tree_of
from .meshes import positions, read, suzanne


def test_vertices():
    """8k vertices, 256 samples. Brute force's own error here is .006 rms a vertex, .0004 of their mean."""
    obj = suzanne(levels=2)
    assert len(obj.data.vertices) == 7958
    bake(obj, samples=256)
    some = np.random.default_rng(0).choice(7958, 300, replace=False)
    normals = read(obj.data.vertex_normals, "vector", 3)
    truth = brute_force(tree_of(obj.data), positions(obj)[some], normals[some], rays=4096)
    assert np.ptp(truth) > 0.8
    error = f0(obj)[some] - truth
    print(f"against brute force: rms {rms(error):.4f}, bias {error.mean():+.4f}, worst {abs(error).max():.3f}")
    assert rms(error) < 0.02
    assert abs(error.mean()) < 0.002


def test_cage_of_a_subdivision():
    """The cage's vertices are baked where subdivision draws them: they are the first of the evaluated mesh."""
    obj = suzanne()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bake(obj, samples=256)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    some = slice(len(obj.data.vertices))
    drawn = read(evaluated.vertices, "co", 3)[some]
    normals = read(evaluated.vertex_normals, "vector", 3)[some]
    error = f0(obj) - brute_force(tree_of(evaluated), drawn, normals, rays=1024)
    print(f"against brute force: rms {rms(error):.4f}, bias {error.mean():+.4f}, worst {abs(error).max():.3f}")
    assert rms(error) < 0.025
    assert abs(error.mean()) < 0.004
