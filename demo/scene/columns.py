# SPDX-License-Identifier: GPL-3.0-or-later
"""Fluted columns, broken off at different heights, and a fallen drum that keeps its Subdivision modifier."""

import bpy
import numpy as np

from . import palette
from .noise import fractal_noise, smoothstep
from .patches import Patch, add_object, closed_ring_quads, merged

FLUTES = 16
RADIUS = 0.31


def _shaft(height: float, spacing: float, per_flute: int, seed: int, broken: float) -> Patch:
    """A fluted shaft from z = 0, its broken end closed towards the axis."""
    sides = FLUTES * per_flute
    angle = (np.arange(sides) * 2 * np.pi / sides)[None]
    z = np.linspace(0, 1, int(height / spacing) + 2)[:, None]
    top = height + broken * fractal_noise(np.stack([np.cos(angle), np.sin(angle), 0 * angle], -1) * 1.3, 3, seed)
    heights = z * top
    plain = 1 - smoothstep(0.03, 0.1, heights)
    groove = abs(np.sin(angle * FLUTES / 2)) ** 0.7 * (1 - plain)
    radius = RADIUS * (1 - 0.03 * heights) - 0.045 * groove
    at = np.stack([np.cos(angle) + 0 * z, np.sin(angle) + 0 * z, heights / RADIUS], axis=-1)
    radius = radius - 0.05 * np.maximum(fractal_noise(at * 1.6, 3, seed + 3) - 0.42, 0)
    radius = radius + 0.002 * fractal_noise(at * 9, 2, seed)
    side = np.stack([radius * np.cos(angle), radius * np.sin(angle), heights + 0 * angle], axis=-1)

    shrink = np.linspace(1, 0, 8)[1:, None]
    end = side[-1][None] * shrink[..., None] * np.array([1, 1, 0])
    rough = 0.5 * broken * fractal_noise(end / RADIUS * 1.7 + seed, 3, seed + 1) * (1 - shrink) * 2
    end[..., 2] = side[-1, :, 2] * shrink + (1 - shrink) * height + rough
    vertices = np.concatenate([side, end]).reshape(-1, 3)
    colours = np.broadcast_to(palette.SANDSTONE, vertices.shape)
    colours = palette.mottled(colours, vertices, seed + 5, scale=4, amount=0.07)
    return Patch(vertices, colours, [closed_ring_quads(len(z) + len(shrink), sides)])


def _base() -> Patch:
    """An Attic base: torus, hollow, torus."""
    t = np.linspace(-np.pi / 2, np.pi / 2, 10)
    lower = np.stack([0.40 + 0.07 * np.cos(t), 0.07 + 0.07 * np.sin(t)], axis=-1)
    upper = np.stack([0.34 + 0.045 * np.cos(t), 0.245 + 0.045 * np.sin(t)], axis=-1)
    s = np.linspace(0, np.pi, 10)[1:-1]
    hollow = np.stack([0.365 - 0.03 * np.sin(s), 0.17 - 0.03 * np.cos(s)], axis=-1)
    profile = np.concatenate([lower, hollow, upper, [[RADIUS - 0.03, 0.29]]])
    angle = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    vertices = np.stack(
        [profile[:, :1] * np.cos(angle), profile[:, :1] * np.sin(angle), profile[:, 1:] + 0 * angle], axis=-1
    ).reshape(-1, 3)
    colours = palette.mottled(np.broadcast_to(palette.SANDSTONE, vertices.shape), vertices, 2, scale=4)
    return Patch(vertices, colours, [closed_ring_quads(len(profile), 72)])


def _weathered(patch: Patch, seed: int, amount: float) -> Patch:
    low = np.clip(1 - patch.vertices[:, 2] / 0.7, 0, 1)
    colours = palette.mossy(patch.colours, patch.vertices, 0.3 * low + amount, seed)
    return Patch(patch.vertices, colours, patch.polygons)


def add_standing(name: str, location, height: float, seed: int, material) -> bpy.types.Object:
    """A base with a broken shaft on it."""
    shaft = _shaft(height, 0.045, 8, seed, broken=0.12)
    shaft.vertices = shaft.vertices + np.array([0, 0, 0.28])
    column = add_object(name, _weathered(merged([_base(), shaft]), seed, 0.1), material)
    column.location = location
    column.rotation_euler[2] = seed
    return column


def add_fallen_drum(location, material) -> bpy.types.Object:
    """A drum lying on its side: a coarse cage under an unapplied Subdivision modifier."""
    drum = add_object("Fallen Drum", _weathered(_shaft(0.95, 0.06, 6, 8, broken=0.10), 8, 0.12), material)
    modifier = drum.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 1
    drum.location = location
    drum.rotation_euler = (np.pi / 2 - 0.02, 0.9, 0.95)
    return drum
