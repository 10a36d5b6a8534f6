# SPDX-License-Identifier: GPL-3.0-or-later
"""The rock that the ruin stands on, and the mossy flagstones left on it."""

import numpy as np

from . import masonry, palette
from .noise import fractal_noise, smoothstep
from .patches import Patch, add_object, closed_ring_quads, merged

STYLE = masonry.Style(joint=0.022, bevel=0.035, depth=0.055, relief=0.008, crooked=0.012, inner_knots=(6, 4))
CENTRE = np.array([0.1, -0.35])
HALF = np.array([3.75, 2.05])


def _reach(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """0 at the middle of the rock's top, 1 at its uneven edge, a superellipse."""
    at = np.stack([x, y], axis=-1) - CENTRE
    turn = np.arctan2(at[..., 1] / HALF[1], at[..., 0] / HALF[0])
    uneven = fractal_noise(np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1) * 2.2, 4, 2)
    return (abs(at / HALF) ** 4).sum(axis=-1) ** 0.25 / (1 + 0.06 * uneven)


def _flank(vertices: np.ndarray, colours: np.ndarray) -> Patch:
    """The sides of one stone (rows, columns, 3), from its border down into the rock."""

    def border(grid):
        return np.concatenate([grid[0, :-1], grid[:-1, -1], grid[-1, :0:-1], grid[:0:-1, 0]])

    top = border(vertices)
    patch_vertices = np.concatenate([top - np.array([0, 0, 0.1]), top])
    return Patch(patch_vertices, np.tile(border(colours), (2, 1)), [closed_ring_quads(2, len(top))])


def add_paving(material):
    """Flagstones; those at the rock's edge have mostly gone over it."""
    rng = np.random.default_rng(2)
    rows = -2.6 + np.cumsum(np.concatenate([[0], rng.uniform(0.42, 0.62, 4)]))
    rows = np.concatenate([rows, [-0.3, 0.04]])
    cells, _ = masonry.running_bond(rows, (-3.9, 4.1), 0.72, seed=9)
    corners = cells[:, [[0, 1], [2, 1], [2, 3], [0, 3]]]
    overhang = _reach(corners[..., 0], corners[..., 1]).max(axis=1)
    cells = cells[overhang + rng.uniform(-0.04, 0.08, len(cells)) < 0.93]
    relief = masonry.lay(cells, STYLE, seed=6)
    vertices = np.stack([relief.u, relief.v, relief.height], axis=-1)
    tones = palette.PAVING * rng.uniform(0.8, 1.2, (len(cells), 1, 1)) * rng.uniform(0.95, 1.05, (len(cells), 1, 3))
    stones = palette.mottled(tones, vertices, 41, scale=4)
    joints = np.broadcast_to(palette.SOIL, stones.shape)
    colours = palette.mix(joints, stones, np.clip(relief.stone * 3 - 0.6, 0, 1))
    damp = 0.5 * (relief.stone < 0.55) + 0.25 * smoothstep(-1.2, 0, relief.v)
    colours = palette.mossy(colours, vertices, damp, 43)
    stones = Patch(vertices.reshape(-1, 3), colours.reshape(-1, 3), [relief.quads()])
    shape = (len(cells), *relief.shape, 3)
    flanks = [_flank(v, c) for v, c in zip(vertices.reshape(shape), colours.reshape(shape), strict=True)]
    return add_object("Paving", merged([stones, *flanks]), material)


def add_rock(material):
    """A rock with a flat top just below the flagstones' joints, and flanks that fall away below."""
    columns = 320
    turn = np.linspace(0, 2 * np.pi, columns, endpoint=False)[None]
    # Over the top from the middle to the edge, then down the flanks, which narrow.
    across = np.concatenate([np.linspace(0.02, 1, 40), np.linspace(1, 0.45, 46)[1:]])[:, None]
    down = np.concatenate([np.zeros(40), np.linspace(0, 1, 46)[1:] ** 1.25])[:, None] * 1.7
    rim = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    rim = rim / (rim**4).sum(axis=-1, keepdims=True) ** 0.25 * HALF
    uneven = fractal_noise(np.stack([rim[..., 0] / HALF[0], rim[..., 1] / HALF[1], 0 * turn], -1) * 2.2, 4, 2)
    plan = CENTRE + rim * (1 + 0.06 * uneven[..., None]) * across[..., None]
    position = np.concatenate([plan, np.broadcast_to(-0.045 - down, (len(across), columns))[..., None]], axis=-1)

    flank = smoothstep(0.0, 0.12, down)
    ledges = 0.10 * fractal_noise(position * np.array([0.9, 0.9, 3.2]), 4, 13)
    outward = np.concatenate([rim / np.linalg.norm(rim, axis=-1, keepdims=True), np.zeros((1, columns, 1))], axis=-1)
    position = position + outward * ((ledges * 1.6) * flank)[..., None]
    edge = smoothstep(0.93, 1.0, across) * (1 - flank)
    position[..., 2] += 0.01 * fractal_noise(position * 3, 3, 3) * (1 - flank) - 0.035 - 0.05 * edge
    soil = palette.mottled(np.broadcast_to(palette.SOIL, position.shape), position, 51, scale=3)
    layers = position * np.array([1, 1, 4])
    stone = palette.mottled(np.broadcast_to(palette.ROCK, position.shape), layers, 52, scale=2, amount=0.3)
    colours = palette.mix(soil, stone, np.broadcast_to(flank, position.shape[:2]))
    colours = palette.mossy(colours, position, np.broadcast_to(0.62 - 0.5 * flank, position.shape[:2]), 53)
    quads = closed_ring_quads(*position.shape[:2])[:, ::-1]
    return add_object("Rock", Patch(position.reshape(-1, 3), colours.reshape(-1, 3), [quads]), material)
