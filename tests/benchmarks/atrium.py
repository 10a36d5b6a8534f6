# SPDX-License-Identifier: GPL-3.0-or-later
"""An architectural mesh: a court between two storeys of arcades, of 70k triangles.

Its pieces meet at open edges and nothing is welded, and floors and walls are separate faces, as such models come: that
is where rays leak between faces that only touch.
"""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
from meshes import empty_scene, object_of
from numpy.typing import NDArray

COURT = np.array((5.0, 9.0))  # half its width and length, metres, to the middle of the columns
WALL = COURT + 3.0
STOREY = 4.5
SPRING = 2.4  # where arches begin above the storey's floor
THICKNESS = 0.5
BAY = 2.0
SHAFT = 0.22
UPRIGHT = np.eye(3)

Shape = Callable[[NDArray, NDArray], tuple[NDArray, NDArray, NDArray]]


class Builder:
    """Gathers patches: maps of the unit square to points (along, out, up) of a frame."""

    def __init__(self) -> None:
        self.vertices: list[NDArray] = []
        self.quads: list[NDArray] = []
        self.count = 0

    def patch(self, shape: Shape, m: int, n: int, split: bool = False, frame=UPRIGHT, origin=(0.0, 0.0, 0.0)):
        """m x n faces of ``shape``; ``split`` gives every face vertices of its own."""
        u, v = np.meshgrid(np.linspace(0.0, 1.0, m + 1), np.linspace(0.0, 1.0, n + 1), indexing="ij")
        local = np.stack(np.broadcast_arrays(*shape(u.ravel(), v.ravel())), axis=1)
        points = local @ frame + origin
        i, j = (each.ravel() for each in np.indices((m, n)))
        corner = i * (n + 1) + j
        quads = np.stack((corner, corner + n + 1, corner + n + 2, corner + 1), axis=1)
        if split:
            points, quads = points[quads].reshape(-1, 3), np.arange(quads.size).reshape(-1, 4)
        self.vertices.append(points)
        self.quads.append(quads + self.count)
        self.count += len(points)

    def block(self, low, high, cap: int = 0, **place) -> None:
        """The sides of a box, each by itself; ``cap`` 1 has the top too, -1 the bottom. The others touch something."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        dx, dy, dz = x1 - x0, y1 - y0, z1 - z0
        sides = [
            lambda u, v: (x0 + u * dx, y0 + 0 * u, z0 + v * dz),
            lambda u, v: (x0 + v * dx, y1 + 0 * u, z0 + u * dz),
            lambda u, v: (x0 + 0 * u, y0 + v * dy, z0 + u * dz),
            lambda u, v: (x1 + 0 * u, y0 + u * dy, z0 + v * dz),
        ]
        if cap > 0:
            sides.append(lambda u, v: (x0 + u * dx, y0 + v * dy, z1 + 0 * u))
        if cap < 0:
            sides.append(lambda u, v: (x0 + v * dx, y0 + u * dy, z0 + 0 * u))
        for side in sides:
            self.patch(side, 2, 2, split=True, **place)


def _circle(radius: NDArray, u: NDArray) -> tuple[NDArray, NDArray]:
    return radius * np.cos(2 * np.pi * u), radius * np.sin(2 * np.pi * u)


def _column(build: Builder, **place) -> None:
    def height(v):
        return 0.2 + v * (SPRING - 0.4)

    build.block((-0.32, -0.32, 0.0), (0.32, 0.32, 0.2), cap=1, **place)
    build.block((-0.32, -0.32, SPRING - 0.2), (0.32, 0.32, SPRING), cap=-1, **place)

    # Rings at foot and head, a slight belly between.
    def radius(v):
        return SHAFT * (1.0 + 0.06 * np.sin(np.pi * v)) + 0.08 * np.exp(-(((np.abs(v - 0.5) - 0.46) / 0.03) ** 2))

    build.patch(lambda u, v: (*_circle(radius(v), u), height(v)), 18, 16, **place)


def _arch(build: Builder, bay: float, **place) -> None:
    radius = bay / 2 - SHAFT
    half = THICKNESS / 2

    def soffit(u, v):
        return -radius * np.cos(np.pi * u), half * (1 - 2 * v), SPRING + radius * np.sin(np.pi * u)

    def spandrel(side):
        def shape(u, v):
            along, _, up = soffit(u if side < 0 else 1 - u, v)
            return along, side * half + 0 * u, up + v * (STOREY - up)

        return shape

    build.patch(soffit, 14, 3, **place)
    for side in (-1, 1):
        build.patch(spandrel(side), 14, 3, **place)
    for end in (-1, 1):
        low, high = sorted((end * radius, end * bay / 2))
        build.block((low, -half, SPRING), (high, half, STOREY), **place)


def atrium() -> bpy.types.Object:
    empty_scene()
    build = Builder()
    (a, b), (wall_x, wall_y) = COURT, WALL
    build.patch(lambda u, v: (wall_x * (2 * u - 1), wall_y * (2 * v - 1), 0 * u), 32, 48, split=True)
    for side in range(4):
        along, out = ((1, 0, 0), (0, 1, 0)) if side % 2 == 0 else ((0, -1, 0), (1, 0, 0))
        sign = 1 if side < 2 else -1
        frame = np.array((sign * np.array(along), sign * np.array(out), (0, 0, 1)), float)
        (half, depth), (reach, wall) = ((a, b), (wall_x, wall_y)) if side % 2 == 0 else ((b, a), (wall_y, wall_x))
        build.patch(
            lambda u, v, reach=reach, wall=wall: (reach * (2 * u - 1), wall + 0 * u, 2 * STOREY * v),
            40, 20, split=True, frame=frame,
        )  # fmt: skip
        bays = round(2 * half / BAY)
        bay = 2 * half / bays
        for storey in range(2):
            up = storey * STOREY
            for k in range(bays):
                origin = np.array((-half + k * bay, depth, up)) @ frame
                _column(build, frame=frame, origin=origin)
                _arch(build, bay, frame=frame, origin=origin + np.array((bay / 2, 0, 0)) @ frame)
            # The gallery's floor, from the arcade's inner side to the wall.
            inner, front = half - THICKNESS / 2, depth - THICKNESS / 2
            build.patch(
                lambda u, v, inner=inner, front=front, reach=reach, wall=wall, up=up: (
                    (2 * u - 1) * (inner + v * (reach - inner)), front + v * (wall - front), up + STOREY + 0 * u,
                ),
                40, 10, split=True, frame=frame,
            )  # fmt: skip
    return object_of("Atrium", np.concatenate(build.vertices), np.concatenate(build.quads))
