# SPDX-License-Identifier: GPL-3.0-or-later
"""The eight numbers that a bake leaves at a point: the colours ``Multibounce AO`` and ``Bent Cone``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from . import multibounce
from .bounces import decay
from .surface import lengths
from .visibility import Visibility


def fitted_bounces(visibility: Visibility) -> NDArray[np.float32]:
    """``Multibounce AO`` (n, 4): F0 as measured, F1 = f1(alpha), F2 = T F1 and T = tau(alpha) from the published fit.

    The fit knows alpha only, so F1 and then F2 are lowered where they would pass the light that F0 leaves.
    """
    f0 = visibility.f0.astype(np.float64)
    fitted = multibounce.f1(visibility.alpha)
    tail = multibounce.decay(multibounce.f0(visibility.alpha), fitted)
    f1 = np.minimum(fitted, 1.0 - f0)
    f2 = np.minimum(tail * f1, 1.0 - f0 - f1)
    return np.column_stack((f0, f1, f2, tail)).astype(np.float32)


def measured_bounces(visibility: Visibility) -> NDArray[np.float32]:
    """``Multibounce AO`` (n, 4): F0, and from what was gathered F1, F2 and the decay T that fits the light of all
    bounces (:func:`core.bounces.decay`)."""
    f0 = visibility.f0.astype(np.float64)
    f1, f2, total = visibility.gathered.T
    return np.column_stack((f0, f1, f2, decay(f0, f1, f2, f0 + multibounce.TAIL_ALBEDO * total))).astype(np.float32)


def radiosity(visibility: Visibility) -> NDArray[np.float32]:
    """``Multibounce Radiosity`` (n, 4): E/E0 in red, green and blue, at least F0, and F0."""
    f0 = visibility.f0.astype(np.float64)
    return np.column_stack((f0[:, None] + visibility.gathered, f0)).astype(np.float32)


def bent_cone(visibility: Visibility, world_to_object: NDArray) -> NDArray[np.float32]:
    """``Bent Cone`` (n, 4): the mean visible direction in object space, its length kept, and alpha.

    world_to_object  (3, 3) float, the inverse of the object's linear transform
    """
    return np.column_stack((to_object(visibility.bent, world_to_object), visibility.alpha)).astype(np.float32)


def to_object(world: NDArray, world_to_object: NDArray) -> NDArray[np.float64]:
    """Directions ``world`` (n, 3) in object space, their lengths kept."""
    world = world.astype(np.float64)
    local = world @ np.asarray(world_to_object, np.float64).T
    length = lengths(local)
    local *= np.divide(lengths(world), length, out=np.zeros_like(length), where=length > 0.0)[:, None]
    return local
