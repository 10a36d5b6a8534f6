# SPDX-License-Identifier: GPL-3.0-or-later
"""The channels of a bake: against integral equations that are solved without a ray, and against sixty bounces."""

import numpy as np
import pytest

from core.height_map import HeightMap
from core.multibounce import equal_neighbours, irradiance, irradiance_from_bounces, jimenez_2016
from core.rays import Obscurance
from core.sample_points import spread_points

from . import path_tracing
from .endless_strips import EndlessStrips, rms, strip
from .height_fields import waves
from .shapes import box, bumpy, join, plate, quad, sphere, vertex_normals
from .test_simulation import PLATES, TRENCH, corner_table
from .tracing import baked, see


def spread(mesh, count):
    points = spread_points(corner_table(*mesh), count)
    return points.positions, points.normals


@pytest.mark.parametrize("open_fraction", [0.5, 0.25])
def test_spherical_pit(open_fraction):
    """F_n = f (1 - f)^n, and every bounce is 1 - f of the one before."""
    vertices, triangles = sphere(rings=96)
    rim = np.arccos(1.0 - 2.0 * open_fraction)
    pit = vertices, triangles[vertices[triangles].mean(axis=1)[:, 2] < np.cos(rim)][:, ::-1]
    # Its rim is a zigzag of whole triangles: the open part is what is missing of the sphere's area.
    area = [0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() for a, b, c in
            (np.moveaxis(vertices[faces], 1, 0) for faces in (triangles, pit[1]))]  # fmt: skip
    f = 1.0 - area[1] / area[0]
    used = np.unique(pit[1])
    channels = baked(pit, vertices[used], -vertices[used], 512, 2.0)
    expected = (f, f * (1.0 - f), f * (1.0 - f) ** 2, 1.0 - f)
    for name, channel, truth in zip(("F0", "F1", "F2", "T"), channels.T, expected, strict=True):
        print(f"pit of f = {f:.3f}: {name} rms {rms(channel - truth):.4f}, bias {channel.mean() - truth:+.5f}")
    for channel, truth in zip(channels.T[:3], expected, strict=False):
        assert rms(channel - truth) < 0.02 and abs(channel.mean() - truth) < 0.006


@pytest.mark.parametrize(("segments", "name"), [(TRENCH, "trench"), (PLATES, "plates")])
def test_endless_strips(segments, name):
    """A trench of square section, and two plates that face each other."""
    truth, mesh = EndlessStrips(segments), join(*(strip(*segment) for segment in segments))
    corners = spread(mesh, 60000)
    near = np.abs(corners[0][:, 1]) < 0.1 * 60.0
    positions, normals = (each[near] for each in corners)
    channels = baked(mesh, positions, normals, 512)
    for segment in range(len(segments)):
        expected, on = truth.at(segment, positions, 80)
        errors = [rms(channels[on, order] - expected[order]) for order in range(3)]
        total = irradiance_from_bounces(*channels[on].T, 0.8) - 0.8 ** np.arange(81) @ expected
        print(f"{name}, strip {segment}: rms of F0 to F2", *(f"{each:.4f}" for each in errors), f"E {rms(total):.4f}")
        assert on.sum() > 500 and max(errors) < 0.01 and rms(total) < 0.01


def height_map(heights, amplitude):
    tiles, points = HeightMap(heights, amplitude), HeightMap(heights, amplitude).points()
    occluders = tiles.occluders()
    mesh = occluders.vertices / occluders.scale + occluders.centre, occluders.triangles
    return mesh, points.positions, points.normals, 1.0


def mounds():
    """Steep knolls with narrow gaps, all different."""
    random, (x, y) = np.random.default_rng(5), np.meshgrid(*2 * [np.arange(96) / 96])
    heights = np.zeros((96, 96))
    for at_x, at_y, size in random.uniform((0, 0, 0.04), (1, 1, 0.12), (60, 3)):
        dx, dy = np.abs(x - at_x), np.abs(y - at_y)
        away = np.hypot(np.minimum(dx, 1 - dx), np.minimum(dy, 1 - dy))
        heights = np.maximum(heights, np.sqrt(np.maximum(0.0, size**2 - away**2)))
    return height_map(heights, 0.1)


def interior():
    """A room that a window lights, with a closed chest in it: its inside sees no light at all."""
    ring = [quad((1, -1, z0), (1, 1, z0), (1, 1, z1), (1, -1, z1)) for z0, z1 in ((-1, -0.4), (0.4, 1))]
    ring += [quad((1, y0, -0.4), (1, y1, -0.4), (1, y1, 0.4), (1, y0, 0.4)) for y0, y1 in ((-1, -0.4), (0.4, 1))]
    corners, faces = box()
    walls = corners, np.delete(faces, (2, 3), axis=0)[:, ::-1]
    chest = box(0.35)[0] - (0.4, 0.3, 0.649), box()[1]
    inside = chest[0], chest[1][:, ::-1]
    mesh = join(walls, chest, *((points, triangles[:, ::-1]) for points, triangles in ring))
    within = [spread(walls, 8000), spread(chest, 1500), spread(inside, 500)]
    return mesh, *(np.concatenate(each) for each in zip(*within, strict=True)), 2.0


def folded_ball():
    vertices, triangles = sphere(rings=64)
    vertices = vertices * (1.0 + 0.35 * np.sin(7.0 * vertices + 1.0).prod(axis=1)[:, None])
    return (vertices, triangles), vertices, vertex_normals(vertices, triangles), 2.7


def sheet():
    mesh = bumpy()
    return mesh, mesh[0], vertex_normals(*mesh), 2.0


SCENES = {"waves": lambda: height_map(waves(96), 0.2), "mounds": mounds, "interior": interior,
          "folded ball": folded_ball, "sheet": sheet}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_against_sixty_bounces(name):
    """E/E0 from the four channels at any albedo, and what curves of one AO value make of the same points."""
    mesh, points, normals, extent = SCENES[name]()
    channels = baked(mesh, points, normals, 1024, extent)
    alpha = see(mesh, points, normals, 1024, extent).alpha
    some = np.random.default_rng(0).permutation(len(points))[:250]
    truth = path_tracing.bounces(mesh, points[some], normals[some], 2048, extent=extent)
    k_a = channels[some, 0]
    for albedo, limit in ((0.5, 0.003), (0.8, 0.010), (0.95, 0.04)):
        total = np.einsum("b,hbn->hn", albedo ** np.arange(truth.shape[1]), truth)
        errors = {
            "baked": irradiance_from_bounces(*channels[some].T, albedo),
            "published fit": irradiance(alpha[some], albedo),
            "Jimenez 2016": jimenez_2016(k_a, albedo),
            "k_A/(1 - rho (1 - k_A))": equal_neighbours(k_a, albedo),
        }
        errors = {who: path_tracing.rms(values, total) for who, values in errors.items()}
        print(f"{name}, albedo {albedo}: rms", ", ".join(f"{who} {error:.4f}" for who, error in errors.items()))
        assert errors["baked"] < limit
        assert errors["baked"] < min(errors.values()) + 1e-9


def test_floor_without_end_lights_what_stands_over_it():
    """A plate that faces an endless white floor at height h sees it wholly: F0 = 0, and F1 is what the floor sees."""
    mesh = plate(1.0, 1.0)[0], plate()[1][:, ::-1]
    points, normals = spread(mesh, 3000)
    channels = baked(mesh, points, normals, 512, 2.0, ground_height=0.0)
    floor = join(mesh, plate(300.0))
    truth = path_tracing.bounces(floor, points[::10], normals[::10], 4096, extent=2.0, last=2)
    assert (channels[:, 0] == 0.0).all()
    errors = [path_tracing.rms(channels[::10, order], truth[:, order]) for order in (1, 2)]
    print("under a plate over a floor without end: rms of F1, F2", *(f"{error:.4f}" for error in errors))
    assert max(errors) < 0.006


def test_albedo_zero_is_f0_exactly():
    mesh, points, normals, extent = sheet()
    channels = baked(mesh, points[::7], normals[::7], 64, extent)
    assert (irradiance_from_bounces(*channels.T, 0.0) == channels[:, 0]).all()
    assert (channels >= 0.0).all() and (channels[:, 3] < 1.0).all()
    assert (channels[:, :3].sum(axis=1) <= 1.0 + 1e-6).all()


def test_only_what_counts_as_a_blocker_sends_light():
    """Past max_distance nothing blocks, so nothing is sent back either."""
    trench = join(*(strip(*segment) for segment in TRENCH))
    points, normals = np.array([(0.5, 0.0, 0.0)]), np.array([(0.0, 0.0, 1.0)])
    near = baked(trench, points, normals, 64, obscurance=Obscurance(0.3))
    np.testing.assert_allclose(near, [(1.0, 0.0, 0.0, 0.0)], atol=1e-6)


def test_same_bits_whatever_the_threads():
    mesh, points, normals, extent = sheet()
    one, many, other = (
        baked(mesh, points[::5], normals[::5], 64, extent, threads=threads, seed=seed)
        for threads, seed in ((1, 0), (5, 0), (2, 1))
    )
    assert one.tobytes() == many.tobytes() and one.tobytes() != other.tobytes()


def test_nothing_around():
    """An open plate; and no triangle at all."""
    mesh = plate()
    points, normals = spread(mesh, 50)
    for blockers in (mesh, (np.empty((0, 3)), np.empty((0, 3), int))):
        assert (baked(blockers, points, normals, 16, 2.0) == (1.0, 0.0, 0.0, 0.0)).all()
