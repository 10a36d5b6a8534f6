# SPDX-License-Identifier: GPL-3.0-or-later
"""Obscurance under a ceiling at height h: a ray at cos(theta) = c hits it at distance h / c.

With k = h / max_distance, a hit counts where c > k, and V = rho(k / c) there, else 1:

    F0    = k^2 + integral from k to 1 of 2 c rho(k / c) dc
    alpha = k   + integral from k to 1 of     rho(k / c) dc
"""

import math

import numpy as np
import pytest

from .bakes import alpha, bake, f0
from .meshes import plate

K = 0.5
LOG = math.log(1 / K)
# falloff: rho(t), F0, alpha
CLOSED_FORMS = {
    "NONE": (K**2, K),  # 0
    "LINEAR": (2 * K - K**2, K + K * LOG),  # t
    "SMOOTH": (6 * K**2 * LOG - 3 * K**2 + 4 * K**3, 3 * K - 3 * K**2 + K**3),  # 3 t^2 - 2 t^3
}


@pytest.mark.parametrize("scale", [1.0, 0.1])
@pytest.mark.parametrize("falloff", CLOSED_FORMS)
def test_under_a_ceiling(falloff, scale):
    floor = plate("Floor", half=1 / scale)
    floor.scale = (scale,) * 3  # distances are the world's, whatever the object's scale
    plate("Ceiling", half=100, location=(0, 0, 1.5))
    bake(floor, samples=1024, max_distance=1.5 / K, falloff=falloff)
    expected_f0, expected_alpha = CLOSED_FORMS[falloff]
    np.testing.assert_allclose(f0(floor), expected_f0, atol=0.004)
    np.testing.assert_allclose(alpha(floor), expected_alpha, atol=0.006)


@pytest.mark.parametrize("falloff", CLOSED_FORMS)
def test_ground_plane(falloff):
    """The infinite floor, from above and looking down."""
    obj = plate(location=(0, 0, 1.5))
    obj.rotation_euler = (math.pi, 0, 0)
    lowest = plate("Lowest", half=0.01)
    bake(obj, lowest, samples=1024, use_ground_plane=True, max_distance=1.5 / K, falloff=falloff)
    expected_f0, expected_alpha = CLOSED_FORMS[falloff]
    np.testing.assert_allclose(f0(obj), expected_f0, atol=0.004)
    np.testing.assert_allclose(alpha(obj), expected_alpha, atol=0.006)


def test_falloff_says_nothing_without_a_distance():
    floor = plate("Floor")
    plate("Ceiling", half=1e4, location=(0, 0, 1))
    bake(floor, falloff="SMOOTH")
    np.testing.assert_allclose(f0(floor), 0, atol=1e-6)
