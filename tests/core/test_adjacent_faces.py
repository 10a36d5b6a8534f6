# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces across seams, where a layout has edges without length and coordinates that are not finite."""

import numpy as np

from core.adjacent_faces import AdjacentFaces

# Two triangles that share the edge 1 to 2, apart in the layout.
VERTICES = np.array([(0, 1, 2), (2, 1, 3)])
LEFT, RIGHT = [(0.0, 0.0), (0.25, 0.0), (0.25, 0.5)], [(0.75, 0.5), (0.75, 0.0), (1.0, 0.0)]
OPEN = np.zeros((8, 8), bool)


def beyond(faces, x, y):
    x, y = np.array(x), np.array(y)
    return faces.beyond(faces.nearest(x, y), x, y).T


def test_other_side_of_a_seam():
    """What lies a texel right of the left face is a texel inside of the right one."""
    at = beyond(AdjacentFaces(np.array([LEFT, RIGHT]), VERTICES, OPEN, 4), [2.5], [2.25])
    np.testing.assert_allclose(at, [(6.5, 2.25)], atol=1e-12)


def test_seam_that_is_a_single_place():
    """One side of the shared edge has no length; the surface's own borders have nothing beyond."""
    collapsed = [(0.75, 0.5), (0.75, 0.5), (1.0, 0.0)]
    faces = AdjacentFaces(np.array([LEFT, collapsed]), VERTICES, OPEN, 4)
    at = beyond(faces, [2.5, 1.0], [2.25, -0.5])
    np.testing.assert_allclose(at[0], (6.0, 4.0), atol=1e-12)
    assert np.isnan(at[1]).all()


def test_coordinates_that_are_not_finite_have_no_seams():
    broken = [(0.75, 0.5), (np.nan, 0.0), (1.0, 0.0)]
    at = beyond(AdjacentFaces(np.array([LEFT, broken]), VERTICES, OPEN, 4), [2.5], [2.25])
    assert np.isnan(at).all()


def test_seams_far_outside_of_the_image_cost_nothing_and_change_nothing():
    """A layout that is repeated over a hundred thousand tiles has the points of the one."""
    layout = np.array([LEFT, RIGHT])
    far = (layout - 0.5) * 1e5 + (3e5, 0.0)
    both = AdjacentFaces(np.concatenate((layout, far)), np.concatenate((VERTICES, VERTICES + 4)), OPEN, 4)
    at = [2.5, 1.0], [2.25, -0.5]
    np.testing.assert_array_equal(beyond(both, *at), beyond(AdjacentFaces(layout, VERTICES, OPEN, 4), *at))
    assert len(both._seam) < 100
    assert not len(AdjacentFaces(layout, VERTICES, ~OPEN, 4)._seam)
