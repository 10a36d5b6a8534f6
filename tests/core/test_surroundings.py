# SPDX-License-Identifier: GPL-3.0-or-later
"""Light off what stands around a simulated surface: as if all were one mesh, from points that do not grow with it."""

import numpy as np
import pytest

from core.rays import Occluders
from core.sample_points import spread_points
from core.simulation import simulate_mesh
from core.surroundings import FLOOR_REACH, Ball, surrounding_points

from .endless_strips import LENGTH, EndlessStrips, rms
from .shapes import box, join, plate, quad, sphere
from .test_simulation import PLATES, TRENCH, corner_table
from .tracing import finish


def simulate(own, *around, points=6000, samples=256, ground_height=None, **options):
    """The simulation of the mesh ``own`` among others, and where its points lie."""
    corners = corner_table(*own)
    work = simulate_mesh(
        Occluders(*join(own, *around), ground_height),
        corners,
        points=points,
        samples=samples,
        extent=float(np.ptp(own[0], axis=0).max()),
        **options,
    )
    return finish(work), spread_points(corners, points).positions


def part(segment, low, high):
    """The part of an endless strip (:func:`.endless_strips.strip`) between two values of y."""
    (x0, z0), (x1, z1) = segment
    return quad((x0, high, z0), (x0, low, z0), (x1, low, z1), (x1, high, z1))


def in_the_middle_of(*segments):
    """A piece of the first strip, and what is around it: the rest of that strip, and the others."""
    half, end = 0.3, 0.5 * LENGTH
    rest = part(segments[0], half, end), part(segments[0], -end, -half)
    return part(segments[0], -half, half), *rest, *(part(each, -end, end) for each in segments[1:])


@pytest.mark.parametrize(("segments", "name"), [(TRENCH, "trench"), (PLATES, "plates")])
def test_a_piece_of_endless_strips(segments, name):
    truth = EndlessStrips(segments)
    for own in range(len(segments)):
        seen, positions = simulate(*in_the_middle_of(segments[own], *segments[:own], *segments[own + 1 :]))
        expected, on = truth.at(own, positions, 4)
        errors = [rms(seen.bounces[order] - expected[order]) for order in range(5)]
        print(f"{name}, piece of strip {own}: rms of F0 to F4", *(f"{each:.4f}" for each in errors))
        assert on.all() and max(errors) < 0.01


def test_a_wall_on_the_endless_floor():
    """A strip of the floor sees (sin b - sin a) / 2 of an endless wall of height 1, and the wall of the strip."""
    wall = ((0.0, 1.0), (0.0, 0.0))
    seen, positions = simulate(*in_the_middle_of(wall), ground_height=0.0)
    assert (positions[:, 0] == 0.0).all()
    edge = np.concatenate(([0.0], np.geomspace(1e-6, 1e6, 40_000)))
    x = np.sqrt(np.maximum(edge[1:] * edge[:-1], 1e-14))
    wall_seen = 0.5 * (1.0 - x / np.sqrt(1.0 + x**2))  # from the floor at x; half its light is the sky's
    floor = np.stack((1.0 - wall_seen, 0.5 * wall_seen))
    z = np.linspace(0.001, 1.0, 400)[:, None]
    part_seen = 0.5 * np.diff(-z / np.sqrt(edge**2 + z**2), axis=1)
    expected = [np.full(len(positions), 0.5), *(np.interp(positions[:, 2], z[:, 0], part_seen @ f) for f in floor)]
    errors = [rms(seen.bounces[order] - expected[order]) for order in range(3)]
    print("wall on an endless floor: rms of F0 to F2", *(f"{each:.4f}" for each in errors))
    assert max(errors) < 0.01


def light_off_the_floor(normal_z, radius, height):
    """F1 on a ball over an endless floor, at normals (k,): the floor at distance d from the ball's centre sees
    1 - radius^2 height / d^3 of the sky, summed over directions."""
    down, turn = (-(np.arange(300) + 0.5) / 300)[:, None], (np.arange(200) + 0.5) * np.pi / 200
    along = np.sqrt(1.0 - down**2)
    result = []
    for z in normal_z:
        x = np.sqrt(1.0 - z**2)
        cosine = np.maximum(x * along * np.cos(turn) + z * down, 0.0)
        reach = -(height + radius * z) / down * along
        away = (radius * x + reach * np.cos(turn)) ** 2 + (reach * np.sin(turn)) ** 2
        light = 1.0 - radius**2 * height / (away + height**2) ** 1.5
        result.append((cosine * light).mean() * 2.0)  # over a half-space of directions, 2 pi, over pi
    return np.array(result)


@pytest.mark.parametrize("around", ["a plate of 20 km", "a floor"])
def test_a_ball_in_a_wide_landscape(around):
    radius, height = 0.5, 0.7
    ball = sphere(radius, (0.0, 0.0, height), rings=64)
    others, ground = ([plate(1e4)], None) if around != "a floor" else ([], 0.0)
    seen, positions = simulate(ball, *others, points=4000, ground_height=ground)
    normal_z, z = (positions[:, 2] - height) / radius, np.linspace(-1.0, 1.0, 101)
    f1 = light_off_the_floor(z, radius, height)
    errors = [seen.bounces[0] - 0.5 * (1.0 + normal_z), seen.bounces[1] - np.interp(normal_z, z, f1)]
    total = seen.irradiance(1.0)
    print(
        f"ball over {around}: F0 and F1, rms {rms(errors[0]):.4f} {rms(errors[1]):.4f},"
        f" bias {errors[0].mean():+.5f} {errors[1].mean():+.5f}, bounces sum to {total.min():.5f} or more"
    )
    assert max(map(rms, errors)) < 0.01 and max(abs(error.mean()) for error in errors) < 0.003
    assert np.abs(total - 1.0).max() < 0.005


def test_nothing_gets_in_to_a_closed_room():
    seen, _ = simulate(sphere(0.5, rings=24), box(1.0), points=500, samples=64)
    assert (seen.bounces == 0.0).all()


def rings_of(points, ball, factor):
    """Points in rings about the ball, each ``factor`` times as far out."""
    away = np.linalg.norm(points.positions - ball.centre, axis=1) / ball.radius
    return np.bincount(np.floor(np.log(np.maximum(away, 1e-9)) / np.log(factor)).astype(int).clip(-1) + 1)


def test_as_dense_as_the_surface_within_the_ball_and_coarser_beyond():
    """On a plane through the ball's centre: pi R^2 / spacing^2 within it, and 2 pi R^2 ln 2 / spacing^2 a doubling."""
    own, far = sphere(1.0, rings=24), plate(2e5)
    ball, spacing = Ball.about(own[0]), 0.1
    occluders = Occluders(*join(own, far))
    points, apart = surrounding_points(occluders, len(own[1]), ball, spacing, most=10**6)
    assert apart == pytest.approx(spacing, rel=1e-3)
    assert (points.positions[:, 2] == pytest.approx(0.0, abs=0.02)) and (points.normals == (0.0, 0.0, 1.0)).all()
    count = rings_of(points, ball, 2.0)
    expected = np.pi * ball.radius**2 / spacing**2 * np.append(1.0, np.full(10, 2.0 * np.log(2.0)))
    print("points within the ball and in each doubling:", count[:11], "expected", expected[:2].round())
    assert np.abs(count[:11] / expected - 1.0).max() < 0.1

    fewer, apart = surrounding_points(occluders, len(own[1]), ball, spacing, most=2000)
    assert len(fewer) == 2000 and apart == pytest.approx(spacing * np.sqrt(len(points) / 2000), rel=1e-3)


def test_a_floor_has_points_as_a_plate_has():
    own = sphere(1.0, (3.0, 4.0, 5.0), rings=24)
    ball = Ball.about(own[0])
    vertices, triangles = plate(FLOOR_REACH * ball.radius, 2.0)
    plain = Occluders(*join(own, (vertices + np.append(ball.centre[:2], 0.0), triangles)), centre=ball.centre)
    floored = Occluders(*own, 2.0, centre=ball.centre)
    one, other = (surrounding_points(each, len(own[1]), ball, 0.2, 5000)[0] for each in (plain, floored))
    away = np.abs(one.positions - other.positions).max(axis=1) / np.linalg.norm(one.positions - ball.centre, axis=1)
    assert len(one) == len(other) == 5000 and away.max() < 1e-4 and (other.normals == (0.0, 0.0, 1.0)).all()


def test_what_has_no_area_has_no_points():
    own, line = plate(), (np.array([(0.0, 0, 1), (1, 0, 1), (2, 0, 1)]), np.array([[0, 1, 2]]))
    points, _ = surrounding_points(Occluders(*join(own, line)), 2, Ball.about(own[0]), 0.1, 100)
    assert len(points) == 0
    alone, among = simulate(own, points=100, samples=16)[0], simulate(own, line, points=100, samples=16)[0]
    np.testing.assert_array_equal(alone.bounces, among.bounces)


def test_the_place_in_the_world_is_of_no_matter():
    for shift in ((0.0, 0.0, 0.0), (5e3, -2e4, 1e4)):
        ball, floor = sphere(0.5, (0.0, 0.0, 0.7), rings=24), plate(50.0)
        seen, _ = simulate(*((vertices + shift, triangles) for vertices, triangles in (ball, floor)), points=1000)
        if not any(shift):
            first = seen
    error = rms(seen.bounces[:4] - first.bounces[:4])
    print(f"rms between the origin and {shift}: {error:.5f}")
    assert error < 0.005


def test_same_seed_same_bits_whatever_the_threads():
    mesh = sphere(0.5, (0.0, 0.0, 0.7), rings=24), plate(50.0)
    one, many = (simulate(*mesh, points=1000, samples=64, threads=threads)[0] for threads in (1, 5))
    other, _ = simulate(*mesh, points=1000, samples=64, seed=1)
    assert one.bounces.tobytes() == many.bounces.tobytes() != other.bounces.tobytes()
