# SPDX-License-Identifier: GPL-3.0-or-later
"""The default curve of k_A: guarded everywhere, exact in a spherical pit, its one number for a surface a true mean."""

import numpy as np
import pytest

from core.multibounce import equal_neighbours, surface_curve, surface_openness

ENDS = np.geomspace(1e-9, 0.5, 150)
K_A = np.sort(np.concatenate((np.linspace(0, 1, 401), ENDS, 1.0 - ENDS)))
OPENNESS = np.array([0.0, 1e-9, 1e-3, 0.02, 0.3, 0.7, 0.999, 1.0])[:, None]
ALBEDO = np.concatenate((np.linspace(0, 1, 51), 1.0 - np.geomspace(1e-9, 1e-2, 20)))
ALBEDO.sort()


def test_guarded_everywhere():
    e = surface_curve(K_A, OPENNESS, ALBEDO[:, None, None])
    assert np.isfinite(e).all() and (e >= K_A - 1e-12).all() and (e <= 1.0 + 1e-12).all()
    assert (np.diff(e, axis=0) >= -1e-12).all()  # rises with albedo
    assert (np.diff(e, axis=1) >= -1e-12).all()  # ... with what the rest of the surface sees
    assert (np.diff(e, axis=2) >= -1e-12).all()  # ... and with k_A
    assert (e[0] == K_A).all() and (e[..., -1] == 1.0).all() and (e[..., 0] == 0.0).all()


def test_white_surfaces_lose_no_energy():
    np.testing.assert_allclose(surface_curve(K_A[1:], OPENNESS[1:], 1.0), 1.0, atol=1e-12)


def test_exact_in_a_spherical_pit():
    """All points of a pit have k_A = f and F_n = f (1 - f)^n, whatever part of it they stand for."""
    for f in (0.01, 0.25, 0.5, 0.9):
        openness = surface_openness(np.full(50, f), np.linspace(0.1, 3.0, 50))
        assert openness == pytest.approx(f, abs=1e-12)
        bounces = sum((ALBEDO * (1.0 - f)) ** order for order in range(8000)) * f
        below = ALBEDO * (1.0 - f) < 0.995
        np.testing.assert_allclose(surface_curve(f, openness, ALBEDO)[below], bounces[below], atol=1e-9)


def test_with_its_own_k_a_for_openness_it_is_equal_neighbours():
    np.testing.assert_allclose(
        surface_curve(K_A, K_A, ALBEDO[:, None]), equal_neighbours(K_A, ALBEDO[:, None]), atol=1e-9
    )


def test_openness_is_the_mean_that_blocked_rays_see():
    """Of any patches that see each other alike both ways: areas times view factors are symmetric."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        exchange = rng.uniform(size=(30, 30)) * (rng.uniform(size=(30, 30)) < 0.3)
        exchange = exchange + exchange.T
        area = exchange.sum(axis=1) / rng.uniform(0.05, 1.0, 30)
        factor = exchange / area[:, None]
        k_a = 1.0 - factor.sum(axis=1)
        seen = (area[:, None] * factor * k_a).sum() / (area[:, None] * factor).sum()
        assert surface_openness(k_a, area) == pytest.approx(seen, abs=1e-12)


def test_ends_of_openness():
    assert surface_openness(np.ones(9)) == 1.0 and surface_openness(np.zeros(9)) == 0.0
    assert surface_curve(-1.0, 2.0, 0.5) == 0.0 and surface_curve(2.0, -1.0, 3.0) == 1.0
