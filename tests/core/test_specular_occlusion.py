# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlap of two cones says of reflections."""

import numpy as np

from core.specular_occlusion import lobe_cosine, specular_occlusion

from .directions import sphere_directions


def reflect(axis, alpha, tilt, roughness):
    """A view from ``tilt`` radians off the normal +z, towards +x."""
    views = np.stack((np.sin(tilt), np.zeros_like(tilt), np.cos(tilt)), axis=-1)
    up = np.broadcast_to((0.0, 0.0, 1.0), views.shape)
    return specular_occlusion(np.broadcast_to(axis, views.shape), alpha, up, views, roughness)


def test_open_surfaces_reflect_all_and_closed_ones_nothing():
    tilt, roughness = np.meshgrid(np.linspace(0, 1.55, 20), np.linspace(0, 1, 11))
    tilt, roughness = tilt.ravel(), roughness.ravel()
    np.testing.assert_allclose(reflect((0, 0, 1), np.ones_like(tilt), tilt, roughness), 1.0, atol=1e-9)
    np.testing.assert_allclose(reflect((0, 0, 1), np.zeros_like(tilt), tilt, roughness), 0.0, atol=1e-3)


def test_a_mirror_sees_the_sky_or_not():
    """A cone of 60 degrees about the normal: the mirrored view is in it or out of it."""
    tilt = np.radians((0, 30, 55, 65, 80))
    np.testing.assert_allclose(reflect((0, 0, 1), np.full(5, 0.5), tilt, np.zeros(5)), (1, 1, 1, 0, 0), atol=1e-6)


def test_rough_surfaces_against_counting():
    """The share of the lobe's cone above the horizon that lies in the bent cone."""
    directions = sphere_directions()
    axis, alpha, tilt = np.array((-0.6, 0.0, 0.8)), 0.4, 0.7
    mirrored = np.array((-np.sin(tilt), 0, np.cos(tilt)))
    for roughness in (0.3, 0.5, 0.8, 1.0):
        lobe = (directions @ mirrored > lobe_cosine(roughness)) & (directions[:, 2] > 0)
        counted = (directions[lobe] @ axis > 1 - alpha).mean()
        found = reflect(axis, np.array([alpha]), np.array([tilt]), np.array([roughness]))[0]
        assert abs(found - counted) < 0.01, roughness
