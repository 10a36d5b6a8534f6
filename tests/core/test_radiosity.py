# SPDX-License-Identifier: GPL-3.0-or-later
"""Light in three colours off coloured surfaces: against a closed form, and against paths."""

import numpy as np
import pytest

from core.albedo import Albedo, Constants, Texture, TextureColours
from core.channels import radiosity
from core.light_cache import build_light_cache
from core.rays import Occluders
from core.sample_points import SurfacePoints
from core.sampling import hemisphere_pattern
from core.visibility import trace_visibility

from . import path_tracing
from .endless_strips import rms
from .shapes import box, join, quad, sphere
from .test_measured_bounces import spread
from .tracing import finish


def lit(mesh, albedo, points, normals, samples=512, extent=2.0, ground_height=None):
    """``Multibounce Radiosity`` (n, 4)."""
    occluders, points = Occluders(*mesh, ground_height), SurfacePoints(points, normals)
    cache = finish(build_light_cache(occluders, points, len(points) * samples, extent=extent, albedo=albedo))
    seen = trace_visibility(occluders, points, hemisphere_pattern(samples), extent=extent, cache=cache)
    return radiosity(finish(seen)).astype(float)


def painted(colours):
    """One colour a triangle."""
    return Albedo([Constants(np.asarray(colours, float))], np.arange(len(colours)))


def test_spherical_pit_of_one_colour():
    """E = f / (1 - rho (1 - f)) in each channel, at every point."""
    vertices, triangles = sphere(rings=96)
    faces = vertices[triangles].mean(axis=1)[:, 2] < 0.5
    pit = vertices, triangles[faces][:, ::-1]
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    f, rho = 1.0 - area[faces].sum() / area.sum(), np.array([0.9, 0.5, 0.1])
    used = np.unique(pit[1])
    channels = lit(pit, painted(np.tile(rho, (len(pit[1]), 1))), vertices[used], -vertices[used])
    for name, values, albedo in zip("RGB", channels.T, rho, strict=False):
        error = values - f / (1.0 - albedo * (1.0 - f))
        print(f"pit of f = {f:.3f}, {name}, albedo {albedo}: rms {rms(error):.4f}, bias {error.mean():+.5f}")
        assert rms(error) < 0.01 and abs(error.mean()) < 0.003


def coloured_room():
    """Open towards +x; a red, a green and grey walls, an ochre floor, and a box in it."""
    corners, faces = box()
    walls = corners, np.delete(faces, (2, 3), axis=0)[:, ::-1]
    block = box(0.35)[0] - (0.2, 0.2, 0.64), box()[1]
    by_normal = {(1, 0, 0): (0.7, 0.7, 0.7), (0, 1, 0): (0.8, 0.05, 0.05), (0, -1, 0): (0.1, 0.7, 0.1),
                 (0, 0, 1): (0.7, 0.5, 0.2), (0, 0, -1): (0.8, 0.8, 0.8)}  # fmt: skip
    a, b, c = np.moveaxis(walls[0][walls[1]], 1, 0)
    normals = np.rint(np.cross(b - a, c - a) / 4).astype(int)
    colours = [by_normal[tuple(normal)] for normal in normals] + 12 * [(0.3, 0.4, 0.8)]
    return join(walls, block), np.array(colours)


def test_room_of_coloured_walls():
    mesh, colours = coloured_room()
    points, normals = spread(mesh, 6000)
    channels = lit(mesh, painted(colours), points, normals, 1024)
    some = slice(None, None, 20)
    truth = path_tracing.bounces(mesh, points[some], normals[some], 2048, extent=2.0, colours=colours).sum(axis=1)
    for channel, name in enumerate("RGB"):
        error = path_tracing.rms(channels[some, channel], truth[..., channel])
        white = path_tracing.rms(channels[some, 3], truth[..., channel])
        print(f"room, {name}: rms {error:.4f}, of no bounces {white:.4f}")
        assert error < 0.006


def test_colour_comes_from_where_the_image_has_it():
    """A wall of two triangles whose image is red below and black above, an endless floor's point before it: the red
    half alone sends light. Under a white sky the wall sees a half of it, so that the light is half the wall's form
    factor: (cos a - cos b) / 4 between elevations a and b, less what the floor does not send, being black."""
    far = 1000.0
    wall = quad((1, far, 0), (1, -far, 0), (1, -far, 2), (1, far, 2))
    uv = np.array([[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]], np.float32)
    pixels = np.zeros((2, 1, 3), np.float32)
    pixels[0, 0] = (1.0, 0.0, 0.0)
    source = TextureColours(Texture(pixels, "EXTEND", is_closest=True), uv)
    albedo = Albedo([source], np.arange(2), ground=(0.0, 0.0, 0.0))
    points, normals = np.zeros((64, 3)), np.tile((0.0, 0.0, 1.0), (64, 1))
    channels = lit(wall, albedo, points, normals, 1024, ground_height=0.0)
    low, middle, high = 0.0, np.arctan(1.0), np.arctan(2.0)
    sky = 0.5 * (1.0 + np.cos(high))
    red = 0.5 * 0.5 * (np.cos(low) - np.cos(middle))
    print(f"image of a wall: F0 off {channels[:, 3].mean() - sky:+.4f}, red {channels[:, 0].mean() - sky - red:+.4f}")
    assert abs(channels[:, 3].mean() - sky) < 0.002
    assert channels[:, 0].mean() - sky == pytest.approx(red, abs=0.002)
    np.testing.assert_array_equal(channels[:, 1:3], channels[:, [3, 3]])


def test_black_surfaces_send_nothing_and_white_ones_what_a_closed_room_keeps():
    mesh, _ = coloured_room()
    points, normals = spread(mesh, 500)
    black = lit(mesh, painted(np.zeros((len(mesh[1]), 3))), points, normals, 64)
    np.testing.assert_array_equal(black[:, :3], black[:, [3, 3, 3]])
    closed = box()[0], box()[1][:, ::-1]
    points, normals = spread(closed, 100)
    assert (lit(closed, painted(np.ones((12, 3))), points, normals, 16) == 0.0).all()
