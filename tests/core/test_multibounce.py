# SPDX-License-Identifier: GPL-3.0-or-later
"""The published fit: as printed where it holds, bounded by energy everywhere, and its comparators."""

import numpy as np

from core import multibounce

# dense towards both ends
ALPHA = np.concatenate((np.linspace(0, 1, 1001), np.geomspace(1e-9, 1e-2, 200), 1 - np.geomspace(1e-9, 0.3, 2000)))
ALPHA.sort()
ALBEDO = np.linspace(0, 1, 101)[:, None]


def printed(alpha, albedo):
    """Equations (7), (9), (11) and (12) of the notes, no guard."""
    f0 = alpha * (1 + (1 - alpha) ** 0.75 / 2)
    f1 = 27.576937094210385 * alpha * (1 - alpha) ** 1.5 * np.exp(-3.3364392003423804 * alpha ** (1 / 4))
    tau = 1 - f1 / (1 - f0)
    return f0 + albedo / (1 - albedo * tau) * f1


def test_as_printed_where_the_printed_tau_is_positive():
    alpha = np.linspace(1e-6, 0.76, 500)
    np.testing.assert_allclose(multibounce.irradiance(alpha, ALBEDO), printed(alpha, ALBEDO), atol=1e-12)


def test_the_printed_form_has_the_pole_that_the_guard_removes():
    """At albedo .3 it jumps from -32.7 to +4.2 near alpha = .961 (a negative irradiance: not a fit any more)."""
    alpha = np.linspace(0.96, 0.962, 2001)
    assert printed(alpha, 0.3).min() < -30
    assert np.ptp(multibounce.irradiance(alpha, 0.3)) < 1e-3


def test_guarded_everywhere():
    e = multibounce.irradiance(ALPHA, ALBEDO)
    assert np.isfinite(e).all()
    assert (e >= multibounce.f0(ALPHA) - 1e-12).all() and (e <= 1 + 1e-12).all()
    assert (np.diff(e, axis=0) >= -1e-12).all()
    assert (multibounce.irradiance(1.0, ALBEDO) == 1.0).all()
    tau = multibounce.tau(ALPHA)
    assert (tau >= 0.0).all() and (tau <= 1.0).all()
    # continuous: no step between close neighbours
    fine = np.linspace(0.7, 1.0, 30001)
    assert np.abs(np.diff(multibounce.tau(fine))).max() < 1e-3
    assert np.abs(np.diff(multibounce.irradiance(fine, np.linspace(0, 0.9, 10)[:, None]))).max() < 1e-3


def test_white_surfaces_lose_no_energy():
    """At albedo 1 all bounces sum to 1: what the notes derive tau from."""
    np.testing.assert_allclose(multibounce.irradiance(np.linspace(1e-3, 1, 999), 1.0), 1.0, atol=1e-12)


def test_outside_inputs_are_clamped():
    assert multibounce.irradiance(-1.0, 0.5) == 0.0
    assert multibounce.irradiance(2.0, 3.0) == 1.0
    np.testing.assert_allclose(multibounce.irradiance(0.5, -1.0), multibounce.f0(0.5))


def test_bounces_of_the_spherical_pit():
    """There F_n = f (1 - f)^n, so that T = 1 - f and E = f / (1 - rho (1 - f))."""
    f = np.linspace(0.01, 0.99, 50)
    e = multibounce.irradiance_from_bounces(f, f * (1 - f), f * (1 - f) ** 2, 1 - f, ALBEDO)
    np.testing.assert_allclose(e, f / (1 - ALBEDO * (1 - f)), atol=1e-12)
    np.testing.assert_allclose(multibounce.equal_neighbours(f, ALBEDO), f / (1 - ALBEDO * (1 - f)), atol=1e-12)


def test_bounces_are_bounded_whatever_comes_in():
    channels = np.random.default_rng(0).uniform(-0.5, 1.5, (4, 5000))
    e = multibounce.irradiance_from_bounces(*channels, ALBEDO)
    assert np.isfinite(e).all() and (e <= 1 + 1e-12).all() and (e >= np.clip(channels[0], 0, 1) - 1e-12).all()
    assert (np.diff(e, axis=0) >= -1e-12).all()


def test_jimenez_is_open_at_one_and_never_darker_than_its_ao():
    """The cubic's coefficients sum to 1 within 1e-3 at every albedo, as published."""
    k = np.linspace(0, 1, 101)
    e = multibounce.jimenez_2016(k, ALBEDO)
    assert (e >= k).all()
    np.testing.assert_allclose(multibounce.jimenez_2016(1.0, ALBEDO), 1.0, atol=2e-3)
