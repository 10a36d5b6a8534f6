# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the ambient occlusion field of an object: rays from around it, functions fitted to what they meet."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from .ao_field import AOField
from .cap import cap_of_moment
from .cubemap import nodes
from .field_fit import fit_direction, fit_solid_angle
from .field_hull import Hull
from .field_inside import fit_inside
from .field_rays import seen_in_cones
from .rays import Occluders
from .workers import Workers, mapped, slices

# The first radius lies this part of r0 outside the hull. From there to r_far the distance to the hull grows by equal
# factors. (Equal factors of r itself would leave one radius where a receiver is in contact.)
CLEARANCE = 0.006
# The shadow fades out between these distances, in radii of the object.
R_NEAR, R_FAR = 4.0, 8.0
# Standard deviation of the low-pass filter, in texels.
FILTER = 1.0 / 3.0
# Texels fitted at once: 40 MB a thread.
TEXELS_PER_PART = 512


def bake_field(
    occluders: Occluders,
    vertices: NDArray,
    triangles: NDArray,
    *,
    resolution: int = 16,
    samples: int = 512,
    radii: int = 8,
    low_pass: bool = True,
    volume: bool = False,
    seed: int = 0,
    threads: int | None = None,
) -> Generator[float, None, AOField]:
    """The field of the object whose ``vertices`` (n, 3) and ``triangles`` (m, 3) ``occluders`` was made from, in the
    object's space; yields the fraction done.

    resolution  texels along a side of the cubemaps' faces, 8 to 64
    samples     rays a texel and radius, 4 or more
    radii       distances at which each direction is measured, 4 or more
    low_pass    measure between the texels too, by as many rays in all, and fit each to what lies around it, weighted by
                a Gaussian (the notes, "Preprocess": filter before sampling, a map of twice the resolution). r0 is
                never filtered
    volume      measure 16^3 places in the convex hull too, in place of A0
    seed        turns the rays; equal seeds give equal bits, whatever the number of threads
    threads     default: one a core

    Raises ValueError for settings out of range and for objects that have no hull (:meth:`core.field_hull.Hull.of`).
    Memory: about 0.3 kB a texel and radius, and 40 MB a thread. Closing the generator stops after the blocks in flight.
    """
    if not (8 <= resolution <= 64 and samples >= 4 and radii >= 4):
        raise ValueError(
            f"an AO field needs a resolution of 8 to 64, not {resolution}, 4 samples or more, not {samples}, and "
            f"4 radii or more, not {radii}"
        )
    yield 0.0
    hull = Hull.of(vertices, triangles)
    omega, texel = nodes(resolution)
    # Where it is measured: twice as dense, the texels among them. A quarter of the rays each is as many in all.
    at, rays = (nodes(2 * resolution - 1)[0], samples // 4) if low_pass else (omega, samples)
    around, weight = _neighbours(omega, at, resolution)
    with Workers(threads) as workers:
        r0, facing = yield from mapped(hull.distances(at, workers), lambda done: 0.05 * done)
        r = _radii(r0, R_FAR * hull.radius, radii)
        tracing = seen_in_cones(occluders, *_cones(hull, at, facing, r), rays, seed, workers)
        seen = yield from mapped(tracing, lambda done: 0.05 + 0.6 * done)
        Omega, M = seen.Omega.reshape(r.shape), seen.M.reshape(*r.shape, 3)
        length = np.linalg.norm(M, axis=-1)
        Omega_M = cap_of_moment(length)
        Upsilon = M / np.maximum(length, np.finfo(np.float64).tiny)[..., None]
        r0_texel = r0[around[:, 0]]
        r_min = _least_around(r0_texel, texel)

        def fit(part: slice) -> NDArray[np.float64]:
            near, r0_part = around[part], r0_texel[part]
            shape = len(near), -1
            # The same distance in hulls, not metres: beside an edge of the hull clearance matters, not r.
            r_here = (r[near] * (r0_part[:, None] / r0[near])[..., None]).reshape(shape)
            w = np.broadcast_to(weight[part, :, None], (*near.shape, radii)).reshape(shape)
            near_Omega, near_Omega_M, near_length = (each[near].reshape(shape) for each in (Omega, Omega_M, length))
            # Beyond the object's sphere an error weighs by the distance: more of a floor lies there.
            w_far = w * np.maximum(r_here / hull.radius, 1.0)
            a, b, c, d = fit_solid_angle(r_here, near_Omega, w_far, r0_part, r_min[part])
            abc_m = fit_solid_angle(r_here, near_Omega_M, w_far, r0_part, r_min[part], d)[:3]
            # An error of the direction weighs by what is blocked there, |M|. Its square would let contact alone decide.
            near_Upsilon = Upsilon[near].reshape(*r_here.shape, 3)
            c0, e = fit_direction(r_here, near_Upsilon, w * near_length, omega[part], r0_part)
            # Eleven bits of e are enough, and make smaller files.
            return np.column_stack((a, b, c, d, r0_part, *abc_m, e.astype(np.float16), c0))

        parts = slices(len(omega), TEXELS_PER_PART)
        fitted = yield from mapped(workers.mapping(fit, parts), lambda done: 0.65 + 0.15 * done)
        maps = np.concatenate(fitted).astype(np.float32).astype(np.float64)[texel]
        a, b, c, d, r0_map, a_m, b_m, c_m, e = np.moveaxis(maps[..., :9], -1, 0).copy()
        field = AOField(
            **{"centre": hull.centre, "radius": hull.radius},
            **{"r_near": R_NEAR * hull.radius, "r_far": R_FAR * hull.radius},
            **{"a": a, "b": b, "c": c, "d": d, "r0": r0_map, "a_m": a_m, "b_m": b_m, "c_m": c_m},
            **{"c0": maps[..., 9:].copy(), "e": e},
            # Inside a convex body everything is blocked.
            **{"a0": 1.0, "p": 1.0},
        )
        inside = fit_inside(field, occluders, hull, samples, volume, seed, workers)
        return (yield from mapped(inside, lambda done: 0.8 + 0.2 * done))


def _neighbours(omega: NDArray, at: NDArray, resolution: int) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """For each texel, along ``omega`` (k, 3), the places of ``at`` (l, 3) that it is fitted to, (k, 9), itself first,
    and their weights (k, 9); itself alone, (k, 1), where the places are the texels."""
    if len(at) == len(omega):
        return np.arange(len(omega))[:, None], np.ones((len(omega), 1))
    from scipy.spatial import cKDTree

    on_cube, at_cube = (each / np.abs(each).max(axis=1, keepdims=True) for each in (omega, at))
    distance, around = cKDTree(at_cube).query(on_cube, k=9)
    return around, np.exp(-0.5 * np.square(distance * (resolution - 1) / 2.0 / FILTER))


def _radii(r0: NDArray[np.float64], r_far: float, count: int) -> NDArray[np.float64]:
    """Distances (k, count) from the centre, along directions in which the hull ends at ``r0`` (k,), to ``r_far``."""
    first, last = np.full_like(r0, CLEARANCE), r_far / r0 - 1.0
    return r0[:, None] * (1.0 + np.geomspace(first, last, count, axis=1))


def _cones(
    hull: Hull, omega: NDArray, facing: NDArray, r: NDArray
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Positions (k N, 3), axes (k N, 3) and cosines of half angles (k N,) of cones that hold the object, seen from
    distances ``r`` (k, N) along ``omega`` (k, 3), where the hull's plane has the normal ``facing`` (k, 3).

    Outside its bounding sphere that sphere's cone; nearer, the half space behind the hull's plane.
    """
    positions = hull.centre + r[..., None] * omega[:, None]
    sine = np.minimum(hull.radius / r, 1.0)
    cosines = np.sqrt(1.0 - sine * sine)
    axes = np.where((sine < 1.0)[..., None], -omega[:, None], -facing[:, None])
    return positions.reshape(-1, 3), axes.reshape(-1, 3), cosines.reshape(-1)


def _least_around(r0: NDArray[np.float64], texel: NDArray[np.intp]) -> NDArray[np.float64]:
    """The least of ``r0`` (k,) among each texel and those that share a cell of the bilinear lookup with it, (k,).

    ``texel`` (6, n, n) says where they lie; what shares an edge or a corner of the cube has cells on two or three
    faces.
    """
    lowest = r0[texel]
    cells = np.min([lowest[:, i : i - 1 or None, j : j - 1 or None] for i in (0, 1) for j in (0, 1)], axis=0)
    result = r0.copy()
    for i in (0, 1):
        for j in (0, 1):
            np.minimum.at(result, texel[:, i : i - 1 or None, j : j - 1 or None], cells)
    return result
