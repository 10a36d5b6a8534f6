# SPDX-License-Identifier: GPL-3.0-or-later
"""Stones or bricks in mortar: one rounded, chipped, slightly crooked relief a rectangular cell."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .noise import fractal_noise, gradient_noise
from .patches import grid_quads


@dataclass
class Style:
    """Sizes in metres: half a joint's width, the rounding of edges, the joint's depth, roughness, crookedness.

    `missing` is the part of the stones that have fallen out and left a hole.
    """

    joint: float
    bevel: float
    depth: float
    relief: float
    crooked: float
    inner_knots: tuple[int, int] = (4, 2)
    missing: float = 0.0


@dataclass
class Masonry:
    """Relief over N cells of K vertices: u, v, height (N, K) in metres, stone (N, K) from 0 mortar to 1 stone."""

    u: np.ndarray
    v: np.ndarray
    height: np.ndarray
    stone: np.ndarray
    shape: tuple[int, int]

    def quads(self) -> np.ndarray:
        count, vertices = self.u.shape
        one = grid_quads(*self.shape)
        return (one[None] + np.arange(count)[:, None, None] * vertices).reshape(-1, 4)


def _knots(half: np.ndarray, style: Style, inner: int) -> np.ndarray:
    """Positions (N, knots) along one axis of cells: dense over joint and rounding, sparse over the face."""
    edge = half - style.joint
    side = np.stack([half, edge, edge - 0.1 * style.bevel, edge - 0.4 * style.bevel, edge - style.bevel], axis=1)
    face = side[:, -1:] * np.linspace(-1, 1, inner + 2)[1:-1]
    return np.concatenate([-side, face, side[:, ::-1]], axis=1)


def lay(cells: np.ndarray, style: Style, seed: int) -> Masonry:
    """Relief of cells (N, 4) = (u0, v0, u1, v1). Cell borders lie at height -depth exactly, so that cells meet."""
    rng = np.random.default_rng(seed)
    centre = (cells[:, :2] + cells[:, 2:]) / 2
    half = (cells[:, 2:] - cells[:, :2]) / 2
    x = _knots(half[:, 0], style, style.inner_knots[0])[:, None, :]
    y = _knots(half[:, 1], style, style.inner_knots[1])[:, :, None]
    x, y = np.broadcast_arrays(x, y)
    u, v = centre[:, 0, None, None] + x, centre[:, 1, None, None] + y
    stone_id = np.arange(len(cells))[:, None, None] * 7.31
    at = np.stack([u, v, np.broadcast_to(stone_id, u.shape)], axis=-1)

    radius = 1.2 * style.bevel
    corner = np.stack([abs(x), abs(y)], axis=-1) - (half - style.joint - radius)[:, None, None, :]
    outside = np.linalg.norm(np.maximum(corner, 0), axis=-1) + np.minimum(corner.max(axis=-1), 0) - radius
    chips = np.maximum(fractal_noise(at * 8, 3, seed), 0) * 1.4 * style.bevel
    t = np.clip((-outside - chips) / style.bevel, 0, 1)
    stone = np.sqrt(1 - (1 - t) ** 2)

    push, tilt_u, tilt_v = rng.uniform(-1, 1, (3, len(cells), 1, 1)) * style.crooked
    push = np.where(rng.random(push.shape) < style.missing, -3.2 * style.depth, push)
    face = push + tilt_u * x / half[:, 0, None, None] + tilt_v * y / half[:, 1, None, None]
    face = face + style.relief * (fractal_noise(at * 7, 3, seed + 5) + 0.5 * gradient_noise(at * 30, seed + 9))
    from_border = np.minimum(half[:, 0, None, None] - abs(x), half[:, 1, None, None] - abs(y)) / style.joint
    mortar = 0.35 * style.depth * np.clip(from_border, 0, 1) * fractal_noise(at * 12, 2, seed + 3)
    height = -style.depth * (1 - stone) + stone * face + (1 - stone) * mortar
    flat = (len(cells), -1)
    return Masonry(u.reshape(flat), v.reshape(flat), height.reshape(flat), stone.reshape(flat), x.shape[1:])


def running_bond(
    rows: np.ndarray, u_range: tuple[float, float], length: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Cells (N, 4) of uneven lengths in courses between the heights `rows`, and each cell's course (N,)."""
    rng = np.random.default_rng(seed)
    cells, courses = [], []
    for course, (v0, v1) in enumerate(pairwise(rows)):
        edges = u_range[0] + np.cumsum(rng.uniform(0.8, 1.2, int((u_range[1] - u_range[0]) / length) + 2) * length)
        edges -= (course % 2 * 0.5 + 0.5) * length
        cells += [(u0, v0, u1, v1) for u0, u1 in pairwise(edges)]
        courses += [course] * (len(edges) - 1)
    return np.array(cells), np.array(courses)
