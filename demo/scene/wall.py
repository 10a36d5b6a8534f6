# SPDX-License-Identifier: GPL-3.0-or-later
"""The broken brick wall around the niche, with one course of glazed bricks."""

import numpy as np

from . import masonry, palette, plan
from .noise import gradient_noise
from .patches import Patch, add_object, grid_quads, merged, without_unused_vertices

X_RANGE = (-3.3, 3.6)
# Where the wall is broken off: x, and the height there.
BROKEN_AT = np.array([-3.3, -3.0, -2.7, -2.3, -1.5, 0.4, 1.7, 2.3, 2.8, 3.4])
BROKEN_TO = np.array([0.7, 1.7, 2.9, 3.8, 4.1, 4.2, 3.75, 2.6, 1.5, 0.5])
THICKNESS = 0.55
GLAZED_COURSES = (4, 19)
# The first course beside the niche.
SILL_COURSE = 5
STYLE = masonry.Style(
    joint=0.010, bevel=0.020, depth=0.032, relief=0.008, crooked=0.009, inner_knots=(6, 2), missing=0.03
)


def ruined_top(x: np.ndarray) -> np.ndarray:
    """Height at which the wall is broken off: high on the left, falling to the right."""
    at = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=-1)
    return np.interp(x, BROKEN_AT, BROKEN_TO) + 0.3 * gradient_noise(at * 1.1, 4)


def _opening_half_width(z: np.ndarray) -> np.ndarray:
    """Half the opening cut into the bricks at height z; its edge runs under the middle of the stone ring."""
    radius = plan.NICHE_RADIUS + 0.5 * plan.RING_WIDTH
    arch = np.sqrt(np.maximum(radius**2 - np.maximum(z - plan.SPRING, 0) ** 2, 0))
    return arch


def _covered(cells: np.ndarray, courses: np.ndarray, step: int) -> np.ndarray:
    """Part (N,) of each cell's length that touches a cell `step` courses above."""
    part = np.empty(len(cells))
    for i, (u0, _, u1, _) in enumerate(cells):
        other = cells[courses == courses[i] + step]
        part[i] = np.clip(np.minimum(other[:, 2], u1) - np.maximum(other[:, 0], u0), 0, None).sum() / (u1 - u0)
    return part


def _backward_strip(edge: np.ndarray, flip: bool, seed: int) -> Patch:
    """The broken flank from an edge (k, 3) of the wall's face back through its thickness."""
    depths = np.linspace(0, THICKNESS, 8)
    vertices = edge[None] + np.array([0, 1, 0]) * depths[:, None, None]
    rough = gradient_noise(vertices * 9, seed) * 0.025 * np.minimum(depths / 0.1, 1)[:, None]
    vertices = vertices + rough[..., None] * np.array([1, 0, 1])
    vertices = vertices.reshape(-1, 3)
    quads = grid_quads(len(depths), len(edge))
    base = palette.mix(palette.MORTAR, palette.TERRACOTTA, np.clip(0.5 + gradient_noise(vertices * 5, seed), 0, 1))
    colours = palette.mossy(base, vertices, np.full(len(vertices), 0.35), seed)
    return Patch(vertices, colours, [quads[:, ::-1] if flip else quads])


def _standing_bricks() -> tuple[np.ndarray, np.ndarray]:
    """Cells (N, 4) of the bricks still in place, and their courses (N,)."""
    rows = np.arange(0, 30) * plan.COURSE
    cells, courses = masonry.running_bond(rows, X_RANGE, 0.42, seed=11)
    centre = (cells[:, :2] + cells[:, 2:]) / 2
    ragged = np.random.default_rng(8).uniform(-0.12, 0.12, len(cells))
    kept = centre[:, 1] < ruined_top(centre[:, 0]) + ragged
    cells, courses = cells[kept], courses[kept]
    for course in range(1, courses.max() + 1):
        unsupported = (courses == course) & (_covered(cells, courses, -1) < 0.6)
        cells, courses = cells[~unsupported], courses[~unsupported]
    return cells, courses


def _colours(relief: masonry.Masonry, courses: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    rng = np.random.default_rng(5)
    tones = palette.BRICKS[rng.integers(0, len(palette.BRICKS), len(courses))]
    tones = tones * rng.uniform(0.8, 1.15, (len(courses), 1))
    glazed = np.isin(courses, GLAZED_COURSES)
    tones[glazed] = palette.GLAZE * rng.uniform(0.75, 1.2, (glazed.sum(), 1))
    bricks = palette.mottled(tones[:, None], vertices, 21, scale=9)
    mortar = np.broadcast_to(palette.MORTAR, bricks.shape)
    colours = palette.mix(mortar, bricks, np.clip(relief.stone * 2.5 - 0.8, 0, 1))
    low = np.clip(1 - relief.v / 0.9, 0, 1) * 0.45 + (relief.stone < 0.3) * 0.12
    near_top = np.clip(1 - (ruined_top(relief.u) - relief.v) / 0.5, 0, 1) * 0.35
    return palette.mossy(colours, vertices, low + near_top, 31)


def _flanks(cells: np.ndarray, courses: np.ndarray, vertices: np.ndarray) -> list[Patch]:
    """The wall's thickness wherever a brick (rows, columns, 3) of `vertices` (N, ...) has lost a neighbour."""
    above, below = _covered(cells, courses, 1), _covered(cells, courses, -1)
    flanks = []
    for i, (cell, course) in enumerate(zip(cells, courses, strict=True)):
        row = cells[courses == course]
        if above[i] < 0.98:
            flanks.append(_backward_strip(vertices[i, -1], False, i))
        if below[i] < 0.98 and course > 0:
            flanks.append(_backward_strip(vertices[i, 0], True, i))
        if not np.isclose(row[:, 0], cell[2]).any():
            flanks.append(_backward_strip(vertices[i, :, -1], True, i))
        if not np.isclose(row[:, 2], cell[0]).any():
            flanks.append(_backward_strip(vertices[i, :, 0], False, i))
    return flanks


def add(material):
    """The wall's mesh object."""
    cells, courses = _standing_bricks()
    relief = masonry.lay(cells, STYLE, seed=3)
    half_width = _opening_half_width(relief.v)
    inside = (abs(relief.u) < half_width) & (courses >= SILL_COURSE)[:, None]
    x = np.where(inside, np.copysign(half_width, relief.u), relief.u)
    y = np.where(inside, STYLE.depth, -relief.height)
    # Bricks end under the sill's slabs, not in the joints between those.
    under_sill = (abs(relief.u) < plan.SILL_HALF) & (courses < SILL_COURSE)[:, None]
    z = np.where(under_sill, np.minimum(relief.v, plan.SILL - 0.05), relief.v)
    vertices = np.stack([x, y, z], axis=-1)

    quads = relief.quads()
    quads = quads[~inside.ravel()[quads].all(axis=1)]
    colours = _colours(relief, courses, vertices)
    face = without_unused_vertices(Patch(vertices.reshape(-1, 3), colours.reshape(-1, 3), [quads]))
    flanks = _flanks(cells, courses, vertices.reshape(len(cells), *relief.shape, 3))
    return add_object("Brick Wall", merged([face, *flanks]), material)
