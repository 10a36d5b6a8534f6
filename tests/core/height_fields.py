# SPDX-License-Identifier: GPL-3.0-or-later
"""Height maps to simulate."""

import numpy as np

from core.height_map import HeightMap
from core.simulation import simulate_height_map

from .tracing import finish


def height_field(heights, amplitude, samples=128, **options):
    return finish(simulate_height_map(HeightMap(heights, amplitude), samples=samples, **options))


def waves(side=64):
    x, y = np.meshgrid(*2 * [2 * np.pi * np.arange(side) / side])
    return np.sin(3 * x + np.cos(2 * y)) * np.cos(2 * y) + 0.4 * np.sin(7 * x + 5 * y)
