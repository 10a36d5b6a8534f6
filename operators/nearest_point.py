# SPDX-License-Identifier: GPL-3.0-or-later
"""Where points of one surface lie on another, by Blender's own BVH tree."""

from __future__ import annotations

import math

import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree
from numpy.typing import NDArray

from ..core.surface import Surface

# Fractions of the surface's size: how far a query is lifted off along its normal, so that of two sheets at one place
# the outer one is nearer, and how far it may look for a sheet that faces its way.
LIFT, REACH = 1e-4, 0.25


def nearest_points(
    positions: NDArray[np.float64], normals: NDArray[np.float64], surface: Surface
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Triangle (k,) and barycentric coordinates (k, 3) of the point of ``surface`` that stands for each of k points.

    The nearest one. Where that faces the other way, as the inner sheet of a thickened one does, the next sheet along
    the point's normal if it faces the point's way. ``positions``, ``normals`` (k, 3): world space, unit normals.
    """
    # The tree is single precision, where squares of large distances overflow. A power of two rounds nothing.
    centre, unit = surface.vertices.mean(axis=0), 2.0 ** math.frexp(surface.extent)[1]
    extent = float(surface.extent) / unit
    triangles = surface.vertex_triangles
    tree = BVHTree.FromPolygons(((surface.vertices - centre) / unit).tolist(), triangles.tolist(), all_triangles=True)

    def nearest(position: list[float], normal: list[float]) -> tuple[int, Vector]:
        normal = Vector(normal)
        lifted = Vector(position) + LIFT * extent * normal
        point, facing, index, _ = tree.find_nearest(lifted)
        if facing.dot(normal) < 0.0:
            further, facing, next_index, _ = tree.ray_cast(lifted, normal, REACH * extent)
            if next_index is not None and facing.dot(normal) > 0.0:
                point, index = further, next_index
        return index, point

    found = [nearest(*query) for query in zip(((positions - centre) / unit).tolist(), normals.tolist(), strict=True)]
    triangle = np.array([index for index, _ in found], np.intp)
    points = np.array([point for _, point in found], np.float64).reshape(-1, 3) * unit + centre
    return triangle, surface.barycentric_at(triangle, points)
