# SPDX-License-Identifier: GPL-3.0-or-later
"""Cubemaps in OpenEXR's layout, written out here corner by corner from the drawing in ImfEnvmap.h."""

import numpy as np

from core.cubemap import locate, lookup, nodes

# Corners of the cube as ImfEnvmap.h numbers them: bit 0 is +x, bit 1 +y, bit 2 +z. Of each face the top left, top
# right, bottom left and bottom right one.
DRAWN = {
    "+X": (3, 7, 1, 5),
    "-X": (6, 2, 4, 0),
    "+Y": (6, 7, 2, 3),
    "-Y": (0, 1, 4, 5),
    "+Z": (7, 6, 5, 4),
    "-Z": (2, 3, 0, 1),
}


def directions_of(n):
    omega, node = nodes(n)
    return omega[node]


def test_faces_lie_as_openexr_draws_them():
    maps = directions_of(5)
    for face, (name, corners) in enumerate(DRAWN.items()):
        for corner, at in zip(corners, ((0, 0), (0, -1), (-1, 0), (-1, -1)), strict=True):
            expected = [1.0 if corner >> axis & 1 else -1.0 for axis in range(3)]
            assert np.abs(maps[face][at] * 3.0**0.5 - expected).max() < 1e-12, (name, at)
        axis = np.zeros(3)
        axis["XYZ".index(name[1])] = 1.0 if name[0] == "+" else -1.0
        assert (maps[face, 2, 2] == axis).all()


def test_every_direction_of_the_map_is_found_where_it_lies():
    n = 6
    maps = directions_of(n)
    inner = maps[:, 1:-1, 1:-1].reshape(-1, 3)
    face, column, row = locate(7.0 * inner, n)
    expected = np.indices((6, n - 2, n - 2)).reshape(3, -1)
    assert (face == expected[0]).all()
    assert np.abs(row - expected[1] - 1).max() < 1e-12 and np.abs(column - expected[2] - 1).max() < 1e-12
    omega, node = nodes(n)
    assert len(omega) == 6 * (n - 1) ** 2 + 2 and set(node.ravel()) == set(range(len(omega)))
    assert np.isfinite(np.stack(locate(np.zeros((1, 3)), n))).all()


def test_lookup_is_exact_at_texels_and_continuous_over_edges_and_corners():
    n = 8
    omega, node = nodes(n)
    random = np.random.default_rng(1)
    values = random.normal(size=(len(omega), 2))
    assert np.abs(lookup(values[node], omega) - values).max() < 1e-12
    # Pairs of directions on both sides of the edges |x| = |y| and so on, corners among them.
    edge = random.uniform(-1.0, 1.0, (3000, 3))
    edge[np.arange(3000), random.integers(0, 3, 3000)] = 1.0
    edge[np.arange(3000), random.integers(0, 3, 3000)] = -1.0
    edge[:200] = np.sign(edge[:200])
    step = 1e-7 * random.normal(size=edge.shape)
    jump = np.abs(lookup(values[node], edge + step) - lookup(values[node], edge - step)).max()
    slope = n * np.abs(values).max() * 4.0
    print(f"cubemap: a step of 1e-7 over edges changes values by {jump:.1e}; slopes allow {1e-6 * slope:.1e}")
    assert jump < 1e-6 * slope
