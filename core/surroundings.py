# SPDX-License-Identifier: GPL-3.0-or-later
"""Points on what stands around a surface, for the light that it sends there: dense near it, coarser with distance.

About the surface lies a ball. Within it the points around are as far apart as those on the surface itself; beyond it
their distance from one another grows as that from the ball's centre does, as the angle that they are seen under stays
the same. A landscape or an endless floor so takes few of them, and none of what the surface itself gets.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rays import Occluders
from .sample_points import SurfacePoints, spread
from .surface import INSET, unit

# Radius of the ball, in those of the surface's bounding sphere.
NEAR = 2.0
# How far a floor has points, in the ball's radii: it ends less than a part of that many below the horizon.
FLOOR_REACH = 1000.0
# Triangles are cut until none is longer than this part of its distance from the centre, or of the ball's radius, or
# there are so many.
LONGEST, MOST_PIECES = 0.5, 2**20


@dataclass(frozen=True)
class Ball:
    """About ``centre`` (3,) float64, world units."""

    centre: NDArray[np.float64]
    radius: float

    @classmethod
    def about(cls, positions: NDArray[np.float64]) -> Ball:
        """That of a surface with points at ``positions`` (n, 3)."""
        low, high = positions.min(axis=0), positions.max(axis=0)
        return cls(0.5 * (low + high), NEAR * max(0.5 * float(np.linalg.norm(high - low)), np.finfo(np.float32).tiny))

    def coarseness(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """How much further apart points at ``positions`` (..., 3) are than within the ball, (...), 1 or more."""
        return np.maximum(np.linalg.norm(positions - self.centre, axis=-1) / self.radius, 1.0)

    def drawn_in(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """``positions`` (n, 3) with what is outside the ball moved towards it, by the logarithm of its distance: there
        the points around lie about equally far apart everywhere."""
        coarseness = self.coarseness(positions)[:, None]
        return self.centre + (positions - self.centre) * ((1.0 + np.log(coarseness)) / coarseness)


def surrounding_points(
    occluders: Occluders, own: int, ball: Ball, spacing: float, most: int
) -> tuple[SurfacePoints, float]:
    """Points on the triangles of ``occluders`` but for the first ``own``, and on the floor if there is one.

    Returns up to ``most`` of them, flat as the triangles are, and how far apart they are within the ``ball``:
    ``spacing``, or more where they would be too many. Memory: about 300 bytes a triangle while they are spread.
    """
    around = occluders.vertices[occluders.triangles[own:]] / occluders.scale + occluders.centre
    if occluders.ground_height is not None:
        around = np.concatenate((around, _floor(occluders.ground_height, ball)))
    pieces = _cut(around, ball)
    a, b, c = np.moveaxis(pieces, 1, 0)
    normals = np.cross(b - a, c - a)
    weight = 0.5 * np.linalg.norm(normals, axis=1) / np.square(ball.coarseness(pieces.mean(axis=1)))
    total = float(weight.sum())
    count = int(min(most, np.ceil(total / spacing**2)))
    if not count:
        return SurfacePoints(np.empty((0, 3)), np.empty((0, 3))), spacing
    piece, v, w = spread(weight, count)
    v, w = ((1.0 - INSET) * each[:, None] + INSET / 3.0 for each in (v, w))
    positions = (1.0 - v - w) * a[piece] + v * b[piece] + w * c[piece]
    return SurfacePoints(positions, unit(normals[piece])), float(np.sqrt(total / count))


def _floor(height: float, ball: Ball) -> NDArray[np.float64]:
    """Two triangles (2, 3 corners, 3) that face up."""
    corners = np.append(ball.centre[:2], height) + FLOOR_REACH * ball.radius * np.array(
        [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    )
    return corners[[(0, 1, 2), (0, 2, 3)]]


def _cut(triangles: NDArray[np.float64], ball: Ball) -> NDArray[np.float64]:
    """``triangles`` (k, 3 corners, 3) in halves, and these again, until each is short for where it is."""
    short = [np.empty((0, 3, 3))]
    count = len(triangles)
    while len(triangles) and count < MOST_PIECES:
        edge = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
        is_long = edge.max(axis=1) > LONGEST * ball.radius * ball.coarseness(triangles.mean(axis=1))
        short.append(triangles[~is_long])
        # The longest edge first, and its middle.
        first = edge[is_long].argmax(axis=1)[:, None]
        a, b, c = np.moveaxis(triangles[is_long][np.arange(len(first))[:, None], (first + np.arange(3)) % 3], 1, 0)
        middle = 0.5 * (a + b)
        triangles = np.concatenate((np.stack((a, middle, c), axis=1), np.stack((middle, b, c), axis=1)))
        count += len(first)
    return np.concatenate((*short, triangles))
