# SPDX-License-Identifier: GPL-3.0-or-later
"""The inside of the niche: ochre plaster, partly fallen off its bricks, below a fluted shell vault.

In plan it is a U: straight flanks from the wall's face back, then half an ellipse. Its UV map is analytic: the plaster
unrolled below, the vault as an azimuthal half disc above it.
"""

import numpy as np

from . import palette, plan
from .noise import fractal_noise, gradient_noise, smoothstep
from .patches import Patch, add_object, grid_quads, merged

FLUTES = 11
FLUTE_DEPTH = 0.13
PLASTER = 0.03
# Wide enough that the crust stays behind the stone surround.
RADIUS = plan.NICHE_RADIUS + 0.06
QUARTER = np.pi / 2 * RADIUS
GIRTH = 2 * (QUARTER + plan.NICHE_FLANK)
UV_SCALE = 0.96 / GIRTH
# The plaster goes on a little below the floor, and behind the edge of the vault: no light gets through.
FOOT = plan.SILL - 0.06
HEAD = plan.SPRING + 0.02


def _along_plan(u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and inward direction (..., 2) on the U at length u along it, from the left front to the right one."""
    angle = np.clip((u - plan.NICHE_FLANK) / RADIUS, 0, np.pi)
    outward = np.stack([-np.cos(angle), np.sin(angle)], axis=-1)
    straight = np.clip(u, 0, plan.NICHE_FLANK) - np.clip(u - plan.NICHE_FLANK - 2 * QUARTER, 0, None)
    position = RADIUS * outward * np.array([1, plan.NICHE_DEPTH])
    position[..., 1] += straight
    return position, -outward


def _brick_relief(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Height (...) in [0, 1] of plain bricks at arc length u and height v: 0 in the joints."""
    course = np.floor(v / 0.1)
    along = u / 0.26 + 0.5 * (course % 2)
    from_joint = np.minimum(0.26 * (0.5 - abs(along % 1 - 0.5)), 0.1 * (0.5 - abs(v / 0.1 % 1 - 0.5)))
    return smoothstep(0.006, 0.022, from_joint)


def _walls() -> Patch:
    rows, columns = 100, 340
    v = np.linspace(FOOT, HEAD, rows)[:, None]
    u, v = np.broadcast_arrays(np.linspace(0, GIRTH, columns)[None], v)
    on_wall = np.stack([u, v, np.zeros_like(u)], axis=-1)
    low = np.clip((plan.SILL + 0.8 - v) / 0.8, 0, 1)
    high = smoothstep(plan.SPRING - 0.12, plan.SPRING, v)
    kept = 1 - smoothstep(0.34, 0.38, fractal_noise(on_wall * 1.7, 3, 12) + 0.5 * low - high)
    bricks = _brick_relief(u, v)
    crust = PLASTER * kept * (1 + 0.12 * (1 - high) * fractal_noise(on_wall * 4, 3, 2))
    bare = 0.028 * bricks + 0.004 * gradient_noise(on_wall * 30, 4) - 0.03
    position, inward = _along_plan(u)
    behind = 2 * PLASTER * smoothstep(plan.SPRING - 0.005, HEAD, v)
    position = position + inward * (np.maximum(crust, bare) - behind)[..., None]
    position = np.concatenate([position, v[..., None]], axis=-1)

    plaster = np.broadcast_to(palette.OCHRE, position.shape)
    plaster = palette.mottled(plaster, on_wall, 15, scale=2.5, amount=0.07)
    brick = palette.mix(np.broadcast_to(palette.MORTAR, position.shape), palette.TERRACOTTA, bricks)
    colours = palette.mix(palette.mottled(brick, on_wall, 16, scale=8), plaster, kept)
    uvs = np.stack([0.02 + u * UV_SCALE, 0.015 + (v - FOOT) * UV_SCALE], axis=-1)
    quads = grid_quads(rows, columns)
    return Patch(position.reshape(-1, 3), colours.reshape(-1, 3), [quads], uvs.reshape(-1, 2))


def _vault() -> Patch:
    """A scallop shell: flutes fan out from the back of the springing and run forward to the arch."""
    rows, columns = 84, FLUTES * 22 + 1
    arc = np.linspace(0, QUARTER + plan.NICHE_FLANK, rows + 1)[1:, None]
    arc, around = np.broadcast_arrays(arc, np.linspace(np.pi, 0, columns)[None])
    polar = np.minimum(arc / RADIUS, np.pi / 2)
    forward = np.maximum(arc - QUARTER, 0)
    flute = abs(np.sin(FLUTES * around)) ** 0.8
    radius = RADIUS - PLASTER + FLUTE_DEPTH * flute * np.sin(polar) * smoothstep(0.05, 0.5, polar)
    position = np.stack(
        [
            radius * np.sin(polar) * np.cos(around),
            radius * np.cos(polar) * plan.NICHE_DEPTH + plan.NICHE_FLANK - forward,
            radius * np.sin(polar) * np.sin(around) + plan.SPRING,
        ],
        axis=-1,
    )
    ridge = 0.35 * (1 - flute) + 0.1
    colours = palette.mix(np.broadcast_to(palette.OCHRE, position.shape), palette.TERRACOTTA * 1.2, ridge)
    colours = palette.mottled(colours, position, 23, scale=3, amount=0.07)
    hub_uv = np.array([0.5, 0.015 + (HEAD - FOOT) * UV_SCALE + 0.03])
    uvs = hub_uv + arc[..., None] * UV_SCALE * np.stack([np.cos(around), np.sin(around)], axis=-1)

    hub = rows * columns
    hub_position = np.array([0, (RADIUS - PLASTER) * plan.NICHE_DEPTH + plan.NICHE_FLANK, plan.SPRING])
    first = np.arange(columns - 1)
    fan = np.stack([first, first + 1, np.full(columns - 1, hub)], axis=1)
    return Patch(
        np.concatenate([position.reshape(-1, 3), [hub_position]]),
        np.concatenate([colours.reshape(-1, 3), [palette.OCHRE]]),
        [grid_quads(rows, columns), fan[:, ::-1]],
        np.concatenate([uvs.reshape(-1, 2), [hub_uv]]),
    )


def _floor() -> Patch:
    rows, columns = 44, 48
    x = np.linspace(-RADIUS, RADIUS, columns)[None]
    y = np.linspace(0.2, RADIUS * plan.NICHE_DEPTH + plan.NICHE_FLANK, rows)[:, None]
    x, y = np.broadcast_arrays(x, y)
    z = plan.SILL - 0.03 + 0.004 * gradient_noise(np.stack([x, y, x], axis=-1) * 8, 1)
    position = np.stack([x, y, z], axis=-1)
    colours = palette.mottled(np.broadcast_to(palette.SANDSTONE, position.shape), position, 27, scale=5)
    return Patch(position.reshape(-1, 3), colours.reshape(-1, 3), [grid_quads(rows, columns)])


def add_inside(material):
    """Walls and vault as one object with a UV map."""
    return add_object("Alcove", merged([_walls(), _vault()]), material)


def add_floor(material):
    """The floor behind the sill."""
    return add_object("Alcove Floor", _floor(), material)
