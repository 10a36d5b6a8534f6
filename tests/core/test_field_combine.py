# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects: what two block together on a floor, by the product, and with their caps' overlap taken off."""

from dataclasses import replace

import numpy as np
import pytest

from core.ao_field import Caps
from core.field_combine import common_solid_angle, corrected, overlap, product

from .fields import SHAPES, baked, distance_to_hull, hull_of, made, occlusion, rms, unit
from .shapes import join

# What is asked of the overlap: of cubes, whose walls face each other across a gap, half of what is of the product.
PAIRS = [
    ("sphere", "sphere", 2.4, 0.006),
    ("tree", "table", 2.2, 0.006),
    ("torus", "sphere", 2.9, 0.006),
    ("cube", "cube", 2.6, 0.5 * 0.017),
]


def standing(name, x):
    """The shape and its field, on the floor z = 0, about ``x``."""
    (vertices, triangles), field = made(name)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    move = np.array([x, 0.0, 0.0]) - (*(0.5 * (low + high))[:2], low[2])
    return (vertices + move, triangles), replace(field, centre=field.centre + move)


@pytest.mark.parametrize("first, second, distance, limit", PAIRS)
def test_two_objects_on_a_floor(first, second, distance, limit):
    """The combination alone, of occlusions by rays, and with it the fields' own errors, over a floor of 12 x 10."""
    meshes, fields = zip(standing(first, -0.5 * distance), standing(second, 0.5 * distance), strict=True)
    x, y = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 1500)) * [[6.0], [5.0]]
    positions = np.column_stack((x, y, np.zeros(len(x))))
    for mesh in meshes:
        hull = hull_of(mesh)
        away = positions - hull.centre
        positions = positions[np.linalg.norm(away, axis=1) > 1.01 * distance_to_hull(hull, unit(away))]
    up = np.tile((0.0, 0.0, 1.0), (len(positions), 1))
    alone = [occlusion(mesh, positions, up, 1024) for mesh in meshes]
    truth = occlusion(join(*meshes), positions, up, 1024)
    both = np.clip(overlap(*(field.caps(positions) for field in fields), up), 0.0, np.minimum(*alone))
    by_product, by_overlap = rms(product(alone) - truth), rms(alone[0] + alone[1] - both - truth)
    of_fields = rms(product([field.occlusion(positions, up) for field in fields]) - truth)
    of_both = rms(corrected(fields, positions, up) - truth)
    print(f"{first} and {second}: rms of A by the product {by_product:.4f}, overlap-corrected {by_overlap:.4f}; "
          f"of the fields {of_fields:.4f} and {of_both:.4f}")  # fmt: skip
    assert by_product < 0.017 and by_overlap < limit
    assert of_both < of_fields


def cap(direction, solid_angle):
    return Caps(np.array([direction], float), np.array([solid_angle]), np.ones(1))


def test_overlap_of_caps_in_known_places():
    up = np.array([[0.0, 0.0, 1.0]])
    large, small = cap((0, 0, 1), 2.0), cap((0, 0, 1), 0.5)
    assert overlap(large, small, up) == pytest.approx(small.occlusion(up))
    assert overlap(small, cap((0, 0.6, 0.8), 0.1), up) == pytest.approx(0.0)
    tilted = cap((0.3, 0.0, 0.91**0.5), 1.2)
    assert overlap(large, tilted, up) == pytest.approx(overlap(tilted, large, up))
    assert 0.0 < overlap(large, tilted, up) < tilted.occlusion(up)


def test_overlap_against_counted_directions():
    """Pairs of caps that the horizon does not cut, up to 60 degrees wide: the part of the sky in both."""
    random = np.random.default_rng(2)
    normals = np.tile((0.0, 0.0, 1.0), (300, 1))
    sky = unit(random.normal(size=(20000, 3)))
    sky[:, 2] = np.abs(sky[:, 2])
    axes = unit(random.normal(size=(2, 300, 3)) * 0.5 + (0.0, 0.0, 1.0))
    cosines = random.uniform(0.5, 0.95, (2, 300))
    caps = [Caps(axis, 2.0 * np.pi * (1.0 - c), np.ones(300)) for axis, c in zip(axes, cosines, strict=True)]
    inside = [sky @ axis.T > c for axis, c in zip(axes, cosines, strict=True)]
    counted = 2.0 * (sky[:, 2:] * (inside[0] & inside[1])).mean(axis=0)
    error = rms(overlap(*caps, normals) - counted)
    print(f"overlap of caps: rms {error:.4f} of a mean of {counted.mean():.3f}")
    assert error < 0.01


def test_common_solid_angle_of_any_two_caps():
    random = np.random.default_rng(4)
    a, b, d = random.uniform(0.0, np.pi, (3, 200))
    z = 1.0 - (2.0 * np.arange(40000) + 1.0) / 40000
    azimuth = np.arange(40000) * np.pi * (3.0 - 5.0**0.5)
    along = np.sqrt(1.0 - z * z)[:, None] * np.cos(azimuth)[:, None] * np.sin(d) + z[:, None] * np.cos(d)
    counted = 4.0 * np.pi * ((z[:, None] > np.cos(a)) & (along > np.cos(b))).mean(axis=0)
    assert np.abs(common_solid_angle(a, b, d) - counted).max() < 0.01


def test_many_fields():
    random = np.random.default_rng(3)
    occlusions = random.uniform(0.0, 1.0, (5, 20))
    assert np.abs(product(occlusions) - (1.0 - (1.0 - occlusions).prod(axis=0))).max() < 1e-12
    field = baked(SHAPES["cube"](), resolution=8, samples=64)
    positions = 2.0 * unit(random.normal(size=(200, 3)))
    normals = unit(random.normal(size=(200, 3)))
    alone = field.occlusion(positions, normals)
    assert np.abs(corrected([field], positions, normals) - alone).max() < 1e-12
    # The same object twice blocks no more than once.
    twice = corrected([field, field], positions, normals)
    assert np.abs(twice - alone).max() < 0.2 and (twice >= alone - 1e-9).all()
    three = corrected([field, field, field], positions, normals)
    assert ((three >= 0.0) & (three <= 1.0)).all()
