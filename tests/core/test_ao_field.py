# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion fields against rays: 4096 a receiver, by the bakes' own ray loop."""

from dataclasses import replace

import numpy as np
import pytest

from core.cubemap import lookup
from core.field_bake import bake_field
from core.field_rays import seen_in_cones
from core.rays import Occluders
from core.workers import Workers

from .fields import (
    SHAPES,
    assert_no_pole,
    baked,
    error_around,
    error_on_floor,
    hull_of,
    made,
    occlusion,
    receivers,
    rms,
    unit,
)
from .shapes import plate, sphere
from .tracing import finish

LIMITS = {"sphere": 0.0115, "cube": 0.029, "torus": 0.033, "table": 0.028, "tree": 0.018}


@pytest.mark.parametrize("name", SHAPES)
def test_receivers_around_a_shape(name):
    mesh, field = made(name)
    assert error_around(name, mesh, field, LIMITS[name]) < LIMITS[name]


@pytest.mark.parametrize("name", SHAPES)
def test_floor_under_a_shape(name):
    mesh, field = made(name)
    assert error_on_floor(name, mesh, field) < 0.025


def test_solid_angle_of_a_sphere():
    """Omega(r) = 2pi (1 - sqrt(1 - (R/r)^2)), |M| = (R/r)^2, as measured by the bake's rays: in the sphere's own cone,
    which none misses, and in that of one half as large again."""
    mesh = sphere(rings=384)
    r = np.geomspace(1.01, 8.0, 40)
    omega = unit(np.random.default_rng(1).normal(size=(40, 3)))
    expected = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - 1.0 / r**2))
    for aimed in (1.0, 1.5):
        with Workers(1) as workers:
            cone = np.sqrt(np.maximum(1.0 - (aimed / r) ** 2, 0.0))
            seen = finish(seen_in_cones(Occluders(*mesh), r[:, None] * omega, -omega, cone, 512, 0, workers))
        error = np.abs(seen.Omega / expected - 1.0).max()
        moment = np.abs(np.linalg.norm(seen.M, axis=1) * r**2 - 1.0).max()
        print(f"sphere, by rays at one of {aimed} R: Omega within {100 * error:.2f} %, |M| within {100 * moment:.2f} %")
        assert error < 0.01 and moment < 0.01
    fitted = made("sphere")[1].caps(r[:, None] * omega, plain_cap=True).solid_angle
    off = np.abs(fitted / expected - 1.0).max()
    print(f"sphere, by the functions fitted to 8 radii: Omega within {100 * off:.2f} %")
    assert off < 0.01


@pytest.mark.parametrize("name", SHAPES)
def test_no_pole_on_a_shape(name):
    assert_no_pole(made(name)[1])


def test_no_pole_on_a_hundred_random_meshes():
    """Of 4 to 40 triangles of any size and place, some flat, some thin; tiny, huge, far from the origin."""
    for seed in range(100):
        random = np.random.default_rng(seed)
        count = int(random.integers(4, 41))
        corners = random.normal(size=(count, 1, 3)) + random.uniform(0.1, 1.0) * random.normal(size=(count, 3, 3))
        corners *= np.exp(random.uniform(-2.0, 0.0, 3)) * (1.0, 1.0, random.integers(0, 8) > 0)
        vertices = corners.reshape(-1, 3) * np.exp(random.uniform(-6.0, 6.0)) + random.normal(size=3)
        mesh = vertices, np.arange(3 * count).reshape(-1, 3)
        assert_no_pole(baked(mesh, resolution=8, samples=16, radii=6, low_pass=seed % 2 == 0))


@pytest.mark.parametrize("name", ["torus", "table", "tree"])
def test_receivers_inside_the_hull(name):
    mesh, field = made(name, volume=True)
    hull = hull_of(mesh)
    positions = hull.centre + hull.places_inside(4000, 7)
    normals = unit(np.random.default_rng(8).normal(size=positions.shape))
    truth = occlusion(mesh, positions, normals, 1024)
    # Inside the solid every ray is blocked, whatever the normal.
    free = (truth < 1.0) & (occlusion(mesh, positions, -normals, 256) < 1.0)
    positions, normals, truth = positions[free], normals[free], truth[free]
    constants = replace(field, volume=None)
    by_constants = rms(constants.occlusion(positions, normals) - truth)
    best_constant = rms(truth - truth.mean())
    by_volume = rms(field.occlusion(positions, normals) - truth)
    print(f"inside {name}: rms of A {by_constants:.3f} with A0 = {field.a0:.2f}, p = {field.p:.2f}, "
          f"by the best constant {best_constant:.3f}, with the volume {by_volume:.3f}")  # fmt: skip
    assert by_constants < best_constant
    assert by_volume < 0.08


def test_field_is_continuous_at_the_hull_and_fades_out():
    field = made("table", volume=True)[1]
    omega, normals = unit(np.random.default_rng(3).normal(size=(2, 500, 3)))
    r0 = lookup(field.r0, omega)
    for each in (field, replace(field, volume=None)):
        at = [each.occlusion(field.centre + (r0 * s)[:, None] * omega, normals) for s in (1.0 - 1e-14, 1.0 + 1e-14)]
        assert np.abs(at[0] - at[1]).max() < 1e-6
    far = field.centre + field.r_far * omega
    assert (field.occlusion(far, normals) == 0.0).all()
    # At the centre A0, whatever the direction.
    assert replace(field, volume=None).occlusion(field.centre[None], normals[:1]) == pytest.approx(field.a0)


def test_same_bits_for_any_number_of_threads():
    mesh = SHAPES["table"]()
    options = {"resolution": 8, "samples": 64, "volume": True}
    first, second = (baked(mesh, threads=threads, **options) for threads in (1, 3))
    for key in ("a", "b", "c", "d", "r0", "a_m", "b_m", "c_m", "c0", "e", "centre"):
        assert getattr(first, key).tobytes() == getattr(second, key).tobytes(), key
    assert (first.a0, first.p, first.volume.p) == (second.a0, second.p, second.volume.p)
    assert first.volume.values.tobytes() == second.volume.values.tobytes()
    assert baked(mesh, seed=1, **options).a.tobytes() != first.a.tobytes()


def test_scale_and_place_do_not_matter():
    mesh, field = made("table")
    positions, normals = receivers(mesh, 500)
    vertices = mesh[0] * 1e-4 + (0.3, -0.2, 0.1)
    small = baked((vertices, mesh[1]))
    moved = small.occlusion(positions * 1e-4 + (0.3, -0.2, 0.1), normals)
    difference = rms(moved - field.occlusion(positions, normals))
    print(f"a table of a tenth of a millimetre: rms of the difference {difference:.4f}")
    assert difference < 0.003


def test_rounding_of_coordinates_does_not_matter():
    """A cube that stands elsewhere, whose coordinates come back through its transform, is baked by the same rays: few,
    so that others would show."""
    vertices, triangles = SHAPES["cube"]()
    options = {"resolution": 8, "samples": 16}
    field = baked((vertices, triangles), **options)
    for seed in range(4):
        rounded = vertices + 1e-16 * np.random.default_rng(seed).integers(-1, 2, vertices.shape)
        found = baked((rounded, triangles), **options)
        for key in ("a", "b", "c", "d", "r0", "a_m", "b_m", "c_m"):
            np.testing.assert_allclose(getattr(found, key), getattr(field, key), rtol=1e-6, err_msg=key)


def test_a_sheet_has_a_field():
    """A square of no thickness. Above its middle, facing it: the form factor of a square, by its four corners."""
    field = baked(plate())
    height = np.array([0.05, 0.2, 0.5, 1.0, 2.0])
    up = np.column_stack((np.zeros((5, 2)), height))
    x = 1.0 / np.hypot(height, 1.0)
    expected = 4.0 / np.pi * x * np.arctan(x)  # four corners of (x atan x + x atan x) / 2pi each
    for side in (1.0, -1.0):
        found = field.occlusion(side * up, np.tile((0.0, 0.0, -side), (5, 1)))
        print(f"a sheet: A is off by {np.abs(found - expected).max():.3f} above its middle")
        assert np.abs(found - expected).max() < 0.06
    mesh = plate()
    positions, normals = receivers(mesh, 1500)
    truth = occlusion(mesh, positions, normals, 1024)
    error = rms(field.occlusion(positions, normals) - truth)
    print(f"a sheet: rms of A around it {error:.4f}")
    # Beside its edges, where places in contact see next to nothing, a fit that goes astray shows at once.
    assert error < 0.06


@pytest.mark.parametrize(
    "vertices, triangles, message",
    [
        (np.zeros((3, 3)), np.empty((0, 3), int), "faces"),
        (np.ones((3, 3)), [[0, 1, 2]], "one place"),
        ([[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 1, 2]], "line"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "finite"),
    ],
)
def test_objects_without_a_hull(vertices, triangles, message):
    with pytest.raises(ValueError, match=message):
        finish(bake_field(Occluders(*plate()), np.array(vertices, float), np.array(triangles)))


def test_settings_out_of_range():
    for options in ({"resolution": 4}, {"resolution": 65}, {"samples": 1}, {"radii": 2}):
        with pytest.raises(ValueError, match="resolution"):
            baked(plate(), **options)


def test_progress_rises_and_closing_is_safe():
    mesh = SHAPES["cube"]()
    done = list(bake_field(Occluders(*mesh), *mesh, resolution=8, samples=16))
    assert done == sorted(done) and done[0] == 0.0 and done[-1] <= 1.0
    work = bake_field(Occluders(*mesh), *mesh, resolution=8, samples=64)
    next(work)
    next(work)
    work.close()
