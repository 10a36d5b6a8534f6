# SPDX-License-Identifier: GPL-3.0-or-later
"""What a point sees of polygons, in closed form."""

from __future__ import annotations

from itertools import pairwise

import numpy as np


def form_factor(point, normal, polygon) -> float:
    """(1/pi) * integral of cos(theta) over ``polygon`` (k, 3), all of it above the horizon of ``point``.

    Lambert 1760, "Photometria": (1/2pi) * sum over the edges of their angle times the cosine to their plane's normal.
    """
    rays = _rays(point, polygon)
    total = 0.0
    for a, b in zip(rays, np.roll(rays, -1, axis=0), strict=True):
        across = np.cross(a, b)
        sine = np.linalg.norm(across)
        total += np.arctan2(sine, a @ b) * (across @ normal) / sine
    return abs(total) / (2 * np.pi)


def solid_angle(point, polygon) -> float:
    """Of a convex ``polygon`` (k, 3). Van Oosterom and Strackee 1983, "The Solid Angle of a Plane Triangle"."""
    a, *others = _rays(point, polygon)
    total = 0.0
    for b, c in pairwise(others):
        total += 2 * np.arctan2(a @ np.cross(b, c), 1 + a @ b + b @ c + c @ a)
    return abs(total)


def faces_towards(point, vertices, faces) -> list[np.ndarray]:
    """The polygons of a convex solid that ``point`` sees; they do not overlap from there."""
    polygons = [np.asarray(vertices)[list(face)] for face in faces]
    return [p for p in polygons if np.cross(p[1] - p[0], p[2] - p[1]) @ (point - p[0]) > 1e-12]


def _rays(point, polygon) -> np.ndarray:
    rays = np.asarray(polygon, float) - point
    return rays / np.linalg.norm(rays, axis=1, keepdims=True)
