# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces to simulate bounces on: height maps that tile, and meshes, made by formulas; and Blender's monkey.

Each function gives a :class:`core.height_map.HeightMap` of ``side`` pixels a side, or a flat-shaded
:class:`core.surface.Surface` whose fronts are seen.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from core.height_map import HeightMap
from core.surface import Surface, unit

Mesh = tuple[NDArray[np.float64], NDArray[np.int32]]  # vertices (n, 3), triangles (m, 3)


def _unit_square(side: int) -> tuple[NDArray, NDArray]:
    return tuple(np.meshgrid(*2 * [(np.arange(side) + 0.5) / side]))


def _noise(side: int, roughness: float, seed: int, largest: float = 2.0) -> NDArray:
    """Fractal noise that tiles, of unit variance: power falls with frequency^-(2 roughness + 2) past ``largest``."""
    white = np.fft.rfft2(np.random.default_rng(seed).normal(size=(side, side)))
    frequency = np.hypot(np.fft.fftfreq(side)[:, None], np.fft.rfftfreq(side)) * side
    noise = np.fft.irfft2(
        white * np.maximum(frequency, largest) ** -(roughness + 1.0) * (frequency > 0.0), (side, side)
    )
    return noise / noise.std()


def _nearest(side: int, count: int, seed: int) -> tuple[NDArray, NDArray]:
    """Distances (side, side) to the nearest and the second of ``count`` random points of a square that tiles."""
    x, y = _unit_square(side)
    best = np.full((2, side, side), np.inf)
    for place in np.random.default_rng(seed).uniform(size=(count, 2)):
        dx, dy = (np.abs(axis - at) for axis, at in zip((x, y), place, strict=True))
        distance = np.hypot(np.minimum(dx, 1.0 - dx), np.minimum(dy, 1.0 - dy))
        best[1] = np.minimum(best[1], np.maximum(best[0], distance))
        best[0] = np.minimum(best[0], distance)
    return best[0], best[1]


def stone_wall(side: int) -> HeightMap:
    """Rounded stones with joints between them, rough all over."""
    near, second = _nearest(side, 40, 1)
    return HeightMap(np.minimum((second - near) / 0.05, 1.0) ** 0.5 + 0.06 * _noise(side, 0.5, 2), 0.1)


def brick_wall(side: int) -> HeightMap:
    """Courses of bricks, each set in or out a little."""
    x, y = _unit_square(side)
    course = np.floor(y * 10).astype(int)
    along = (x * 5 + 0.5 * (course % 2)) % 5
    edge = np.minimum(np.minimum(along % 1, 1 - along % 1) * 0.2, np.minimum(y * 10 % 1, 1 - y * 10 % 1) * 0.1)
    out = np.random.default_rng(3).uniform(size=(10, 5))[course, along.astype(int)]
    return HeightMap(np.clip(edge / 0.012, 0, 1) * (0.6 + 0.4 * out) + 0.03 * _noise(side, 0.3, 4), 0.06)


def gravel(side: int) -> HeightMap:
    """Pebbles that lie close."""
    near, _ = _nearest(side, 150, 5)
    return HeightMap(np.sqrt(np.maximum(0.0, 1.0 - (near / 0.075) ** 2)) + 0.03 * _noise(side, 0.5, 6), 0.07)


def cloth(side: int) -> HeightMap:
    """Deep soft folds that wander."""
    x, y = _unit_square(side)
    fold = np.sin(2 * np.pi * (5 * x + 0.5 * np.sin(2 * np.pi * (y + x))) + 0.4 * _noise(side, 2.5, 7))
    return HeightMap(fold + 0.3 * np.sin(2 * np.pi * (3 * x - 4 * y)) + 0.1 * fold**3, 0.16)


def terrain(side: int) -> HeightMap:
    """Fractal mountains."""
    return HeightMap(_noise(side, 0.8, 8), 0.3)


def plaster(side: int) -> HeightMap:
    """Shallow dents, rough."""
    return HeightMap(np.abs(_noise(side, 1.0, 10, largest=6.0)) + 0.1 * _noise(side, 0.2, 14), 0.03)


def pits(side: int) -> HeightMap:
    """Hemispherical pits in a plane."""
    x, y = _unit_square(side)
    away = np.hypot((x * 5 + 0.5 * (np.floor(y * 5) % 2)) % 1 - 0.5, y * 5 % 1 - 0.5)
    return HeightMap(-np.sqrt(np.maximum(0.0, 0.45**2 - away**2)), 0.45 / 5)


def trenches(side: int) -> HeightMap:
    """Streets of square section between blocks of many heights."""
    x, y = _unit_square(side)
    street = np.minimum(x * 6 % 1, y * 6 % 1) > 0.35
    height = np.random.default_rng(9).uniform(0.5, 1.0, (6, 6))[(y * 6).astype(int), (x * 6).astype(int)]
    return HeightMap(height * street, 0.16)


def _flat(mesh: Mesh) -> Surface:
    vertices, triangles = mesh
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    start = np.arange(0, triangles.size, 3, dtype=np.int32)
    return Surface(
        vertices,
        triangles.ravel().astype(np.int32),
        np.repeat(unit(np.cross(b - a, c - a)), 3, axis=0),
        np.arange(triangles.size, dtype=np.int32).reshape(-1, 3),
        start,
        np.full_like(start, 3),
    )


def _joined(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in meshes)])
    return (
        np.concatenate([vertices for vertices, _ in meshes]),
        np.concatenate([triangles + start for (_, triangles), start in zip(meshes, starts[:-1], strict=True)]),
    )


def _quad(corner, u, v) -> Mesh:
    """A parallelogram from ``corner`` along ``u`` and ``v``, its front along u x v."""
    corner, u, v = (np.asarray(each, float) for each in (corner, u, v))
    return np.stack((corner, corner + u, corner + u + v, corner + v)), np.array([[0, 1, 2], [0, 2, 3]], np.int32)


def _box(low, high, inwards: bool = False, without: str = "") -> Mesh:
    """A box, fronts out or ``inwards``; ``without`` names left out faces by their outward axes, such as "+x-z"."""
    low, size = np.asarray(low, float), np.asarray(high, float) - low
    x, y, z = np.diag(size)
    faces = {"-x": (low, z, y), "+x": (low + x, y, z), "-y": (low, x, z), "+y": (low + y, z, x)}
    faces |= {"-z": (low, y, x), "+z": (low + z, x, y)}
    kept = [(at, v, u) if inwards else (at, u, v) for name, (at, u, v) in faces.items() if name not in without]
    return _joined(*(_quad(*face) for face in kept))


def _globe(shape: Callable[[NDArray], NDArray], rings: int) -> Mesh:
    """A sphere by latitudes and longitudes; ``shape`` gives the radius (n,) in unit directions (n, 3)."""
    theta, phi = np.linspace(0, np.pi, rings + 1)[:, None], np.arange(2 * rings) * (np.pi / rings)
    direction = np.stack(
        (np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi), axis=-1
    ).reshape(-1, 3)
    row, column = (each.ravel() for each in np.indices((rings, 2 * rings)))
    a, b = row * 2 * rings + column, row * 2 * rings + (column + 1) % (2 * rings)
    c, d = b + 2 * rings, a + 2 * rings
    triangles = np.concatenate((np.stack((a, d, c), axis=1), np.stack((a, c, b), axis=1)))
    return direction * shape(direction)[:, None], triangles.astype(np.int32)


def room() -> Surface:
    """A room of 4 x 5 x 3 with a window in the wall x = 0, and a table in it."""
    around_window = ((0, 5, 0, 1.0), (0, 5, 2.2, 3), (0, 1.0, 1.0, 2.2), (3.0, 5, 1.0, 2.2))
    wall = [_quad((0, y0, z0), (0, y1 - y0, 0), (0, 0, z1 - z0)) for y0, y1, z0, z1 in around_window]
    table = _joined(_box((1.5, 2, 0.7), (3, 3, 0.75)), _box((1.6, 2.1, 0), (1.7, 2.2, 0.7)))
    return _flat(_joined(_box((0, 0, 0), (4, 5, 3), inwards=True, without="-x"), *wall, table))


def open_court() -> Surface:
    """A court of 2 x 3 x 2 without a roof."""
    return _flat(_box((0, 0, 0), (2, 3, 2), inwards=True, without="+z"))


def spheres_on_floor() -> Surface:
    """Seven spheres of many sizes on a floor."""
    rng, floor = np.random.default_rng(11), _quad((-2, -2, 0), (4, 0, 0), (0, 4, 0))
    spheres = []
    for radius in (0.7, 0.5, 0.45, 0.4, 0.3, 0.25, 0.2):
        vertices, triangles = _globe(lambda direction, radius=radius: np.full(len(direction), radius), 24)
        spheres.append((vertices + np.append(rng.uniform(-1.3, 1.3, 2), 1.02 * radius), triangles))
    return _flat(_joined(floor, *spheres))


def coral() -> Surface:
    """A ball of deep folds and horns."""

    def shape(direction: NDArray) -> NDArray:
        warped = 7.0 * direction + 2.0 * np.sin(4.0 * direction[:, (1, 2, 0)])
        return 1.0 + 0.55 * np.sin(warped).prod(axis=1) + 0.15 * np.sin(3.0 * warped + 1.0).prod(axis=1)

    return _flat(_globe(shape, 120))


def blocks() -> Surface:
    """Boxes of many heights that stand about on a floor."""
    rng = np.random.default_rng(12)
    boxes = [_quad((0, 0, 0), (6, 0, 0), (0, 6, 0))]
    for x, y in np.argwhere(rng.uniform(size=(6, 6)) < 0.6):
        low, size = rng.uniform(0.05, 0.3, 2), rng.uniform(0.3, 0.65, 2)
        corner = np.array((x + low[0], y + low[1], 0.001))
        boxes.append(_box(corner, corner + np.append(size, rng.uniform(0.2, 1.8)), without="-z"))
    return _flat(_joined(*boxes))


def shelf() -> Surface:
    """A bookcase of thin boards, open to the front, and some books."""
    boards = [_box((0, 0, z), (3, 1, z + 0.04)) for z in (0.0, 0.8, 1.6, 2.4)]
    boards += [_box((x, 0, 0.04), (x + 0.04, 1, 2.4)) for x in (0.0, 1.48, 2.96)]
    boards.append(_quad((0, 0.99, 0), (3, 0, 0), (0, 0, 2.4)))
    rng = np.random.default_rng(13)
    for z in (0.05, 0.85, 1.65):
        for x in np.arange(0.1, 1.2, 0.12):
            boards.append(_box((x, rng.uniform(0.2, 0.5), z), (x + 0.1, 0.95, z + rng.uniform(0.4, 0.7))))
    return _flat(_joined(*boards))


def suzanne() -> Surface:
    """Blender's monkey."""
    import bmesh

    mesh = bmesh.new()
    bmesh.ops.create_monkey(mesh)
    bmesh.ops.triangulate(mesh, faces=mesh.faces)
    vertices = np.array([vertex.co for vertex in mesh.verts], np.float64)
    triangles = np.array([[vertex.index for vertex in face.verts] for face in mesh.faces], np.int32)
    mesh.free()
    return _flat((vertices, triangles))


HEIGHT_MAPS = (stone_wall, brick_wall, gravel, cloth, terrain, plaster, pits, trenches)
MESHES = (room, open_court, spheres_on_floor, coral, blocks, shelf, suzanne)
