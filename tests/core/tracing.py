# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the ray loop to its end."""

import numpy as np

from core.channels import measured_bounces
from core.light_cache import build_light_cache
from core.rays import Occluders
from core.sample_points import SurfacePoints
from core.sampling import hemisphere_pattern
from core.visibility import trace_visibility


def finish(generator):
    """The generator's result."""
    while True:
        try:
            next(generator)
        except StopIteration as stopped:
            return stopped.value


def see(mesh, points, normals, samples=1024, extent=1.0, ground_height=None, **options):
    """Visibility of ``points`` against ``mesh`` (vertices, triangles)."""
    points = np.atleast_2d(np.asarray(points, float))
    normals = np.broadcast_to(np.asarray(normals, float), points.shape)
    occluders, points = Occluders(*mesh, ground_height), SurfacePoints(points, normals)
    return finish(trace_visibility(occluders, points, hemisphere_pattern(samples), extent=extent, **options))


def baked(mesh, points, normals, samples=1024, extent=1.0, ground_height=None, **options):
    """The channels (n, 4), F0, F1, F2 and T, of ``points`` as a bake measures them."""
    occluders, points = Occluders(*mesh, ground_height), SurfacePoints(points, normals)
    options["extent"] = extent
    cache = finish(build_light_cache(occluders, points, len(points) * samples, **options))
    seen = finish(trace_visibility(occluders, points, hemisphere_pattern(samples), cache=cache, **options))
    return measured_bounces(seen).astype(float)
