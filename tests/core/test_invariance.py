# SPDX-License-Identifier: GPL-3.0-or-later
"""The same shape gives the same occlusion wherever it stands, whatever its size, however many threads trace it."""

import numpy as np
import pytest

from core.visibility import RAYS_PER_BLOCK

from .shapes import bumpy, vertex_normals
from .tracing import see

VERTICES, TRIANGLES = bumpy()
NORMALS = vertex_normals(VERTICES, TRIANGLES)
EXTENT = 2.0


def bumpy_f0(vertices=VERTICES, normals=NORMALS, extent=EXTENT, **options):
    return see((vertices, TRIANGLES), vertices, normals, samples=256, extent=extent, **options)


def same_but_for_noise(f0, reference):
    difference = f0 - reference
    print(f"rms {np.sqrt(np.mean(difference**2)):.4f}, worst {np.abs(difference).max():.4f}")
    return np.sqrt(np.mean(difference**2)) < 0.01 and np.abs(difference).max() < 0.1


def rotation(axis, angle):
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


@pytest.mark.parametrize("offset", [(1e5, 0, 0), (-1e5, 1e5, 1e5)])
def test_far_from_the_origin(offset):
    assert same_but_for_noise(bumpy_f0(VERTICES + offset).f0, bumpy_f0().f0)


@pytest.mark.parametrize("scale", [1e-3, 1e4])
def test_scaled(scale):
    assert same_but_for_noise(bumpy_f0(scale * VERTICES, extent=scale * EXTENT).f0, bumpy_f0().f0)


def test_rotated():
    turn = rotation((1, 2, 3), 1.1)
    seen = bumpy_f0(VERTICES @ turn.T, NORMALS @ turn.T)
    reference = bumpy_f0()
    assert same_but_for_noise(seen.f0, reference.f0)
    # the bent direction turns with it
    assert np.sqrt(np.mean((seen.bent @ turn - reference.bent) ** 2)) < 0.02


def test_a_small_thing_in_a_wide_landscape_keeps_its_contacts():
    """The ray offset follows the baked object, not the scene: two metres of surface on two kilometres of land."""

    def on_land(half):
        land = np.array([[-half, -half, -1.0], [half, -half, -1.0], [half, half, -1.0], [-half, half, -1.0]])
        triangles = np.concatenate((TRIANGLES, len(VERTICES) + np.array([[0, 1, 2], [0, 2, 3]])))
        return see((np.concatenate((VERTICES, land)), triangles), VERTICES, NORMALS, samples=256, extent=EXTENT).f0

    assert same_but_for_noise(on_land(1000.0), on_land(100.0))


def test_threads_do_not_change_a_bit():
    results = [bumpy_f0(threads=threads, seed=3) for threads in (1, 2, 7)]
    assert len(VERTICES) * 256 > 7 * RAYS_PER_BLOCK, "too small: every thread must have work"
    for seen in results[1:]:
        for channel in ("f0", "alpha", "bent"):
            assert getattr(seen, channel).tobytes() == getattr(results[0], channel).tobytes()
    assert bumpy_f0(seed=4).f0.tobytes() != results[0].f0.tobytes()
