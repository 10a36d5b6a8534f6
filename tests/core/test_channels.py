# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake leaves at a point keeps the contract of its channels."""

import numpy as np

from core import multibounce
from core.channels import bent_cone, fitted_bounces
from core.visibility import Visibility


def seen(f0, alpha):
    f0, alpha = np.broadcast_arrays(np.asarray(f0, np.float32), np.asarray(alpha, np.float32))
    bent = np.random.default_rng(0).normal(size=(f0.size, 3)).astype(np.float32)
    return Visibility(f0.ravel(), alpha.ravel(), bent * 0.3)


def test_fitted_bounces_follow_the_fit_where_energy_allows():
    alpha = np.linspace(0, 1, 101)
    _, f1, f2, tail = fitted_bounces(seen(multibounce.f0(alpha), alpha)).T.astype(np.float64)
    np.testing.assert_allclose(f1, multibounce.f1(alpha), atol=1e-6)
    np.testing.assert_allclose(f2, multibounce.tau(alpha) * multibounce.f1(alpha), atol=1e-6)
    np.testing.assert_allclose(tail, multibounce.tau(alpha), atol=1e-4)


def test_fitted_bounces_never_pass_the_light_there_is():
    f0, alpha = np.meshgrid(np.linspace(0, 1, 51), np.linspace(0, 1, 51))
    channels = fitted_bounces(seen(f0, alpha))
    assert channels.dtype == np.float32 and (channels >= 0).all() and (channels[:, 3] <= 1).all()
    assert (channels[:, :3].sum(axis=1) <= 1 + 1e-6).all()
    np.testing.assert_array_equal(channels[:, 0], f0.astype(np.float32).ravel())


def test_bent_cone_turns_into_object_space_and_keeps_its_length():
    visibility = seen(np.full(50, 0.5), np.linspace(0, 1, 50))
    angle = 0.7
    to_object = np.array([[np.cos(angle), np.sin(angle), 0], [-np.sin(angle), np.cos(angle), 0], [0, 0, 1]]) / 5.0
    cone = bent_cone(visibility, to_object)
    np.testing.assert_allclose(cone[:, :3], visibility.bent @ (5.0 * to_object).T, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(cone[:, :3], axis=1), np.linalg.norm(visibility.bent, axis=1), rtol=1e-5)
    np.testing.assert_array_equal(cone[:, 3], visibility.alpha)
    nothing = Visibility(np.zeros(1, np.float32), np.zeros(1, np.float32), np.zeros((1, 3), np.float32))
    assert (bent_cone(nothing, to_object) == 0).all()
