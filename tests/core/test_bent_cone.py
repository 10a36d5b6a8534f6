# SPDX-License-Identifier: GPL-3.0-or-later
"""Bent cones where they are known, and the light that is made of them where it must be exact."""

import numpy as np
import pytest

from core import spherical_harmonics as sh
from core.bent_cone import sky_light

from .shapes import join, plate, quad, sphere
from .tracing import see

FAR = 1000.0  # stands for infinity
UP = np.array((0.0, 0.0, 1.0))
LIGHT = sh.project_panorama(np.random.default_rng(0).uniform(0.5, 1.5, (8, 16, 3)) ** 3)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def lune(from_angle):
    """What is left of the sky above the directions at ``from_angle`` from +x: its mean direction, in the xz plane."""
    half = (np.pi - from_angle) / 2
    return np.pi / 4 * np.sin(half) / half * np.array((np.cos(from_angle + half), 0.0, np.sin(from_angle + half)))


def pit_opening(point, edges=20_000):
    """Mean direction and alpha of the opening of a hemispherical pit, the unit circle, seen from ``point``.

    The first moment of a set of directions is half the integral of w x dw along its border, its solid angle the sum of
    the border's triangles (van Oosterom and Strackee 1983).
    """
    azimuth = np.arange(edges + 1) * (2 * np.pi / edges)
    border = np.column_stack((np.cos(azimuth), np.sin(azimuth), np.zeros(edges + 1))) - point
    border /= np.linalg.norm(border, axis=1, keepdims=True)
    moment = 0.5 * np.cross(border[:-1], border[1:]).sum(axis=0)
    middle = moment / np.linalg.norm(moment)
    a, b = border[:-1], border[1:]
    volume = np.cross(a, b) @ middle
    solid_angle = 2 * np.arctan2(volume, 1 + (a * b).sum(axis=1) + a @ middle + b @ middle).sum()
    return moment / solid_angle, solid_angle / (2 * np.pi)


def assert_bent(seen, expected, name):
    """Within 1 degree and .01, rms over points that differ in the turn of their rays."""
    length = np.linalg.norm(seen.bent, axis=1)
    cos = seen.bent @ expected / length / np.linalg.norm(expected)
    angle = np.degrees(np.arccos(np.clip(cos, -1, 1)))
    error = np.abs(length - np.linalg.norm(expected))
    print(
        f"{name}: direction {rms(angle):.2f} degrees rms, at most {angle.max():.2f}; "
        f"length {rms(error):.4f} rms, at most {error.max():.4f}"
    )
    assert rms(angle) < 1.0
    assert rms(error) < 0.01


@pytest.mark.parametrize("edge", [-2.0, -1.0, -0.5, 0.5, 2.0])
def test_under_a_half_plane(edge):
    """An endless slab at height 1 over all x > ``edge``, seen from the floor at 0."""
    slab = quad((edge, -FAR, 1), (edge, FAR, 1), (FAR, FAR, 1), (FAR, -FAR, 1))
    seen = see(slab, np.zeros((64, 3)), UP, extent=1.0)
    assert_bent(seen, lune(np.arctan2(1.0, edge)), f"edge at {edge}")


@pytest.mark.parametrize("distance", [0.1, 0.5, 1.0, 3.0])
def test_beside_a_wall(distance):
    wall = quad((distance, FAR, 0), (distance, -FAR, 0), (distance, -FAR, 1), (distance, FAR, 1))
    seen = see(wall, np.zeros((64, 3)), UP)
    assert_bent(seen, lune(np.arctan2(1.0, distance)), f"wall at {distance}")


@pytest.mark.parametrize("degrees", [0, 30, 60, 80])
def test_in_a_hemispherical_pit(degrees):
    """At ``degrees`` up from its bottom."""
    points, triangles = sphere()
    pit = points, triangles[points[triangles][:, :, 2].max(axis=1) < 1e-9]
    angle = np.radians(degrees)
    point = 0.9998 * np.array((np.sin(angle), 0, -np.cos(angle)))
    seen = see(pit, np.tile(point, (64, 1)), -point / np.linalg.norm(point))
    bent, alpha = pit_opening(point)
    assert_bent(seen, bent, f"{degrees} degrees up")
    assert np.abs(seen.alpha - alpha).max() < 0.01
    if degrees == 0:  # a true cone, of 45 degrees
        np.testing.assert_allclose(np.linalg.norm(bent), (1 + np.cos(np.pi / 4)) / 2, atol=1e-3)


def random_cones(count=500, seed=1):
    """Normals, and b and alpha of random sets of directions above their horizon."""
    rng = np.random.default_rng(seed)
    normals = rng.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    directions = rng.normal(size=(4096, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    axes, least = rng.normal(size=(count, 3)), rng.uniform(-1.5, 1.0, count)
    up = normals @ directions.T > 0
    seen = up & (axes @ directions.T > least[:, None])
    seen[seen.sum(axis=1) < 20] = True
    seen &= up
    bent = (seen @ directions) / seen.sum(axis=1, keepdims=True)
    return normals, bent, seen.sum(axis=1) / up.sum(axis=1)


def test_open_surfaces_have_the_plain_irradiance():
    normals, _, _ = random_cones()
    light = sky_light(LIGHT, 0.5 * normals, np.ones(len(normals)), normals)
    plain = sh.irradiance(LIGHT, normals)
    np.testing.assert_allclose(light.irradiance, plain, rtol=1e-9)
    np.testing.assert_allclose(light.sky, plain, rtol=1e-9)
    np.testing.assert_allclose(light.relative, 1.0, rtol=1e-9)


def test_a_white_world_gives_f0():
    normals, bent, alpha = random_cones()
    white = sh.project(np.ones((1, 3)) * 4 * np.pi, np.array([(0.0, 0.0, 1.0)]), np.ones(1))
    white[1:] = 0.0
    light = sky_light(white, bent, alpha, normals)
    f0 = 2 * alpha * (bent * normals).sum(axis=1)
    np.testing.assert_allclose(light.irradiance, np.repeat(f0[:, None], 3, axis=1), atol=1e-9)
    np.testing.assert_allclose(light.sky, 1.0, rtol=1e-9)
    np.testing.assert_allclose(light.relative, 1.0, rtol=1e-9)


def test_f0_of_a_bake_is_that_of_its_cone():
    """F0 = 2 alpha b . n, from one bake's own numbers: to the last of their bits, however few rays."""
    points, triangles = sphere(0.4, (0.2, 0.1, 0.7), rings=48)
    scene = join((points, triangles), quad((0.5, 9, 0), (0.5, -9, 0), (0.5, -9, 2), (0.5, 9, 2)), plate(9.0))
    at = np.random.default_rng(2).uniform((-1, -1, 0), (0.45, 1, 0), (500, 3))
    for samples in (1, 7, 128):
        seen = see(scene, at, UP, samples=samples, extent=2.0)
        error = np.abs(2 * seen.alpha * (seen.bent @ UP) - seen.f0).max()
        print(f"{samples} samples: F0 and 2 alpha b . n within {error:.1e}")
        assert error < 4 * np.finfo(np.float32).eps


def test_narrow_cones_show_the_sky_at_their_axis():
    normals, axes = np.tile(UP, (20, 1)), np.random.default_rng(3).normal(size=(20, 3))
    axes[:, 2] = np.abs(axes[:, 2]) + 0.5
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    light = sky_light(LIGHT, axes, np.full(20, 1e-3), normals)
    np.testing.assert_allclose(light.irradiance / (2e-3 * axes[:, 2:]), sh.evaluate(LIGHT, axes), rtol=0.01)


def test_closed_points_are_dark_and_nothing_is_not_a_number():
    normals = np.tile(UP, (3, 1))
    light = sky_light(LIGHT, np.zeros((3, 3)), np.array((0.0, 0.5, 1.0)), normals)
    np.testing.assert_allclose(light.irradiance[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(light.irradiance[2], sh.irradiance(LIGHT, UP), rtol=1e-9)
    assert all(np.isfinite(each).all() and (each >= 0).all() for each in light)
    for each in sky_light(np.zeros((9, 3)), np.zeros((3, 3)), np.array((0.0, 0.5, 1.0)), normals):
        np.testing.assert_array_equal(each, 0.0)
