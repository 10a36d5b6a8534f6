# SPDX-License-Identifier: GPL-3.0-or-later
"""Things turned about an upright axis."""

from itertools import pairwise

import numpy as np

from . import palette
from .patches import Patch, closed_ring_quads


def lathe(profile: np.ndarray, sides: int, tone: np.ndarray) -> Patch:
    """A prism with `sides` flat sides: profile (k, 2) = (radius, height), bottom to top outside."""
    steps = np.maximum(np.linalg.norm(np.diff(profile, axis=0), axis=1) / 0.03, 2).astype(int)
    runs = [np.linspace(a, b, n, endpoint=False) for (a, b), n in zip(pairwise(profile), steps, strict=True)]
    fine = np.concatenate([*runs, profile[-1:]])
    per_side = 6
    angle = np.arange(sides * per_side) * 2 * np.pi / (sides * per_side)
    # Points stay on the polygon's straight sides: distance of a regular polygon's edge at this angle.
    to_side = np.cos(np.pi / sides) / np.cos((angle % (2 * np.pi / sides)) - np.pi / sides)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * to_side[:, None]
    vertices = np.concatenate(
        [fine[:, None, :1] * ring, np.broadcast_to(fine[:, None, 1:], (len(fine), len(angle), 1))], axis=-1
    ).reshape(-1, 3)
    colours = palette.mottled(np.broadcast_to(tone, vertices.shape), vertices, 4)
    return Patch(vertices, colours, [closed_ring_quads(len(fine), len(angle))])
