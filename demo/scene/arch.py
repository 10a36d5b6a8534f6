# SPDX-License-Identifier: GPL-3.0-or-later
"""The dressed ring around the niche: jambs, voussoirs in two colours, and the sill."""

import numpy as np

from . import masonry, palette, plan
from .patches import Patch, add_object, grid_quads, merged

STYLE = masonry.Style(joint=0.008, bevel=0.022, depth=0.05, relief=0.004, crooked=0.006, inner_knots=(4, 6))
VOUSSOIRS = 19
JAMB_STONES = 5
REVEAL = 0.16


def _coloured(relief: masonry.Masonry, vertices: np.ndarray, seed: int) -> np.ndarray:
    alternate = np.where((np.arange(len(relief.u)) % 2 == 0)[:, None], palette.SANDSTONE, palette.TERRACOTTA)
    stones = palette.mottled(alternate[:, None], vertices, seed, scale=6)
    return palette.mix(np.broadcast_to(palette.MORTAR, stones.shape), stones, np.clip(relief.stone * 3 - 0.5, 0, 1))


def _soffit(points: np.ndarray) -> Patch:
    """The ring's inner face: from points (k, 3) on its front edge back into the niche."""
    depths = np.linspace(0, REVEAL + plan.RING_PROUD, 9)
    vertices = (points[None] + np.array([0, 1, 0]) * depths[:, None, None]).reshape(-1, 3)
    colours = palette.mottled(np.broadcast_to(palette.SANDSTONE, vertices.shape), vertices, 8, scale=6)
    return Patch(vertices, colours, [grid_quads(len(depths), len(points))])


def _ring() -> list[Patch]:
    # Along the ring: u is arc length at the inner edge, from the right jamb's foot over the arch to the left one's.
    jamb = plan.SPRING - plan.SILL
    arch = np.pi * plan.NICHE_RADIUS
    edges = np.concatenate(
        [
            np.linspace(0, jamb, JAMB_STONES + 1)[:-1],
            jamb + np.linspace(0, arch, VOUSSOIRS + 1)[:-1],
            jamb + arch + np.linspace(0, jamb, JAMB_STONES + 1),
        ]
    )
    count = len(edges) - 1
    cells = np.stack([edges[:-1], np.zeros(count), edges[1:], np.full(count, plan.RING_WIDTH)], axis=1)
    relief = masonry.lay(cells, STYLE, seed=17)

    def place(along, across, out):
        angle = np.clip(along - jamb, 0, arch) / plan.NICHE_RADIUS
        straight = np.minimum(along, jamb) - np.maximum(along - jamb - arch, 0)
        radius = plan.NICHE_RADIUS + across
        return np.stack([radius * np.cos(angle), -out, plan.SILL + straight + radius * np.sin(angle)], axis=-1)

    vertices = place(relief.u, relief.v, relief.height + plan.RING_PROUD)
    # (u right, v up) seen from the front became (round, outwards): the same hand once u runs anticlockwise.
    front = Patch(vertices.reshape(-1, 3), _coloured(relief, vertices, 3).reshape(-1, 3), [relief.quads()[:, ::-1]])
    fine = np.linspace(0, edges[-1], 220)
    inner = place(fine, np.zeros_like(fine), np.full_like(fine, plan.RING_PROUD - STYLE.depth))
    outer = place(fine, np.full_like(fine, plan.RING_WIDTH), np.full_like(fine, plan.RING_PROUD - STYLE.depth))
    rim = _soffit(outer)
    return [front, _soffit(inner), Patch(rim.vertices, rim.colours, [rim.polygons[0][:, ::-1]])]


def _sill_profile(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position (..., 2) = (y, z) and outward normal along the sill's section: underside, front, then top."""
    front, bottom, radius = -plan.SILL_PROUD, plan.SILL - plan.SILL_THICKNESS, 0.025
    run, rise, bend = 0.05 - front - radius, plan.SILL_THICKNESS - 2 * radius, np.pi / 2 * radius
    forward = np.clip(s, 0, run)
    lower = np.clip((s - run) / bend, 0, 1)
    up = np.clip(s - run - bend, 0, rise)
    upper = np.clip((s - run - bend - rise) / bend, 0, 1)
    back = np.clip(s - run - 2 * bend - rise, 0, None)
    turn = np.pi / 2 * (lower + upper)
    normal = np.stack([-np.sin(turn), -np.cos(turn)], axis=-1)
    middle = np.stack([0.05 - forward + back, bottom + radius + up], axis=-1)
    return middle + radius * normal, normal


def _sill() -> Patch:
    """A row of slabs, wider than the ring, standing further out."""
    edges = np.linspace(-plan.SILL_HALF, plan.SILL_HALF, 6)
    style = masonry.Style(joint=0.005, bevel=0.015, depth=0.02, relief=0.004, crooked=0.004, inner_knots=(12, 46))
    cells = np.stack([edges[:-1], np.zeros(5), edges[1:], np.full(5, 0.98)], axis=1)
    relief = masonry.lay(cells, style, 5)
    on_profile, normal = _sill_profile(relief.v)
    section = on_profile + normal * relief.height[..., None]
    vertices = np.concatenate([relief.u[..., None], section], axis=-1).reshape(-1, 3)
    colours = palette.mottled(np.broadcast_to(palette.SANDSTONE, vertices.shape), vertices, 7, scale=5)
    return Patch(vertices, colours, [relief.quads()])


def add(material):
    """Ring and sill as one mesh object."""
    return add_object("Niche Surround", merged([*_ring(), _sill()]), material)
