# SPDX-License-Identifier: GPL-3.0-or-later
"""The ambient occlusion field of Blender's monkey against rays, as tests/core/test_ao_field.py has it of others."""

import bpy
import numpy as np

from core.field_bake import bake_field
from core.field_hull import Hull
from core.rays import Occluders
from core.sample_points import SurfacePoints
from core.sampling import hemisphere_pattern
from core.visibility import trace_visibility
from core.workers import Workers


def finish(work):
    while True:
        try:
            next(work)
        except StopIteration as finished:
            return finished.value


def test_receivers_around_suzanne(empty_scene):
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.active_object.data
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    vertices, triangles = vertices.reshape(-1, 3).astype(float), triangles.reshape(-1, 3)

    hull, occluders = Hull.of(vertices, triangles), Occluders(vertices, triangles)
    random = np.random.default_rng(1)
    omega, normals = random.normal(size=(2, 3000, 3))
    omega, normals = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (omega, normals))
    with Workers(1) as workers:
        r0, _ = finish(hull.distances(omega, workers))
    clearance = np.exp(random.uniform(np.log(0.01), np.log(3.0), 3000))
    positions = hull.centre + (r0 * (1.0 + clearance))[:, None] * omega

    points = SurfacePoints(positions, normals)
    truth = 1.0 - finish(trace_visibility(occluders, points, hemisphere_pattern(4096), extent=1.0)).f0.astype(float)
    field = finish(bake_field(occluders, vertices, triangles))
    error, plain = (
        float(np.sqrt(np.mean(np.square(field.occlusion(positions, normals, plain_cap=each) - truth))))
        for each in (False, True)
    )
    print(f"Suzanne: rms of A {error:.4f}, by the plain cap {plain:.4f}; asked 0.021")
    assert error < 0.021
