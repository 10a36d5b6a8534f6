# SPDX-License-Identifier: GPL-3.0-or-later
"""F0 by brute force: Blender's own BVH and plain random rays, nothing of the extension's."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree

from .meshes import read


def tree_of(mesh: bpy.types.Mesh) -> BVHTree:
    """Of ``mesh.loop_triangles``: the tree itself would split quads that are not flat in another way than Blender."""
    mesh.calc_loop_triangles()
    triangles = read(mesh.loop_triangles, "vertices", 3, np.int32)
    return BVHTree.FromPolygons(read(mesh.vertices, "co", 3).tolist(), triangles.tolist())


def brute_force(tree: BVHTree, points, normals, rays: int, seed: int = 1) -> np.ndarray:
    """The share of random cosine-weighted rays that escape from ``points`` (n, 3), a hair along their unit ``normals``.

    The rms error of a point is sqrt(F0 (1 - F0) / rays).
    """
    random = np.random.default_rng(seed)
    offset = 1e-5 * np.ptp(points, axis=0).max()
    result = []
    for origin, normal in zip(points + offset * normals, normals, strict=True):
        # A unit normal plus a point of the unit sphere is cosine-distributed.
        ball = random.normal(size=(rays, 3))
        directions = normal + ball / np.linalg.norm(ball, axis=1, keepdims=True)
        start = origin.tolist()
        result.append(sum(tree.ray_cast(start, direction)[3] is None for direction in directions.tolist()) / rays)
    return np.array(result)
