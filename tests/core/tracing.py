# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the ray loop to its end."""

import numpy as np

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
