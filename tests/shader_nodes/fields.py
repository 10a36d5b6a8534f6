# SPDX-License-Identifier: GPL-3.0-or-later
"""AO fields that no bake made: their numbers are random, so that none can be taken for another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np


def random_field(rng: np.random.Generator, n: int = 16):
    """A field about a hull of radius 1 whose neighbouring texels have nothing in common."""
    from core.cubemap import nodes

    directions, node = nodes(n)
    return _field(rng, directions, node, lambda low, high: rng.uniform(low, high, len(directions)))


def smooth_field(rng: np.random.Generator, n: int):
    """As :func:`random_field`, of functions that vary slowly with the direction."""
    from core.cubemap import nodes

    directions, node = nodes(n)

    def wave(low: float, high: float) -> np.ndarray:
        return (low + high) / 2 + (high - low) / 2 * np.sin(directions @ rng.normal(size=3) + rng.uniform(0, 6))

    return _field(rng, directions, node, wave)


def with_volume(rng: np.random.Generator, field):
    """The same with a volume in a box that does not hold the hull. It varies slowly, as those of objects do: of random
    neighbours the rounding of places would be magnified."""
    from core.ao_field import FieldVolume

    low, high = np.array((-0.7, -0.5, -0.6)), np.array((0.5, 0.8, 0.6))
    places = np.stack(np.meshgrid(*np.linspace(low, high, 16).T, indexing="ij"), axis=-1)
    waves = np.sin(places @ rng.normal(scale=3.0, size=(3, 4)) + rng.uniform(0, 6, 4))
    omega = 4.5 + 4 * waves[..., 3:]
    # |M| below that of one cap
    moment = (waves[..., :3] + (0, 0, 1.5)) / 4 * omega / np.pi * (1 - omega / (4 * np.pi))
    values = np.concatenate((moment, omega), axis=-1).astype(np.float16).astype(float)
    return replace(field, volume=FieldVolume(values, low, high, 1.7))


def _field(rng: np.random.Generator, directions: np.ndarray, node: np.ndarray, draw: Callable):
    from core.ao_field import AOField
    from core.cap import cap_of_moment

    r0 = draw(0.5, 0.9)
    # the denominators of a ball of varying size: 1 / Omega is nearly r^2 / (pi size^2)
    size = draw(0.4, 0.9) * r0
    a = 1 / (np.pi * size**2)
    b, c = draw(-0.3, 0.3) * a * r0, draw(0.1, 0.4)
    # what part of the moment of one cap the blocked directions have
    seen = draw(0.6, 0.95) / np.pi
    at = np.array((1.0, 2.0, 5.0))[:, None] * r0
    omega_m = cap_of_moment(np.minimum(seen / ((a * at + b) * at + c), 0.9))
    powers = np.stack([at**power for power in (2, 1, 0)], axis=-1)
    a_m, b_m, c_m = np.linalg.solve(powers.swapaxes(0, 1), (1 / omega_m).T[..., None])[..., 0].T
    c0 = 0.3 * directions + np.stack([draw(-0.2, 0.2) for _ in range(3)], axis=-1)
    d, e = draw(0.0, 0.5) * a, draw(1.0, 6.0)
    maps = [np.float32(each).astype(float)[node] for each in (a, b, c, d, r0, a_m, b_m, c_m, c0, e)]
    centre = np.float32(rng.uniform(-0.1, 0.1, 3)).astype(float)
    return AOField(centre, 1.0, 1.5, 4.0, *maps, a0=0.37, p=2.6)
