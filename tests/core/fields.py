# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with ambient occlusion fields, receivers around them, and what these see by the bakes' own ray loop."""

from functools import cache

import numpy as np

from core.field_bake import bake_field
from core.field_hull import Hull
from core.rays import Occluders
from core.workers import Workers

from .shapes import box, join, sphere
from .tracing import finish, see


def cuboid(low, high):
    vertices, triangles = box(0.5)
    low, high = np.array(low), np.array(high)
    return 0.5 * (low + high) + vertices * (high - low), triangles


def torus(ring=1.0, tube=0.35, around=96, across=48):
    i, j = (each.ravel() for each in np.indices((around, across)))
    u, v = 2.0 * np.pi * i / around, 2.0 * np.pi * j / across
    away = ring + tube * np.cos(v)
    vertices = np.column_stack((away * np.cos(u), away * np.sin(u), tube * np.sin(v)))
    a, b = i * across + j, (i + 1) % around * across + j
    c, d = (i + 1) % around * across + (j + 1) % across, i * across + (j + 1) % across
    return vertices, np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1)))


def table():
    legs = [cuboid((x - 0.07, y - 0.07, 0.0), (x + 0.07, y + 0.07, 0.9)) for x in (-0.8, 0.8) for y in (-0.5, 0.5)]
    return join(cuboid((-0.9, -0.6, 0.9), (0.9, 0.6, 1.0)), *legs)


def tree():
    """A trunk with blobs that run into each other."""
    blobs = [((0, 0, 1.6), 0.6), ((0.5, 0.1, 1.3), 0.4), ((-0.45, 0.25, 1.35), 0.42), ((0, -0.5, 1.4), 0.38)]
    crown = [sphere(radius, centre, 24) for centre, radius in [*blobs, ((0.1, 0.2, 2.1), 0.4)]]
    return join(cuboid((-0.12, -0.12, 0.0), (0.12, 0.12, 1.2)), *crown)


SHAPES = {"sphere": lambda: sphere(rings=96), "cube": box, "torus": torus, "table": table, "tree": tree}


@cache
def made(name, **options):
    """A shape's mesh and its field."""
    mesh = SHAPES[name]()
    return mesh, baked(mesh, **options)


def baked(mesh, **options):
    return finish(bake_field(Occluders(*mesh), *mesh, **options))


def hull_of(mesh):
    return Hull.of(*mesh)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def distance_to_hull(hull, directions):
    with Workers(1) as workers:
        return finish(hull.distances(directions, workers))[0]


def receivers(mesh, count=3000, nearest=0.01, furthest=3.0, seed=1):
    """Places outside the hull, their clearance log-uniform in parts of r0, with random normals."""
    random, hull = np.random.default_rng(seed), hull_of(mesh)
    omega, normals = unit(random.normal(size=(2, count, 3)))
    clearance = np.exp(random.uniform(np.log(nearest), np.log(furthest), count))
    return hull.centre + (distance_to_hull(hull, omega) * (1.0 + clearance))[:, None] * omega, normals


def occlusion(mesh, positions, normals, samples=4096):
    """A by the ray loop of the bakes, which shares no ray with those of a field."""
    return 1.0 - see(mesh, positions, normals, samples).f0.astype(float)


def rms(error):
    return float(np.sqrt(np.mean(np.square(error))))
