# SPDX-License-Identifier: GPL-3.0-or-later
"""What a cap blocks against quadrature, what two share against counting, and what the second moment makes of caps."""

from itertools import pairwise

import numpy as np

from core.cap import cap_of_moment, cap_overlap, covered_cap, moment_of_cap, occlusion

from .directions import sphere_directions


def by_quadrature(solid_angle, cosine, nodes=64):
    """(1/pi) * integral over the cap of max(0, n . w), by Gauss-Legendre in both angles.

    At angle t from the axis n . w = k cos t + h cos(phi), h = sin(tilt) sin t, positive for |phi| < arccos(-k cos t /
    h). The integrand's kinks in t, where the horizon's circle is met, split the range; a smoothstep in each part takes
    away the roots that are left at its ends.
    """
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    w, x = w * 6.0 * x * (1.0 - x), x * x * (3.0 - 2.0 * x)
    half, tilt = np.arccos(1.0 - solid_angle / (2.0 * np.pi)), np.arccos(cosine)
    kinks = np.sort(np.clip([0.0, abs(0.5 * np.pi - tilt), np.pi - abs(0.5 * np.pi - tilt), half], 0.0, half))
    total = 0.0
    for start, end in pairwise(kinks):
        t = start + (end - start) * x
        up, side = cosine * np.cos(t), np.sin(tilt) * np.sin(t)
        limit = np.arccos(np.clip(-up / np.maximum(side, 1e-300), -1.0, 1.0))
        phi = limit[:, None] * x
        inner = 2.0 * limit * (np.maximum(up[:, None] + side[:, None] * np.cos(phi), 0.0) * w).sum(axis=1)
        total += (end - start) * (inner * np.sin(t) * w).sum()
    return total / np.pi


def test_closed_form_is_the_integral():
    solid_angles = np.concatenate(([1e-6, 1e-3, 2 * np.pi, 4 * np.pi], np.linspace(0.01, 4 * np.pi, 25)))
    cosines = np.concatenate(([-1.0, 0.0, 1.0], np.linspace(-0.999, 0.999, 24)))
    expected = np.array([[by_quadrature(s, k) for k in cosines] for s in solid_angles])
    error = np.abs(occlusion(solid_angles[:, None], cosines) - expected).max()
    print(f"cap: closed form against quadrature, largest difference {error:.1e}")
    assert error < 1e-6


def test_known_caps():
    omega = np.linspace(0.0, 4 * np.pi, 200)
    c = 1.0 - omega / (2.0 * np.pi)
    # Overhead: 1 - c^2 up to the hemisphere, then all; below the horizon nothing until it reaches past it.
    assert np.abs(occlusion(omega, 1.0) - np.where(c > 0.0, 1.0 - c * c, 1.0)).max() < 1e-6
    assert np.abs(occlusion(omega, -1.0) - np.where(c > 0.0, 0.0, c * c)).max() < 1e-6
    # A hemisphere tilted by any angle: (1 + k) / 2.
    k = np.linspace(-1.0, 1.0, 201)
    assert np.abs(occlusion(2.0 * np.pi, k) - 0.5 * (1.0 + k)).max() < 1e-6
    assert (np.diff(occlusion(omega[:, None], k), axis=0) > -1e-9).all()
    assert (occlusion([-1.0, 20.0], [[2.0], [-2.0]]) == [[0.0, 1.0], [0.0, 1.0]]).all()


def test_moments_of_caps():
    omega = np.linspace(1e-3, 2.0 * np.pi, 100)
    assert np.abs(moment_of_cap(omega) - (1.0 - (1.0 - omega / (2.0 * np.pi)) ** 2)).max() < 1e-12
    assert np.abs(cap_of_moment(moment_of_cap(omega)) - omega).max() < 1e-6


def test_a_cap_that_is_blocked_in_part_keeps_both_moments():
    larger, part = np.meshgrid(np.linspace(0.1, 4.0 * np.pi, 50), np.linspace(0.1, 1.0, 10))
    t, found = covered_cap(part * larger, part * moment_of_cap(larger))
    assert np.abs(t - part).max() < 1e-9 and np.abs(found - larger).max() < 1e-9
    # More moment than any set of directions has: the plain cap.
    t, found = covered_cap(1.0, 0.9)
    assert t == 1.0 and found == 1.0


def test_overlap_of_caps():
    """Caps that cross, touch, lie within each other and apart, and that cover the sphere together."""
    rng = np.random.default_rng(0)
    directions, worst = sphere_directions(), 0.0
    for _ in range(90):
        first, second, between = np.cos(rng.uniform((0.1, 0.1, 0), np.pi))
        axis = np.array((np.sqrt(1 - between**2), 0, between))
        count = ((directions[:, 2] > first) & (directions @ axis > second)).mean() * 2
        worst = max(worst, abs(cap_overlap(first, second, between) - count))
    print(f"overlap of two caps: within {worst:.1e}")
    assert worst < 1e-3


def test_overlap_of_caps_about_one_axis():
    np.testing.assert_allclose(cap_overlap((0.5, 0.9, 0.7), (0.8, 0.2, 0.7), 1.0), (0.2, 0.1, 0.3), atol=1e-9)
    np.testing.assert_allclose(cap_overlap((0.5, 0.9, 0.0), (0.8, 0.2, 0.0), -1.0), 0.0, atol=1e-9)
    # All of the sphere twice, and what a cap leaves and the cap.
    np.testing.assert_allclose(cap_overlap((-1.0, -0.4), (-1.0, 0.4), (0.3, -1.0)), (2.0, 0.0), atol=1e-9)
