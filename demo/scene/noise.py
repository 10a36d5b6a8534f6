# SPDX-License-Identifier: GPL-3.0-or-later
"""Gradient noise over arrays of points (Perlin, "Improving noise", SIGGRAPH 2002), for weathering the ruin."""

import numpy as np

_PRIMES = np.array([0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D], dtype=np.uint32)


def _lattice_hash(cell: np.ndarray, seed: int) -> np.ndarray:
    mixed = (cell.astype(np.int64).astype(np.uint32) * _PRIMES).sum(axis=-1, dtype=np.uint32)
    mixed ^= np.uint32(seed * 2654435761 % 2**32)
    for shift, factor in ((15, 0x2C1B3C6D), (12, 0x297A2D39), (15, 1)):
        mixed ^= mixed >> np.uint32(shift)
        mixed *= np.uint32(factor)
    return mixed


def gradient_noise(points: np.ndarray, seed: int = 0) -> np.ndarray:
    """Smooth noise of points (..., 3): values (...) in about [-1, 1], features one unit wide."""
    base = np.floor(points)
    fraction = points - base
    fade = fraction**3 * (fraction * (fraction * 6 - 15) + 10)
    total = np.zeros(points.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        bits = _lattice_hash(base + corner, seed)
        gradient = np.stack([(bits >> np.uint32(s) & np.uint32(1023)) / 511.5 - 1 for s in (0, 10, 20)], axis=-1)
        weight = np.prod(np.where(corner, fade, 1 - fade), axis=-1)
        total += weight * np.einsum("...i,...i->...", gradient, fraction - corner)
    return total * 1.4


def fractal_noise(points: np.ndarray, octaves: int = 3, seed: int = 0) -> np.ndarray:
    """Sum of `octaves` of gradient noise, each twice as fine and half as strong as the one before."""
    return sum(gradient_noise(points * 2**o, seed + o) / 2**o for o in range(octaves))


def smoothstep(low: float, high: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
