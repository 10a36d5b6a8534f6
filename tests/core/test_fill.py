# SPDX-License-Identifier: GPL-3.0-or-later
"""Points inside of something: which those are, and the values they take."""

import numpy as np

from core.closed_parts import in_closed_parts
from core.fill import fill_lost, fill_points, fill_texels
from core.visibility import Visibility

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


def test_what_lost_points_see_fits_their_normals():
    """F0 = 2 alpha b . n with the point's own normal; alpha and F0 are means."""
    random = np.random.default_rng(1)
    normals = random.normal(size=(3, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    alpha, bent = np.array([0.5, 0.3, 0.0]), random.uniform(-0.4, 0.4, (3, 3))
    f0 = 2 * alpha * (bent * normals).sum(axis=1)
    single = (each.astype(np.float32) for each in (f0, alpha, bent))
    found = Visibility(*single, lost=np.array([False, False, True]))
    fill_lost(found, np.array([(0, 2), (2, 1)]), normals)
    np.testing.assert_allclose((found.f0[2], found.alpha[2]), (f0[:2].mean(), alpha[:2].mean()), atol=1e-6)
    np.testing.assert_allclose(found.f0, 2 * found.alpha * (found.bent * normals).sum(axis=1), atol=1e-6)
    np.testing.assert_allclose(found.bent[:2], bent[:2], atol=1e-7)
