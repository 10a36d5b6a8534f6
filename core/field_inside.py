# SPDX-License-Identifier: GPL-3.0-or-later
"""What receivers see within an object's convex hull: the constants A0 and p of its field, and the volume.

The free space in there, under a table or in a cup, has no radial function. The notes (3. "Inside the Convex Hull")
blend from the hull's occlusion to a constant A0 at the centre, t = (r / r0)^p; here both are the best for receivers
of random normals spread evenly over the free space.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from .ao_field import AOField, FieldVolume
from .field_hull import Hull
from .field_rays import seen_around
from .rays import Occluders
from .surface import unit
from .workers import Workers, mapped

PLACES = 4096
# Nodes of the volume along each side.
NODES = 16
# Powers that are tried: from a hull's occlusion that reaches deep inside to one that ends at the hull.
POWERS = np.geomspace(1.0 / 16.0, 64.0, 81)


def fit_inside(
    field: AOField, occluders: Occluders, hull: Hull, samples: int, volume: bool, seed: int, workers: Workers
) -> Generator[float, None, AOField]:
    """``field`` with A0, p and, if ``volume``, its volume; yields the fraction done.

    A hull without free space, that of a convex body, keeps the field's own.
    """
    places = hull.centre + hull.places_inside(PLACES, seed)
    normals = unit(np.random.default_rng((seed, 1)).normal(size=(PLACES, 3)))
    share = 0.5 if volume else 1.0
    tracing = seen_around(occluders, places, normals, samples, seed, workers)
    seen = yield from mapped(tracing, lambda done: share * done)
    free = ~seen.solid
    if not free.any():
        return field
    places, normals, A = places[free], normals[free], seen.A[free]
    ratio, A_hull = _at_hull(field, places, normals)
    t = ratio ** POWERS[:, None]
    # The best A0 of each power is a linear least squares problem.
    least = np.maximum(np.square(1.0 - t).sum(axis=1), 1e-12)
    A0 = np.clip(((1.0 - t) * (A - t * A_hull)).sum(axis=1) / least, 0.0, 1.0)
    best = _best(A, t, A_hull, A0[:, None])
    field = replace(field, a0=float(A0[best]), p=float(POWERS[best]))
    if not volume:
        return field
    made = yield from mapped(_volume(occluders, hull, samples, seed, workers), lambda done: share + share * done)
    inside = replace(field, volume=made).volume_caps(places).occlusion(normals)
    return replace(field, volume=replace(made, p=float(POWERS[_best(A, t, A_hull, inside)])))


def _at_hull(field: AOField, places: NDArray, normals: NDArray) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """r / r0 (k,) and the occlusion (k,) at r0 of ``places`` (k, 3) with ``normals`` (k, 3)."""
    return field.ratio(places), field.caps(places).occlusion(normals)


def _best(A: NDArray, t: NDArray, A_hull: NDArray, A_inside: NDArray) -> int:
    """Which row of ``t`` (m, k) comes nearest to ``A`` (k,) in the blend of the other two."""
    return int(np.square(t * A_hull + (1.0 - t) * A_inside - A).sum(axis=1).argmin())


def _volume(
    occluders: Occluders, hull: Hull, samples: int, seed: int, workers: Workers
) -> Generator[float, None, FieldVolume]:
    """M and Omega at NODES^3 places over the hull's box; inside something solid, those of the nearest free node."""
    from scipy.ndimage import distance_transform_edt

    low, high = hull.box
    axes = [np.linspace(*ends, NODES) for ends in zip(low, high, strict=True)]
    places = hull.centre + np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    normals = np.tile((0.0, 0.0, 1.0), (len(places), 1))
    seen = yield from seen_around(occluders, places, normals, samples, seed + 1, workers)
    solid = seen.solid.reshape(NODES, NODES, NODES)
    values = np.column_stack((seen.M, seen.Omega)).reshape(*solid.shape, 4)
    if not solid.all():
        spacing = (high - low) / (NODES - 1)
        nearest = distance_transform_edt(solid, spacing, return_distances=False, return_indices=True)
        values = values[tuple(nearest)]
    return FieldVolume(values.astype(np.float16).astype(np.float64), low, high, 1.0)
