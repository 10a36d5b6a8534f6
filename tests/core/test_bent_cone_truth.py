# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of the sky through bent cones against the same light by rays, 1024 each, under skies that are not white."""

import numpy as np
import pytest

from core import spherical_harmonics as sh
from core.bent_cone import sky_light
from core.rays import Obscurance, Occluders
from core.sampling import frames, hemisphere_pattern, turns

from .shapes import bumpy, join, plate, quad, sphere, vertex_normals
from .tracing import see

SAMPLES, FAR = 1024, 100.0


def on_the_floor(x_from, x_to, count=400):
    points = np.random.default_rng(0).uniform((x_from, -1, 0), (x_to, 1, 0), (count, 3))
    return points, np.tile((0.0, 0.0, 1.0), (count, 1))


def overhang():
    slab = quad((0, -FAR, 1), (0, FAR, 1), (FAR, FAR, 1), (FAR, -FAR, 1))
    return slab, *on_the_floor(-3, 3)


def wall():
    return quad((1, FAR, 0), (1, -FAR, 0), (1, -FAR, 2), (1, FAR, 2)), *on_the_floor(-3, 0.99)


def pit():
    points, triangles = sphere(rings=96)
    inside = np.random.default_rng(0).normal(size=(400, 3))
    inside /= np.linalg.norm(inside, axis=1, keepdims=True)
    inside[:, 2] = -np.abs(inside[:, 2])
    return (points, triangles[points[triangles][:, :, 2].max(axis=1) < 1e-9]), 0.999 * inside, -inside


def hills():
    vertices, triangles = bumpy()
    normals = vertex_normals(vertices, triangles)
    some = np.nonzero(np.abs(vertices[:, :2]).max(axis=1) < 0.9)[0][::10]
    return (vertices, triangles), vertices[some], normals[some]


def slab():
    """One of 4 x 4 at height 1, so that what is seen below it is a band along the horizon."""
    low, high = plate(2.0, 1.0), plate(2.0, 1.2)
    return join(low, high, plate(FAR)), *on_the_floor(-3, 3)


def lamp(azimuth, radius):
    """A bright disc, ``radius`` degrees from its middle to its edge, half-way up the sky of a dim room."""
    azimuth = np.radians(azimuth)
    towards = np.array((np.cos(azimuth), np.sin(azimuth), 1.0)) / np.sqrt(2.0)
    return lambda directions: np.where(directions @ towards > np.cos(np.radians(radius)), 4.0, 0.2)


def sunset(directions):
    """A sky that is bright on one side and dark on the other, over dark ground."""
    x, z = directions[..., 0], directions[..., 2]
    return np.where(z > 0, 0.3 + 1.5 * np.exp(-(1 + x) * 2 - z), 0.1)


SKIES = {
    "large window before": lamp(180, 40),
    "large window beside": lamp(90, 40),
    "large window behind": lamp(0, 40),
    "small window before": lamp(180, 20),
    "small window behind": lamp(0, 20),
    "sunset": sunset,
}


def traced(mesh, points, normals, sky):
    """(E/pi, the same without occluders), each (n,), by rays of their own."""
    pattern = hemisphere_pattern(SAMPLES, "cosine")
    turned = pattern.directions.astype(np.float32) @ frames(normals.T, turns(np.arange(len(points)), seed=7))
    light = sky(turned.astype(float))
    occluders = Occluders(*mesh)
    origins = occluders.origins(points.T, normals.T, 1.0).T.astype(np.float32)
    visible = np.empty(turned.shape[0] * SAMPLES)
    starts = np.repeat(origins, SAMPLES, axis=0)
    occluders.visibility(starts, turned.reshape(-1, 3), Obscurance(), out=visible)
    return (light * visible.reshape(len(points), -1)).mean(axis=1), light.mean(axis=1)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def compared(scene, sky):
    """rms errors of F0 times the unoccluded irradiance, which is traced too, and of the bent cone; printed beside that
    of traced light of the sky's nine coefficients, which is as near as those can come."""
    mesh, points, normals = scene()
    truth, unoccluded = traced(mesh, points, normals, SKIES[sky])
    seen = see(mesh, points, normals, SAMPLES)
    coefficients = sh.project_panorama(SKIES[sky](sh.equirectangular(128, 256)[0])[..., None])
    ours = sky_light(coefficients, seen.bent, seen.alpha, normals).irradiance[:, 0]
    band_limited, _ = traced(mesh, points, normals, lambda w: sh.evaluate(coefficients, w)[..., 0])
    plain, bent, least = (rms(each - truth) for each in (seen.f0 * unoccluded, ours, band_limited))
    print(
        f"{scene.__name__}, {sky}: rms {plain:.4f} by F0, {bent:.4f} by bent cone ({plain / bent:.1f} times less), "
        f"{least:.4f} by rays in the nine coefficients"
    )
    return plain, bent


@pytest.mark.parametrize("sky", ["large window before", "large window behind"])
@pytest.mark.parametrize("scene", [overhang, wall, pit, hills, slab])
def test_large_window(scene, sky):
    plain, bent = compared(scene, sky)
    assert plain / bent > 2.0


@pytest.mark.parametrize("sky", ["large window beside", "small window before", "small window behind", "sunset"])
@pytest.mark.parametrize("scene", [overhang, wall, pit, hills, slab])
def test_other_skies(scene, sky):
    """What is smaller than nine coefficients show is lost, with and without cones; the cones still help."""
    plain, bent = compared(scene, sky)
    assert plain / bent > 1.5
