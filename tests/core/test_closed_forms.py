# SPDX-License-Identifier: GPL-3.0-or-later
"""Visibility where the integrals are known.

k_A = (1/pi) * integral of V cos, alpha = (1/2pi) * integral of V, 1024 samples.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from core.rays import Obscurance, Occluders

from .shapes import box, join, plate, quad, sphere
from .tracing import see

UP = (0.0, 0.0, 1.0)
FAR = 1000.0  # stands for infinity; what it leaves open is below 1 / FAR


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def many(x, y, z, count=64):
    """The same place many times: each point has its own turn of the pattern."""
    return np.tile((x, y, z), (count, 1))


def wall(x, height):
    """An endless wall in the plane x, facing -x, on the floor z = 0."""
    return quad((x, FAR, 0), (x, -FAR, 0), (x, -FAR, height), (x, FAR, height))


def test_floor_before_an_endless_wall():
    """Up to elevation e = atan(h / d) a half of the horizon is blocked: a lune of solid angle 2e, with cosine integral
    (pi/2)(1 - cos e). So alpha = 1 - e/pi and k_A = (1 + cos e)/2."""
    k_error, alpha_error = [], []
    for distance in (0.1, 0.25, 0.5, 1.0, 2.0, 5.0):
        e = np.arctan(1.0 / distance)
        seen = see(wall(distance, 1.0), many(0, 0, 0), UP)
        k_error.append(seen.f0 - (1.0 + np.cos(e)) / 2.0)
        alpha_error.append(seen.alpha - (1.0 - e / np.pi))
    print(f"wall: rms of k_A {rms(k_error):.4f}, of alpha {rms(alpha_error):.4f}")
    assert rms(k_error) < 0.004
    assert rms(alpha_error) < 0.006


def test_corners_of_two_and_of_three_planes():
    """A half and a quarter of the hemisphere are open, whatever the weight."""
    two = wall(0.3, FAR)
    seen = see(two, many(0, 0, 0), UP)
    print(f"corner: rms of k_A {rms(seen.f0 - 0.5):.4f}, of alpha {rms(seen.alpha - 0.5):.4f}")
    assert rms(seen.f0 - 0.5) < 0.004 and rms(seen.alpha - 0.5) < 0.006
    other = quad((-FAR, 0.7, 0), (FAR, 0.7, 0), (FAR, 0.7, FAR), (-FAR, 0.7, FAR))
    seen = see(join(two, other), many(0, 0, 0), UP)
    assert rms(seen.f0 - 0.25) < 0.004 and rms(seen.alpha - 0.25) < 0.006


@pytest.mark.parametrize("tilt", [0.0, 0.4, 0.8])
def test_sphere_over_a_plane(tilt):
    """Wholly above the horizon: k_A = 1 - cos t (R/d)^2; its cap has solid angle 2pi (1 - sqrt(1 - (R/d)^2))."""
    radius, distance = 0.5, 1.1
    centre = distance * np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    seen = see(sphere(radius, centre), many(0, 0, 0), UP)
    ratio = (radius / distance) ** 2
    print(f"sphere, tilt {tilt}: rms of k_A {rms(seen.f0 - (1.0 - np.cos(tilt) * ratio)):.4f}")
    assert rms(seen.f0 - (1.0 - np.cos(tilt) * ratio)) < 0.004
    assert rms(seen.alpha - np.sqrt(1.0 - ratio)) < 0.006


def test_bent_direction_before_an_endless_wall():
    """A hemisphere with a lune of angle e cut off: the rest is a lune of angle pi - e, whose mean direction points
    along its middle, at length (pi/4) sin((pi - e)/2) / ((pi - e)/2)."""
    e = np.pi / 4
    seen = see(wall(1.0, 1.0), many(0, 0, 0), UP)
    middle = e + (np.pi - e) / 2  # measured from +x, in the xz plane
    length = np.pi / 4 * np.sin((np.pi - e) / 2) / ((np.pi - e) / 2)
    expected = length * np.array([np.cos(middle), 0.0, np.sin(middle)])
    assert np.abs(seen.bent - expected).max() < 0.01


def test_a_flat_plate_is_exactly_open_and_a_closed_box_exactly_dark():
    points = np.random.default_rng(1).uniform(-0.99, 0.99, (500, 3))
    points[:, 2] = 0.0
    seen = see(plate(), points, UP)
    assert (seen.f0 == 1.0).all() and (seen.alpha == 1.0).all()
    assert np.abs(seen.bent[:, :2]).max() < 1e-6 and np.abs(seen.bent[:, 2] - 0.5).max() < 1e-3
    points[:, 2] = -1.0
    seen = see(box(), points, UP)
    assert (seen.f0 == 0.0).all() and (seen.alpha == 0.0).all() and (seen.bent == 0.0).all()


def test_spherical_pit():
    """Inside an open sphere all points see each other alike: k_A is the open fraction of the sphere's area
    everywhere."""
    points, triangles = sphere()
    open_fraction = 0.3
    heights = points[triangles].mean(axis=1)[:, 2]
    # A cap of height h has area 2 pi h, out of 4 pi.
    pit = points, triangles[heights < 1.0 - 2.0 * open_fraction]
    direction = np.random.default_rng(2).normal(size=(2000, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    direction = direction[direction[:, 2] < 0.3]
    on_facets = 0.9998 * direction  # facets lie up to 1 - cos(pi / 192) inside the sphere
    seen = see(pit, on_facets, -direction)
    rim = 0.5 * (1.0 - np.cos(np.pi / 192 * np.ceil(192 * np.arccos(1.0 - 2.0 * open_fraction) / np.pi)))
    assert rms(seen.f0 - rim) < 0.006


CEILING = 0.2  # under an endless ceiling at this height, with max_distance 1: only rays with cos > .2 reach it


@pytest.mark.parametrize(
    "falloff, k_a",
    [
        # integral over c = cos of 2c rho(h/c), where rho = 1 for c < h
        ("NONE", CEILING**2),
        ("LINEAR", CEILING**2 + 2 * CEILING * (1 - CEILING)),
        ("SMOOTH", CEILING**2 * (1 + 6 * np.log(1 / CEILING)) - 4 * CEILING**2 * (1 - CEILING)),
    ],
)
def test_obscurance_under_a_ceiling(falloff, k_a):
    ceiling = plate(FAR, CEILING)
    seen = see(ceiling, many(0, 0, 0), UP, samples=4096, obscurance=Obscurance(1.0, falloff))
    assert rms(seen.f0 - k_a) < 0.004


def test_obscurance_further_than_the_scene_is_plain_occlusion():
    mesh = join(sphere(0.5, (0, 0, 1.0), rings=24), plate(3.0, -0.2))
    points = np.random.default_rng(3).uniform(-1, 1, (300, 3)) * (1, 1, 0)
    plain = see(mesh, points, UP)
    for obscurance in (Obscurance(1e3), Obscurance(1e30)):
        limited = see(mesh, points, UP, obscurance=obscurance)
        assert limited.f0.tobytes() == plain.f0.tobytes() and limited.alpha.tobytes() == plain.alpha.tobytes()


def test_ground_plane_is_an_infinite_floor():
    """Before a wall's foot half of the sky is left; a point on the floor that faces down sees nothing."""
    nothing = plate(0.01, -5.0)
    at = many(0, 0, 0.3)
    seen = see(nothing, at, (1.0, 0.0, 0.0), ground_height=0.0)
    assert rms(seen.f0 - 0.5) < 0.004 and rms(seen.alpha - 0.5) < 0.006
    assert (see(nothing, many(0, 0, 0), (0, 0, -1.0), ground_height=0.0).f0 == 0.0).all()
    assert (see(nothing, many(0, 0, 0), UP, ground_height=0.0).f0 == 1.0).all()
    # within max_distance only: at height h a ray reaches the floor where cos > h / max
    seen = see(nothing, many(0, 0, 0.2), (0, 0, -1.0), samples=4096, ground_height=0.0, obscurance=Obscurance(1.0))
    assert rms(seen.f0 - 0.2**2) < 0.004


def test_ignore_backfaces():
    inside = many(0, 0, 0)
    assert (see(box(), inside, UP, obscurance=Obscurance(ignore_backfaces=True)).f0 == 1.0).all()
    # A box within a larger one turned inside out: rays leave the first and are stopped by the second's fronts.
    large, faces = box(2.0)
    both = join(box(), (large, faces[:, ::-1]))
    assert (see(both, inside, UP, obscurance=Obscurance(ignore_backfaces=True)).f0 == 0.0).all()
    assert (see(box(), inside, UP).f0 == 0.0).all()


def test_ignored_backfaces_without_width_end_the_ray():
    """Triangles that are a line, as single precision sees them: rays along it meet them again and again."""
    roof = np.array([(0, 0, 0), (1e30, 0, 0), (1e30, 1, 0), (0, 1, 0), (5e29, 0.5, 1)])
    faces = [(0, 1, 2), (0, 2, 3), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    occluders = Occluders(roof, faces)
    directions = np.random.default_rng(0).normal(size=(500, 3)).astype(np.float32)
    origins = np.repeat(occluders.vertices, 100, axis=0)
    run, calls = occluders._scene.run, []

    def counted(*arguments, **options):
        calls.append(1)
        assert len(calls) < 1000, "the rays go on without an end"
        return run(*arguments, **options)

    occluders._scene = SimpleNamespace(run=counted)
    hits = occluders.hits(origins, directions, Obscurance(ignore_backfaces=True))
    assert hits.triangle.max() < len(faces)


def test_falloff_without_max_distance_is_plain_occlusion():
    mesh = sphere(0.5, (0, 0, 1.0), rings=24)
    plain = see(mesh, many(0, 0, 0), UP)
    assert (see(mesh, many(0, 0, 0), UP, obscurance=Obscurance(falloff="LINEAR")).f0 == plain.f0).all()
