# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums over links, and the decay that stands for late bounces."""

import numpy as np
import pytest

from core.bounces import Links, decay
from core.multibounce import MOST_TAIL, TAIL_ALBEDO, irradiance_from_bounces


def links(seed=0, n=40, rays=9):
    """Random links, of which a third end in the sky: targets, weights, and the light of the sky."""
    random = np.random.default_rng(seed)
    target = np.where(random.random((n, rays)) < 1 / 3, -1, random.integers(0, n, (n, rays)))
    weight = random.random((n, rays))
    weight /= weight.sum(axis=1, keepdims=True)
    return target, weight, np.where(target < 0, weight, 0.0).sum(axis=1)


def dense(target, weight):
    matrix = np.zeros((len(target), len(target)))
    for row, (ends, parts) in enumerate(zip(target, weight, strict=True)):
        for end, part in zip(ends, parts, strict=True):
            matrix[row, end] += part if end >= 0 else 0.0
    return matrix


def test_series_and_total_against_the_matrix():
    target, weight, sky = links()
    matrix, made = dense(target, weight), Links(target, weight)
    np.testing.assert_allclose(made.series(sky, 2)[2], matrix @ matrix @ sky, atol=1e-12)
    for albedo in (0.0, 0.5, 0.9, 1.0):
        expected = np.linalg.solve(np.eye(len(sky)) - albedo * matrix, sky)
        assert np.abs(made.total(sky, albedo) - expected).max() < 2.0**-13
    albedo = np.random.default_rng(1).random((len(sky), 3))
    total = made.total(np.repeat(sky[:, None], 3, axis=1), albedo)
    for channel in range(3):
        expected = np.linalg.solve(np.eye(len(sky)) - matrix * albedo[:, channel], sky)
        assert np.abs(total[:, channel] - expected).max() < 2.0**-13


def test_white_points_that_see_the_sky_somehow_send_all_light_back():
    target, weight, sky = links()
    np.testing.assert_allclose(Links(target, weight).total(sky, 1.0), 1.0, atol=2.0**-13)


def test_a_closed_white_room_ends():
    """No light gets in, and what is there never gets out: both are sums that end."""
    everywhere = np.tile(np.arange(5), (5, 1))
    closed = Links(everywhere, np.full((5, 5), 0.2))
    assert (closed.total(np.zeros(5), 1.0) == 0.0).all()
    assert np.isfinite(closed.total(np.ones(5), 1.0)).all()


@pytest.mark.parametrize("tail", [0.0, 0.3, 0.8])
def test_decay_of_a_geometric_series(tail):
    """F3 = T F2, F4 = T F3, ...: T comes back."""
    f0, f1, f2 = 0.2, 0.1, 0.1
    total = f0 + TAIL_ALBEDO * f1 + TAIL_ALBEDO**2 * f2 / (1.0 - TAIL_ALBEDO * tail)
    assert decay(*np.array([[f0], [f1], [f2], [total]]))[0] == pytest.approx(tail, abs=1e-12)


def test_the_channels_give_the_total_back_at_the_albedo_of_the_fit():
    random = np.random.default_rng(2)
    f0, f1, f2 = random.dirichlet((1, 1, 1, 2), 500).T[:3]
    left = 1.0 - f0 - f1 - f2
    # The later bounces come early or late, and not all of what is left comes.
    total = f0 + TAIL_ALBEDO * f1 + TAIL_ALBEDO**2 * f2 + random.random(500) * TAIL_ALBEDO**3 * left
    tail = decay(f0, f1, f2, total)
    found = irradiance_from_bounces(f0, f1, f2, tail, TAIL_ALBEDO)
    within = tail < MOST_TAIL
    assert within.mean() > 0.9
    np.testing.assert_allclose(found[within], total[within], atol=1e-9)


def test_decay_where_there_is_nothing():
    nothing = np.zeros(1)
    assert decay(nothing, nothing, nothing, nothing)[0] == 0.0
    assert decay(np.ones(1), nothing, nothing, np.ones(1))[0] == 0.0
