# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions to count."""

import numpy as np


def sphere_directions(count=400_000):
    """(count, 3) unit vectors that fill the sphere evenly, a spherical Fibonacci set."""
    z = 1 - 2 * (np.arange(count) + 0.5) / count
    azimuth = 2 * np.pi * np.mod(np.arange(count) * (5**0.5 - 1) / 2, 1)
    across = np.sqrt(1 - z * z)
    return np.column_stack((across * np.cos(azimuth), across * np.sin(azimuth), z))
