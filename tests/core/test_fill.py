# SPDX-License-Identifier: GPL-3.0-or-later
"""Points inside of something: which those are, and the values they take."""

import numpy as np

from core.closed_parts import in_closed_parts
from core.fill import fill_points, fill_texels, straight_cones

TETRAHEDRON = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])


def test_closed_parts():
    """A tetrahedron is closed, also turned inside out and beside others; without a face it is not, nor is one whose
    faces only meet in space."""
    opened = TETRAHEDRON[:3] + 4
    loose = np.arange(12).reshape(-1, 3) + 8
    both = np.concatenate((TETRAHEDRON, opened, loose, TETRAHEDRON[:, ::-1] + 20))
    assert in_closed_parts(both, 24).tolist() == [True] * 4 + [False] * 7 + [True] * 4
    assert in_closed_parts(np.empty((0, 3), int), 0).tolist() == []


def test_texels_take_the_nearest_of_their_island():
    random = np.random.default_rng(0)
    covered = np.zeros((24, 31), bool)
    covered[2:12, 3:13] = covered[2:12, 14:20] = covered[15:22, 4:9] = True
    known = covered & (random.random(covered.shape) < 0.3)
    known[15:22, 4:9] = False  # an island of which nothing is known
    known[2:12, 12] = False  # the nearest known one may lie across the gap
    rows = np.stack(np.indices(covered.shape), axis=-1).astype(float)
    image = np.where(known[..., None], rows, -1.0)
    fill_texels([image], covered, known)
    island = np.zeros(covered.shape, int)
    island[2:12, 3:13], island[2:12, 14:20] = 1, 2
    assert (image[known] == rows[known]).all()
    assert (image[(island == 0)] == -1).all()
    for number in (1, 2):
        sources = rows[known & (island == number)]
        for place in np.argwhere((island == number) & ~known):
            nearest = np.linalg.norm(sources - place, axis=1).min()
            assert np.linalg.norm(image[tuple(place)] - place) == nearest
            assert (sources == image[tuple(place)]).all(axis=1).any()


def test_points_take_the_mean_of_their_neighbours():
    """0 - 1 - 2 - 3 in a row with a second way from 3 to 0; 4 - 5 apart."""
    edges = np.array([(0, 1), (1, 2), (2, 1), (2, 3), (3, 0), (4, 5)])
    values = np.array([8.0, 0, 0, 0, 0, 0])[:, None].repeat(2, axis=1).astype(np.float32)
    fill_points([values], np.array([True, False, False, False, False, False]), edges)
    assert values[:, 0].tolist() == [8, 8, 8, 8, 0, 0]
    values = np.array([[8.0], [0], [0], [2], [0], [0]])
    fill_points([values], np.array([True, False, False, True, False, True]), edges)
    assert values[:, 0].tolist() == [8, 8, 2, 2, 0, 0]
    values = np.array([[8.0], [0], [2], [0], [0], [0]])
    fill_points([values], np.array([True, False, True, False, False, False]), edges)
    assert values[:, 0].tolist() == [8, 5, 2, 5, 0, 0]


def test_straight_cones_fit_what_they_come_from():
    """F0 = 2 alpha b . n, as far as a direction of length 1 reaches."""
    normals = np.array([(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 1.0, 0.0)])
    f0, alpha = np.array([0.4, 0.3, 0.0]), np.array([0.25, 0.3, 0.0])
    bent = straight_cones(f0, alpha, normals)
    np.testing.assert_allclose(2 * alpha * (bent * normals).sum(axis=1), f0, atol=1e-15)
    np.testing.assert_allclose(np.cross(bent, normals), 0, atol=1e-15)
