# SPDX-License-Identifier: GPL-3.0-or-later
"""Histograms of bounces against alpha, and fits that give a known curve back."""

import csv
import io

import numpy as np
import pytest

from core import multibounce
from core.bounce_curves import LEAST_F0_EXPONENT, BounceCurves, bin_bounces, csv_text, fit_curves
from core.multibounce import A, B, Coefficients
from core.simulation import Simulation

from .endless_strips import rms


def points_of(coefficients, noise, seed=0, count=200_000):
    """Points whose F0, F1 and F2 = tau F1 are those of a fit, each with normal noise of its own."""
    rng = np.random.default_rng(seed)
    alpha = rng.beta(3.0, 1.5, count)
    f0, f1 = multibounce.f0(alpha, coefficients), multibounce.f1(alpha, coefficients)
    bounces = np.stack((f0, f1, multibounce.tau(alpha, coefficients) * f1))
    return Simulation(alpha, bounces + noise * rng.normal(size=bounces.shape))


@pytest.mark.parametrize("noise", [0.0, 0.02])
@pytest.mark.parametrize("seed", range(4))
def test_the_published_coefficients_come_back(noise, seed):
    fit = fit_curves(bin_bounces(points_of(multibounce.PUBLISHED, noise, seed)))
    print(
        f"noise {noise}: A {fit.a / A - 1:+.2%}, B {fit.b / B - 1:+.2%}, F0 {fit.f0_factor:.4f} {fit.f0_exponent:.4f}"
    )
    assert abs(fit.a / A - 1.0) < 0.01 and abs(fit.b / B - 1.0) < 0.01
    assert abs(fit.f0_factor / 0.5 - 1.0) < 0.01 and abs(fit.f0_exponent / 0.75 - 1.0) < 0.01


def test_other_coefficients_come_back():
    truth = Coefficients(9.0, 2.4, 0.3, 0.5)
    fit = fit_curves(bin_bounces(points_of(truth, 0.01)))
    for name in ("a", "b", "f0_factor", "f0_exponent"):
        print(f"{name}: {getattr(fit, name):.4f} of {getattr(truth, name)}")
        assert abs(getattr(fit, name) / getattr(truth, name) - 1.0) < 0.02


def test_residuals_are_the_rms_over_points():
    """F0 and F1 too high by .01 in every other bin, where the points are alike: their rms about the fit."""
    ao = (np.arange(100) + 0.5) / 100
    ripple = 0.01 * (-1.0) ** np.arange(100)
    f0, f1, tau = multibounce.f0(ao), multibounce.f1(ao), multibounce.tau(ao)
    curves = BounceCurves(ao, np.full(100, 50), np.stack((f0 + ripple, f1 + ripple, (tau + ripple) * (f1 + ripple))))
    fit = fit_curves(curves)
    print(f"residuals of a ripple of .01: F0 {fit.f0_rms:.5f}, F1 {fit.f1_rms:.5f}, tau {fit.tau_rms:.5f}")
    for form, measured, residual in (
        (multibounce.f0, f0 + ripple, fit.f0_rms),
        (multibounce.f1, f1 + ripple, fit.f1_rms),
    ):
        assert abs(np.sqrt(np.mean((form(ao, fit) - measured) ** 2)) - residual) < 1e-12
    missed = (multibounce.tau(ao, fit) - tau - ripple) * (f1 + ripple)
    assert abs(np.sqrt(np.mean(missed**2) / np.mean((f1 + ripple) ** 2)) - fit.tau_rms) < 1e-12
    # The guard and the other bins leave a fit hardly any way to follow it.
    assert 0.008 < fit.f0_rms < 0.0101


def test_bins_without_light_have_no_say_in_tau():
    """Some points are sealed in: next to no light, of which the second bounce brings ten times the first."""
    lit, count = points_of(multibounce.PUBLISHED, 0.0), 50
    sealed = np.stack((np.zeros(count), np.full(count, 1e-6), np.full(count, 1e-5)))
    both = Simulation(np.append(lit.alpha, np.zeros(count)), np.concatenate((lit.bounces, sealed), axis=1))
    alone, fit = (fit_curves(bin_bounces(each)) for each in (lit, both))
    print(f"tau rms {alone.tau_rms:.6f}, with sealed points {fit.tau_rms:.6f}")
    assert abs(fit.tau_rms - alone.tau_rms) < 1e-3


def test_f0_does_not_jump_where_all_is_open():
    """Points with F0 = 1.2 alpha draw the exponent to 0, where F0 falls from 1.2 to 1 at once."""
    alpha = np.random.default_rng(0).uniform(0.2, 0.8, 50_000)
    fit = fit_curves(bin_bounces(Simulation(alpha, np.stack((1.2 * alpha, 0.1 * (1.0 - alpha))))))
    free = 1.2 * alpha - multibounce.f0(alpha, Coefficients(f0_factor=0.2, f0_exponent=1e-9))
    print(f"exponent {fit.f0_exponent:.3f}, factor {fit.f0_factor:.3f}, rms {fit.f0_rms:.4f} of {rms(free):.4f} at 0")
    assert fit.f0_exponent == pytest.approx(LEAST_F0_EXPONENT, abs=1e-3) and fit.f0_rms < 0.01


def test_bins_count_their_points_and_hold_their_mean():
    alpha = np.array([0.0, 0.04, 0.1, 0.99, 1.0, 1.0])
    bounces = np.arange(18.0).reshape(3, 6)
    curves = bin_bounces(Simulation(alpha, bounces), bins=10)
    np.testing.assert_allclose(curves.ao, np.arange(0.05, 1.0, 0.1))
    assert curves.count.tolist() == [2, 1, 0, 0, 0, 0, 0, 0, 0, 3]
    np.testing.assert_allclose(curves.mean[:, 0], bounces[:, :2].mean(axis=1))
    np.testing.assert_allclose(curves.mean[:, 9], bounces[:, 3:].mean(axis=1))
    assert np.isnan(curves.mean[:, 2:9]).all()


def test_bins_weigh_by_their_points():
    """A few points that lie far off hardly move a fit to many."""
    good, few = points_of(multibounce.PUBLISHED, 0.0), 20
    alpha = np.concatenate((good.alpha, np.linspace(0.001, 0.02, few)))
    curves = bin_bounces(Simulation(alpha, np.concatenate((good.bounces, np.full((3, few), 0.9)), axis=1)))
    fit = fit_curves(curves)
    assert abs(fit.b / B - 1.0) < 0.02


def test_a_fit_draws_the_curves_that_multibounce_evaluates():
    fit = fit_curves(bin_bounces(points_of(Coefficients(9.0, 2.4, 0.3, 0.5), 0.0)))
    alpha, albedo = np.linspace(0, 1, 301), np.linspace(0, 1, 21)[:, None]
    e = multibounce.irradiance(alpha, albedo, fit)
    assert np.isfinite(e).all() and (e <= 1.0 + 1e-12).all() and (np.diff(e, axis=0) >= -1e-12).all()
    assert (e >= multibounce.f0(alpha, fit) - 1e-12).all()
    assert (multibounce.tau(alpha, fit) >= 0.0).all() and (multibounce.tau(alpha, fit) <= 1.0).all()


@pytest.mark.parametrize("low", [0.9, 0.6])
def test_little_relief_still_fits_where_its_points_lie(low):
    """Half the published F1, on points that are all nearly open, where the published guard holds."""
    truth = Coefficients(0.4 * A, B)
    rng = np.random.default_rng(1)
    alpha = rng.uniform(low, 1.0, 50_000)
    f0, f1 = multibounce.f0(alpha, truth), multibounce.f1(alpha, truth)
    fit = fit_curves(bin_bounces(Simulation(alpha, np.stack((f0, f1)))))
    ao = np.linspace(low, 1.0, 50)
    worst = np.abs(multibounce.f1(ao, fit) - multibounce.f1(ao, truth)).max()
    print(f"alpha above {low}: F1 within {worst:.5f}, A {fit.a:.3g}, B {fit.b:.3g}")
    assert worst < 0.003 and np.isfinite((fit.a, fit.b)).all() and np.isnan(fit.tau_rms)


def test_csv_has_a_line_a_bin():
    simulation = points_of(multibounce.PUBLISHED, 0.0, count=500)
    curves = bin_bounces(simulation, bins=20)
    fit = fit_curves(curves)
    rows = list(csv.DictReader(io.StringIO(csv_text(curves, fit))))
    assert len(rows) == 20
    assert list(rows[0]) == [
        *("ao", "count", "F0", "F1", "F2", "sum"),
        *("fitted_F0", "fitted_F1", "fitted_tau", "fitted_sum"),
    ]
    for row, ao, count, mean in zip(rows, curves.ao, curves.count, curves.mean.T, strict=True):
        assert float(row["ao"]) == pytest.approx(ao) and int(row["count"]) == count
        assert abs(float(row["fitted_F1"]) - multibounce.f1(ao, fit)) < 1e-6
        if count:
            assert abs(float(row["F1"]) - mean[1]) < 1e-6 and abs(float(row["sum"]) - mean.sum()) < 1e-6
        else:
            assert row["F0"] == row["sum"] == ""
    assert any(count == 0 for count in curves.count)


def test_what_cannot_be_fitted():
    flat = Simulation(np.ones(9), np.stack((np.ones(9), np.zeros(9), np.zeros(9))))
    with pytest.raises(ValueError, match="more relief"):
        fit_curves(bin_bounces(flat))
    with pytest.raises(ValueError, match="no bounce"):
        fit_curves(bin_bounces(Simulation(np.ones(9), np.ones((1, 9)))))
    with pytest.raises(ValueError, match="one bin"):
        bin_bounces(flat, 0)
