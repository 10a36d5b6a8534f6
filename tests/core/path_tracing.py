# SPDX-License-Identifier: GPL-3.0-or-later
"""Truth for bounces: paths between surfaces under a white sky, which share only Embree with what they judge.

F_n is the part of the cosine-weighted paths from a point that reach the sky after n bounces, off white surfaces: no
cache, no weights, no bias, whatever the scene. Off coloured ones each path brings the product of their colours.
"""

import os
from concurrent.futures import ThreadPoolExecutor

import numpy as np

POINTS_PER_CHUNK = 32
OFF = 1e-5  # of the extent, off the surface


def bounces(mesh, points, normals, paths, *, extent, last=60, colours=None, seed=0):
    """Two independent estimates (2, last + 1, n, channels) of F_0 ... F_last at ``points`` against ``mesh``, whose
    triangles have ``colours`` (m, channels); without these (2, last + 1, n) off white."""
    if colours is None:
        return bounces(mesh, points, normals, paths, extent=extent, last=last, colours=np.ones((len(mesh[1]), 1)),
                       seed=seed)[..., 0]  # fmt: skip
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    scene = EmbreeScene(robust=True)
    vertices, triangles = mesh
    keep = TriangleMesh(scene, np.asarray(vertices, np.float32), np.asarray(triangles, np.int32))
    chunks = [slice(start, start + POINTS_PER_CHUNK) for start in range(0, len(points), POINTS_PER_CHUNK)]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        halves = [
            pool.map(lambda part, half=half: _chunk(scene, points[part], normals[part], paths, extent, last, colours,
                                                    np.random.default_rng((seed, half, part.start))), chunks)
            for half in (0, 1)
        ]  # fmt: skip
        result = np.stack([np.concatenate(list(half), axis=1) for half in halves])
    del keep
    return result


def _chunk(scene, points, normals, paths, extent, last, colours, random):
    owner = np.repeat(np.arange(len(points)), paths)
    # The first directions in strata of the disk's radius; all else is independent.
    squared = (np.tile(np.arange(paths), len(points)) + random.random(len(owner))) / paths
    position, normal = points[owner], normals[owner]
    brought = np.ones((len(owner), colours.shape[1]))
    result = np.zeros((last + 1, len(points), colours.shape[1]))
    for bounce in range(last + 1):
        direction = _cosine(normal, squared, random)
        start = (position + OFF * extent * normal).astype(np.float32)
        hit = scene.run(start, direction, query="INTERSECT", output=True)
        met = hit["primID"] >= 0
        for channel, part in enumerate(brought[~met].T):
            result[bounce, :, channel] = np.bincount(owner[~met], part, len(points))
        if not met.any():
            break
        brought = brought[met] * colours[hit["primID"][met]]
        owner, facing = owner[met], hit["Ng"][met].astype(np.float64)
        position = start[met] + hit["tfar"][met, None] * direction[met].astype(np.float64)
        facing /= np.linalg.norm(facing, axis=1, keepdims=True)
        normal = facing * -np.sign((facing * direction[met]).sum(axis=1, keepdims=True))
        squared = random.random(len(owner))
    return result / paths


def _cosine(normals, squared, random):
    """Directions (r, 3) float32 about ``normals`` (r, 3): Malley's method with the disk's radius^2 ``squared``."""
    helper = np.where(np.abs(normals[:, :1]) < 0.7, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    x = np.cross(helper, normals)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(normals, x)
    azimuth, radius = 2.0 * np.pi * random.random(len(normals)), np.sqrt(squared)
    across = radius * np.cos(azimuth), radius * np.sin(azimuth)
    direction = across[0][:, None] * x + across[1][:, None] * y + np.sqrt(1.0 - squared)[:, None] * normals
    return direction.astype(np.float32)


def rms(values, truth):
    """rms error of ``values`` (n,) against two independent estimates ``truth`` (2, n), without their own noise."""
    return float(np.sqrt(max(0.0, np.mean((values - truth[0]) * (values - truth[1])))))
