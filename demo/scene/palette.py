# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear albedos of the ruin's stuffs, and how they vary and weather."""

import numpy as np

from .noise import fractal_noise, smoothstep

TERRACOTTA = np.array([0.78, 0.29, 0.14])
BRICKS = np.array([[0.78, 0.29, 0.14], [0.80, 0.38, 0.17], [0.70, 0.24, 0.14], [0.84, 0.52, 0.22], [0.76, 0.33, 0.20]])
MORTAR = np.array([0.80, 0.68, 0.50])
OCHRE = np.array([0.85, 0.50, 0.16])
SANDSTONE = np.array([0.84, 0.73, 0.53])
PAVING = np.array([0.64, 0.55, 0.42])
SOIL = np.array([0.44, 0.32, 0.18])
ROCK = np.array([0.60, 0.46, 0.32])
MOSS = np.array([0.32, 0.47, 0.11])
GLAZE = np.array([0.12, 0.60, 0.58])


def mix(a: np.ndarray, b: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """a (…, 3) towards b (…, 3) by weight (…)."""
    return a + (b - a) * np.asarray(weight)[..., None]


def mottled(colour: np.ndarray, points: np.ndarray, seed: int, scale: float = 3, amount: float = 0.09) -> np.ndarray:
    """Colours (..., 3) made lighter and darker by noise over points (..., 3)."""
    return colour * (1 + amount * fractal_noise(points * scale, 3, seed))[..., None]


def mossy(colour: np.ndarray, points: np.ndarray, where: np.ndarray, seed: int) -> np.ndarray:
    """Colours with moss grown where `where` (...) in [0, 1] is high, in noisy patches."""
    cover = smoothstep(0.45, 0.62, where + 0.35 * fractal_noise(points * 2.5, 4, seed))
    return mix(colour, MOSS * (1 + 0.25 * fractal_noise(points * 20, 2, seed + 7))[..., None], cover)
