# SPDX-License-Identifier: GPL-3.0-or-later
"""A box open to the front, after Goral et al. 1984, "Modeling the Interaction of Light Between Diffuse Surfaces".

Few large quads, deep corners, a red and a green wall: what single values of occlusion find hard.
"""

import bpy
import numpy as np
from mathutils import Vector

from . import materials, stage, statue
from .patches import Patch, add_object, merged

WHITE, RED, GREEN = np.array([0.75, 0.73, 0.70]), np.array([0.65, 0.12, 0.10]), np.array([0.16, 0.50, 0.12])
WIDTH, HEIGHT, DEPTH = 3.0, 3.0, 3.6
TALL, SHORT = (0.9, 0.9, 1.75), (1.1, 1.1, 0.7)
EYE, TARGET = Vector((0.0, -6.6, 1.5)), Vector((0.0, 0.0, 1.5))
# Between the quads in the UV map, as a part of its width.
UV_GAP = 0.02


def _quad(corner, u, v, colour: np.ndarray) -> Patch:
    """A parallelogram from `corner` along `u` and `v`, its front along u x v; its uvs are in metres."""
    corner, u, v = (np.asarray(each, float) for each in (corner, u, v))
    width, height = np.linalg.norm(u), np.linalg.norm(v)
    return Patch(
        np.stack([corner, corner + u, corner + u + v, corner + v]),
        np.tile(colour, (4, 1)),
        [np.arange(4)[None]],
        np.array([[0, 0], [width, 0], [width, height], [0, height]]),
    )


def _room() -> list[Patch]:
    x, y, z = np.diag([WIDTH, DEPTH, HEIGHT])
    low = -x / 2
    return [
        _quad(low, x, y, WHITE),
        _quad(low + z, y, x, WHITE),
        _quad(low + y, x, z, WHITE),
        _quad(low, y, z, RED),
        _quad(low + x, z, y, GREEN),
    ]


def _block(centre, size, turn: float) -> list[Patch]:
    """The sides and the top of a block on the floor."""
    x, y = size[0] * np.array([np.cos(turn), np.sin(turn), 0]), size[1] * np.array([-np.sin(turn), np.cos(turn), 0])
    z = np.array([0, 0, size[2]])
    low = np.array([*centre, 0]) - (x + y) / 2
    sides = [(low, x), (low + x, y), (low + x + y, -x), (low + y, -y)]
    return [*(_quad(corner, along, z, WHITE) for corner, along in sides), _quad(low + z, x, y, WHITE)]


def _laid_out(quads: list[Patch]) -> list[Patch]:
    """The quads with their uvs in rows that fill the unit square about evenly, all at one scale."""
    sizes = np.array([quad.uvs[2] for quad in quads])
    limit = 1.1 * np.sqrt(sizes.prod(axis=1).sum())
    gap = UV_GAP * limit
    x = y = row = widest = 0.0
    corners = {}
    for i in np.argsort(-sizes[:, 1]):
        if x > 0 and x + sizes[i, 0] > limit:
            x, y, row = 0.0, y + row + gap, 0.0
        corners[i] = np.array([x, y])
        x, row = x + sizes[i, 0] + gap, max(row, sizes[i, 1])
        widest = max(widest, x)
    scale = 1 / (max(widest, y + row) + gap)
    laid = [(quad.uvs + corners[i] + gap / 2) * scale for i, quad in enumerate(quads)]
    return [Patch(q.vertices, q.colours, q.polygons, uvs) for q, uvs in zip(quads, laid, strict=True)]


def build() -> tuple[list[bpy.types.Object], list[bpy.types.Object]]:
    """Build the box in a new, empty file; returns what to bake to vertices, and what to textures."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    quads = [*_room(), *_block((-0.6, 2.35), TALL, 0.35), *_block((0.55, 1.2), SHORT, -0.3)]
    box = add_object("Box", merged(_laid_out(quads)), materials.add("Paint", grain=20, roughness=0.9), smooth=False)
    suzanne = statue.add_suzanne(materials.add("Glaze", grain=8, roughness=0.25))
    suzanne.location = (0.55, 1.2, SHORT[2] + 0.44)
    camera = stage.add_camera()
    camera.location = EYE
    camera.rotation_euler = (TARGET - EYE).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 77
    return [suzanne], [box]
