# SPDX-License-Identifier: GPL-3.0-or-later
"""What rays meet, whatever it took to hand the triangles to Embree."""

import numpy as np
import pytest

from core import mesh_parts
from core.rays import Obscurance, Occluders


def soup(rng, count=500):
    """Triangles whose vertices lie anywhere in a list that has others, too."""
    vertices = rng.uniform(-1.0, 1.0, (6 * count, 3))
    corners = rng.permutation(6 * count)[: 3 * count].reshape(-1, 3)
    vertices[corners] = vertices[corners[:, :1]] + 0.2 * rng.normal(size=(count, 3, 3))
    return vertices, corners


@pytest.mark.parametrize("ignore_backfaces", [False, True])
def test_triangles_keep_their_numbers_in_several_meshes(monkeypatch, ignore_backfaces):
    rng = np.random.default_rng(1)
    vertices, triangles = soup(rng)
    origins, directions = rng.uniform(-1.0, 1.0, (2, 5000, 3)).astype(np.float32)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    obscurance = Obscurance(ignore_backfaces=ignore_backfaces)
    together = Occluders(vertices, triangles)
    one = together.hits(origins, directions, obscurance)
    monkeypatch.setattr(mesh_parts, "TRIANGLES_PER_MESH", 64)
    several = Occluders(vertices, triangles).hits(origins, directions, obscurance)
    met = one.triangle >= 0
    assert 0.2 < met.mean() < 0.999
    assert len(np.unique(one.triangle[met])) > 400
    for name in ("visible", "triangle", "distance", "normal", "u", "v"):
        np.testing.assert_array_equal(getattr(several, name), getattr(one, name), name)

    # They are those of the list: each lies in the plane of its triangle.
    at = origins[met] + one.distance[met, None] * directions[met]
    a, b, c = np.moveaxis(together.vertices[triangles[several.triangle[met]]], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    assert np.abs(np.einsum("ij,ij->i", at - a, normal)).max() < 1e-4
