# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects: what two block together on a floor, by the product, and with their caps' overlap taken off."""

from dataclasses import replace

import numpy as np
import pytest

from core.ao_field import Caps
from core.field_combine import corrected, less_overlap, overlap, product

from .fields import SHAPES, baked, distance_to_hull, hull_of, made, occlusion, rms, unit
from .shapes import join

PAIRS = [("sphere", "sphere", 2.4), ("tree", "table", 2.2), ("torus", "sphere", 2.9), ("cube", "cube", 2.6)]


def standing(name, x):
    """The shape and its field, on the floor z = 0, about ``x``."""
    (vertices, triangles), field = made(name)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    move = np.array([x, 0.0, 0.0]) - (*(0.5 * (low + high))[:2], low[2])
    return (vertices + move, triangles), replace(field, centre=field.centre + move)


@pytest.mark.parametrize("first, second, distance", PAIRS)
def test_two_objects_on_a_floor(first, second, distance):
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
    by_overlap = rms(less_overlap(alone, [field.caps(positions) for field in fields], up) - truth)
    by_product = rms(product(alone) - truth)
    of_fields = rms(product([field.occlusion(positions, up) for field in fields]) - truth)
    of_both = rms(corrected(fields, positions, up) - truth)
    print(f"{first} and {second}: rms of A by the product {by_product:.4f}, overlap-corrected {by_overlap:.4f}; "
          f"of the fields {of_fields:.4f} and {of_both:.4f}")  # fmt: skip
    assert by_product < 0.017 and by_overlap < 0.006
    assert of_fields < 0.017 and of_both < of_fields


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


def test_what_is_known_of_each_object_corrects_the_caps():
    """Of a cap in another: a known A scales what it blocks, and one that is scattered hides as little of what it is."""
    up = np.array([[0.0, 0.0, 1.0]])
    caps = [cap((0, 0, 1), 2.0), cap((0.1, 0.0, 0.99**0.5), 0.5)]
    large, small = (each.occlusion(up) for each in caps)
    assert less_overlap([large, small], caps, up) == pytest.approx(large)
    assert less_overlap([0.5 * large, small], caps, up) == pytest.approx(0.5 * large + small - 0.5 * small)
    assert less_overlap([large, 0.3 * small], caps, up) == pytest.approx(large)
    # None blocks more than itself, nor do caps below the horizon, of which nothing is known, divide by 0.
    assert less_overlap([1.5 * large, small], caps, up) == pytest.approx(1.5 * large)
    below = [caps[0], cap((0, 0, -1), 0.5)]
    assert less_overlap([large, np.array([0.1])], below, up) == pytest.approx(large + 0.1)


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
