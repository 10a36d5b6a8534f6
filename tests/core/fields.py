# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with ambient occlusion fields, receivers around them, and what these see by the bakes' own ray loop."""

from functools import cache

import numpy as np

from core.cubemap import lookup
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


def error_around(name, mesh, field, asked):
    """rms of A of 3000 receivers around the object; printed with that of the plain cap beside it."""
    positions, normals = receivers(mesh)
    truth = occlusion(mesh, positions, normals)
    error = rms(field.occlusion(positions, normals) - truth)
    plain = rms(field.occlusion(positions, normals, plain_cap=True) - truth)
    print(f"{name}: rms of A {error:.4f}, by the plain cap {plain:.4f}; asked {asked}")
    return error


def error_on_floor(name, mesh, field):
    """rms of A of places spread evenly over the floor that the object stands on, six of its radii wide, outside the
    hull."""
    low = mesh[0][:, 2].min()
    x, y = np.random.default_rng(2).uniform(-3.0, 3.0, (2, 4000)) * field.radius
    positions = np.column_stack((x + field.centre[0], y + field.centre[1], np.full(len(x), low)))
    away = positions - field.centre
    clearance = np.linalg.norm(away, axis=1) / distance_to_hull(hull_of(mesh), unit(away))
    positions, clearance = positions[clearance > 1.01], clearance[clearance > 1.01]
    up = np.tile((0.0, 0.0, 1.0), (len(positions), 1))
    truth = occlusion(mesh, positions, up, 2048)
    found = field.occlusion(positions, up)
    contact = clearance < 1.2
    print(f"{name} on a floor: rms of A {rms(found - truth):.4f}; at contact A is {found[contact].mean():.3f}, "
          f"by rays {truth[contact].mean():.3f}")  # fmt: skip
    return rms(found - truth)


def assert_no_pole(field):
    """Both denominators of every texel are positive and rise from its r0 on, which a vertex before r0 tells, and a d
    that only adds; and between texels, where r0 is another's, the solid angle stays finite."""
    assert (field.d >= 0.0).all() and (field.e >= 1.0).all()
    for a, b, c in ((field.a, field.b, field.c), (field.a_m, field.b_m, field.c_m)):
        assert (a > 0.0).all()
        assert (2.0 * a * field.r0 + b > 0.0).all()
        assert ((a * field.r0 + b) * field.r0 + c > 0.0).all()
    omega = unit(np.random.default_rng(1).normal(size=(2000, 3)))
    r0 = lookup(field.r0, omega)
    for a, b, c in ((field.a, field.b, field.c), (field.a_m, field.b_m, field.c_m)):
        a, b, c = (lookup(each, omega) for each in (a, b, c))
        assert ((a * r0 + b) * r0 + c > 0.25 / (4.0 * np.pi) * 0.999).all()
