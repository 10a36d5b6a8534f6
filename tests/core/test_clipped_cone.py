# SPDX-License-Identifier: GPL-3.0-or-later
"""A cosine lobe clipped to a cone, against quadrature over that cone."""

import numpy as np
import pytest

from core import spherical_harmonics as sh
from core.clipped_cone import mean_light, zonal

APERTURES = (5, 10, 20, 30, 45, 60, 75, 85, 90)
LIGHT = np.random.default_rng(0).normal(size=(9, 3))


def cone(axis, cosine, rings=64):
    """Directions (n, 3) within a cone, and their solid angles (n,)."""
    z, weight = np.polynomial.legendre.leggauss(rings)
    z, weight = cosine + (z + 1) / 2 * (1 - cosine), weight / 2 * (1 - cosine)
    helper = np.eye(3)[np.abs(axis).argmin()]
    right = np.cross(axis, helper)
    right /= np.linalg.norm(right)
    azimuth = np.arange(rings) * (2 * np.pi / rings)
    around = np.cos(azimuth)[:, None] * right + np.sin(azimuth)[:, None] * np.cross(axis, right)
    directions = z[:, None, None] * axis + np.sqrt(1 - z * z)[:, None, None] * around
    return directions.reshape(-1, 3), np.repeat(weight * 2 * np.pi / rings, rings)


@pytest.mark.parametrize("degrees", APERTURES)
def test_about_the_normal(degrees):
    """``sh.convolve`` with ``zonal`` gives the integral of L cos over the cone."""
    cosine = np.cos(np.radians(degrees))
    normal = np.array((0.48, -0.6, 0.64))
    directions, weights = cone(normal, cosine)
    expected = ((directions @ normal) * weights) @ sh.evaluate(LIGHT, directions)
    found = sh.evaluate(sh.convolve(LIGHT, zonal(cosine)), normal)
    error = np.abs(found - expected).max()
    print(f"{degrees} degrees about the normal: within {error:.1e}")
    assert error < 1e-9
    share = np.pi * (1 - cosine**2)
    np.testing.assert_allclose(mean_light(LIGHT, normal[None], normal[None], np.array([cosine]))[0], found / share)


@pytest.mark.parametrize("degrees", APERTURES)
def test_about_any_axis(degrees):
    """Also where the cone dips below the horizon: n . w as it is, negative there."""
    cosine = np.cos(np.radians(degrees))
    normal, worst = np.array((0.0, 0.6, 0.8)), 0.0
    for tilt in np.radians((0, 10, 45, 80, 120)):
        axis = np.cos(tilt) * normal + np.sin(tilt) * np.array((0.6, 0.64, -0.48))
        directions, weights = cone(axis, cosine)
        expected = ((directions @ normal) * weights) @ sh.evaluate(LIGHT, directions)
        found = mean_light(LIGHT, normal[None], axis[None], np.array([cosine]))[0] * np.pi * (1 - cosine**2)
        worst = max(worst, np.abs(found - expected).max())
    print(f"{degrees} degrees about any axis: within {worst:.1e}")
    assert worst < 1e-9


def test_open_cone_is_the_cosine_lobe():
    np.testing.assert_allclose(zonal(0.0), sh.COSINE_LOBE)
    normals = np.eye(3)
    light = mean_light(LIGHT, normals, normals, np.zeros(3))
    np.testing.assert_allclose(light, sh.irradiance(LIGHT, normals))


def test_narrow_cone_shows_one_direction():
    normals, axes = np.eye(3)[:1], np.array([(0.6, 0.8, 0.0)])
    np.testing.assert_allclose(mean_light(LIGHT, normals, axes, np.ones(1)), 0.6 * sh.evaluate(LIGHT, axes), atol=1e-12)
