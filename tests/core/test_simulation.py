# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounces of light against a closed form and integral equations that are solved without a ray; and their energy."""

import numpy as np
import pytest

from core import simulation as simulation_module
from core.height_map import HeightMap
from core.rays import Occluders
from core.sample_points import CornerTable, spread_points
from core.simulation import simulate_height_map, simulate_mesh, trace_links
from core.surface import Surface, unit

from .endless_strips import EndlessStrips, rms, strip
from .height_fields import height_field, waves
from .shapes import box, join, plate, sphere
from .tracing import finish


def corner_table(vertices, triangles, normals=None):
    """With ``normals`` (n, 3) a vertex, or flat."""
    triangles = np.asarray(triangles, np.int32)
    if normals is None:
        a, b, c = np.moveaxis(vertices[triangles], 1, 0)
        normals = np.repeat(unit(np.cross(b - a, c - a)), 3, axis=0)
    else:
        normals = normals[triangles.ravel()]
    corners = np.arange(triangles.size, dtype=np.int32).reshape(-1, 3)
    start = np.arange(0, triangles.size, 3, dtype=np.int32)
    return CornerTable(
        Surface(np.asarray(vertices, float), triangles.ravel(), normals, corners, start, np.full_like(start, 3))
    )


def simulate(mesh, points=4000, samples=256, normals=None, **options):
    """The simulation and where its points lie, (n, 3)."""
    corners = corner_table(*mesh, normals)
    work = simulate_mesh(
        Occluders(*mesh),
        corners,
        points=points,
        samples=samples,
        extent=float(np.ptp(mesh[0], axis=0).max()),
        **options,
    )
    return finish(work), spread_points(corners, points).positions


@pytest.mark.parametrize("open_fraction", [0.5, 0.25])
def test_spherical_pit(open_fraction):
    """Every point sees all others alike: F_n = f (1 - f)^n."""
    vertices, triangles = sphere(rings=96)
    theta = np.arange(97) * np.pi / 96
    rim = theta[np.argmin(np.abs(np.cos(theta) - (1.0 - 2.0 * open_fraction)))]
    f = 0.5 * (1.0 - np.cos(rim))
    pit = vertices, triangles[vertices[triangles].mean(axis=1)[:, 2] < np.cos(rim)][:, ::-1]
    seen, _ = simulate(pit, normals=-vertices)
    for order in range(3):
        error = seen.bounces[order] - f * (1.0 - f) ** order
        print(f"pit of f = {f:.3f}: F{order} rms {rms(error):.4f}, bias {error.mean():+.5f}")
        assert rms(error) < 0.02 and abs(error.mean()) < 0.006
    for albedo in (0.5, 0.8, 0.95):
        error = seen.irradiance(albedo) - f / (1.0 - albedo * (1.0 - f))
        print(f"  E at albedo {albedo}: rms {rms(error):.4f}")
        assert rms(error) < 0.02


TRENCH = [((0, 1), (0, 0)), ((0, 0), (1, 0)), ((1, 0), (1, 1))]
PLATES = [((0, 0), (1, 0)), ((1, 0.5), (0, 0.5))]


@pytest.mark.parametrize(("segments", "name"), [(TRENCH, "trench"), (PLATES, "plates")])
def test_endless_strips(segments, name):
    """A trench of square section, and two plates that face each other over a gap of half their width."""
    truth = EndlessStrips(segments)
    seen, positions = simulate(join(*(strip(*segment) for segment in segments)), points=12000)
    for segment in range(len(segments)):
        expected, on = truth.at(segment, positions, 4)
        errors = [rms(seen.bounces[order][on] - expected[order]) for order in range(5)]
        print(f"{name}, strip {segment}, {on.sum()} points: rms of F0 to F4", *(f"{each:.4f}" for each in errors))
        assert on.sum() > 500 and max(errors) < 0.01


def test_light_off_the_back_of_an_open_sheet():
    """The upper plate turned over: the floor sees its back, its front sees the sky alone."""
    truth = EndlessStrips(PLATES)
    lower, upper = strip(*PLATES[0]), strip(*PLATES[1][::-1])
    seen, positions = simulate(join(lower, upper), points=12000)
    expected, on = truth.at(0, positions, 4)
    errors = [rms(seen.bounces[order][on] - expected[order]) for order in range(5)]
    print("sheet over a floor: rms of F0 to F4", *(f"{each:.4f}" for each in errors))
    assert max(errors) < 0.01
    top = positions[:, 2] > 0.25
    assert (seen.bounces[0][top] == 1.0).all() and (seen.bounces[1:, top] == 0.0).all()


def test_the_two_sides_of_a_closed_box():
    outside, _ = simulate(box(), points=600)
    assert (outside.bounces[0] == 1.0).all() and (outside.bounces[1:] == 0.0).all() and (outside.alpha == 1.0).all()
    vertices, triangles = box()
    inside, _ = simulate((vertices, triangles[:, ::-1]), points=600)
    assert (inside.bounces == 0.0).all() and (inside.irradiance(1.0) == 0.0).all()


def test_no_light_is_lost_on_the_way():
    """F0 and the weights of a point's links sum to exactly 1."""
    vertices, triangles = join(plate(2.0), sphere(0.5, (0, 0, 0.45), rings=24))
    points = spread_points(corner_table(vertices, triangles), 1500)
    work = trace_links(
        Occluders(vertices, triangles),
        points,
        lambda triangle, positions, normals: np.arange(len(positions)) % len(points),
        wanted=len(points),
        samples=100,
        extent=4.0,
        seed=3,
        threads=None,
    )
    _, direct, links = finish(work)
    assert (direct < 1.0).any() and (direct + links @ np.ones(len(points)) == 1.0).all()


def test_white_surfaces_in_the_open_send_all_light_back():
    """At albedo 1 the simulated bounces and the geometric tail sum to 1."""
    sphere_and_floor = join(plate(2.0), sphere(0.5, (0, 0, 0.6), rings=24))
    for name, seen in (
        ("waves", height_field(waves(), 0.2)),
        ("trench", simulate(join(*(strip(*segment) for segment in TRENCH)), points=8000)[0]),
        ("sphere over a floor", simulate(sphere_and_floor, points=8000)[0]),
    ):
        total = seen.irradiance(1.0)
        print(
            f"{name}: {len(seen.bounces) - 1} bounces sum to {seen.bounces.sum(axis=0).min():.4f} or more,"
            f" with the tail to {total.min():.5f} .. {total.max():.5f}"
        )
        assert np.abs(total - 1.0).max() < 0.005


def test_as_much_light_leaves_as_arrives():
    """A_i F_ij = A_j F_ji: over a closed surface the mean of F_1 is that of F_0 (1 - F_0)."""
    dented = sphere(rings=64)[0]
    dented *= 1.0 + 0.5 * np.sin(5.0 * dented + 1.0).prod(axis=1)[:, None]
    seen, _ = simulate((dented, sphere(rings=64)[1]), points=8000)
    direct, first = seen.bounces[:2]
    print(f"mean F1 {first.mean():.5f}, mean F0 (1 - F0) {(direct * (1 - direct)).mean():.5f}")
    assert first.mean() > 0.05 and abs(first.mean() - (direct * (1.0 - direct)).mean()) < 0.002


def test_irradiance_rises_with_albedo_from_f0_and_never_passes_one():
    albedo = np.linspace(0.0, 1.0, 21)[:, None]
    sealed = join(box(0.3), plate(2.0, -0.31), sphere(0.2, (0.3, 0, 0.3), rings=16))
    for seen in (height_field(waves(), 0.4, bounces=1), simulate(sealed, points=2000, bounces=3)[0]):
        e = seen.irradiance(albedo)
        assert e.shape == (21, len(seen.alpha)) and np.isfinite(e).all()
        assert (e[0] == seen.bounces[0]).all() and (np.diff(e, axis=0) >= 0.0).all() and (e <= 1.0 + 1e-12).all()


def test_the_tail_stands_for_the_bounces_left_out():
    short, long = height_field(waves(), 0.4), height_field(waves(), 0.4, bounces=200)
    for albedo in (0.8, 0.95, 1.0):
        error = rms(short.irradiance(albedo) - long.irradiance(albedo))
        without = sum(albedo**order * each for order, each in enumerate(short.bounces)) - long.irradiance(albedo)
        print(
            f"20 bounces against 200 at albedo {albedo}: rms {error:.6f} with the tail, {rms(without):.6f} without it"
        )
        assert error < 0.001


def test_bad_meshes_and_counts(monkeypatch):
    mesh = plate()
    for options in ({"points": 0}, {"samples": 0}, {"bounces": 0}):
        with pytest.raises(ValueError, match="one point, sample and bounce"):
            simulate(mesh, **options)
    with pytest.raises(ValueError, match="faces with an area"):
        simulate((np.zeros((3, 3)), np.array([[0, 1, 2]])))
    with pytest.raises(ValueError, match="own triangles"):
        finish(simulate_mesh(Occluders(*mesh), corner_table(*box()), points=9, samples=9, extent=1.0))
    monkeypatch.setattr(simulation_module, "MOST_RAYS", 16 * 16 * 8)
    height_field(waves(16), 0.1, 8)
    with pytest.raises(ValueError, match="use at most 8 samples"):
        height_field(waves(16), 0.1, 9)
    simulate(mesh, points=64, samples=16)
    with pytest.raises(ValueError, match="use at most 8 samples"):
        finish(simulate_mesh(Occluders(*mesh, -1.0), corner_table(*mesh), points=64, samples=16, extent=1.0))


def test_same_seed_same_bits_whatever_the_threads():
    mesh = join(plate(2.0), sphere(0.5, (0, 0, 0.45), rings=24))
    for run in (
        lambda **options: simulate(mesh, **options)[0],
        lambda **options: height_field(waves(), 0.2, **options),
    ):
        one, many, other = run(threads=1), run(threads=5), run(seed=1)
        assert one.bounces.tobytes() == many.bounces.tobytes() and one.alpha.tobytes() == many.alpha.tobytes()
        assert one.bounces.tobytes() != other.bounces.tobytes()


def test_progress_rises_and_closing_stops():
    work = simulate_height_map(HeightMap(waves(128), 0.2), samples=64, threads=1)
    done = [next(work)]
    work.close()
    work = simulate_height_map(HeightMap(waves(128), 0.2), samples=64)
    done += list(work)
    assert done[0] < 1.0 and done[-1] == 1.0 and (np.diff(done[1:]) >= 0.0).all()
