# SPDX-License-Identifier: GPL-3.0-or-later
"""Other programs' ray tracers on the same vertices, each with its tree built anew, where they are installed.

Import them after bpy: some bring an Embree that bpy would otherwise be linked to.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

RAYS_AT_ONCE = 2**24


def mitsuba(vertices, triangles, points, normals, samples) -> tuple[float, NDArray]:
    """Shadow rays of its independent sampler, cosine-warped, over points x samples at once on its LLVM backend."""
    import drjit as dr
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    started = time.perf_counter()
    mesh = mi.Mesh("mesh", len(vertices), len(triangles))
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = mi.Float(np.ascontiguousarray(vertices, np.float32).ravel())
    parameters["faces"] = mi.UInt32(np.ascontiguousarray(triangles, np.uint32).ravel())
    parameters.update()
    scene = mi.load_dict({"type": "scene", "mesh": mesh})
    extent = float(np.ptp(vertices, axis=0).max())
    step = max(1, RAYS_AT_ONCE // samples)
    result = []
    for seed, start in enumerate(range(0, len(points), step)):
        part = slice(start, start + step)
        count = len(points[part])
        # A point's rays stay together, where they share what is in the cache.
        index = dr.arange(mi.UInt32, count * samples) // samples
        normal = dr.gather(mi.Normal3f, mi.Normal3f(*normals[part].astype(np.float32).T), index)
        origin = dr.gather(mi.Point3f, mi.Point3f(*points[part].astype(np.float32).T), index)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, count * samples)
        # Malley's cosine warp written out: Mitsuba's own guards its root in a way that LLVM 15 cannot compile.
        u = sampler.next_1d()
        sin, cos = dr.sincos(2.0 * dr.pi * sampler.next_1d())
        local = mi.Vector3f(dr.sqrt(u) * cos, dr.sqrt(u) * sin, dr.sqrt(1.0 - u))
        ray = mi.Ray3f(origin + 1e-5 * extent * normal, mi.Frame3f(normal).to_world(local))
        visible = dr.select(scene.ray_test(ray), 0.0, 1.0)
        result.append(dr.block_sum(visible, samples).numpy() / samples)
    return time.perf_counter() - started, np.concatenate(result)


def open3d(vertices, triangles, points, normals, samples) -> tuple[float, NDArray]:
    """`RaycastingScene.test_occlusions` on directions made with numpy, one pattern turned about each normal."""
    import open3d

    started = time.perf_counter()
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(triangles, np.uint32))
    extent = float(np.ptp(vertices, axis=0).max())
    random = np.random.default_rng(0)
    u, azimuth = (np.arange(samples) + 0.5) / samples, np.arange(samples) * np.pi * (3.0 - 5.0**0.5)
    pattern = np.column_stack((np.sqrt(u) * np.cos(azimuth), np.sqrt(u) * np.sin(azimuth), np.sqrt(1.0 - u)))
    step = max(1, 2**21 // samples)
    result = []
    for start in range(0, len(points), step):
        normal = normals[start : start + step]
        tangent = np.cross(random.normal(size=normal.shape), normal)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        frame = np.stack((tangent, np.cross(normal, tangent), normal), axis=1).astype(np.float32)
        rays = np.empty((len(normal), samples, 6), np.float32)
        rays[..., :3] = (points[start : start + step] + 1e-5 * extent * normal)[:, None]
        np.matmul(pattern.astype(np.float32), frame, out=rays[..., 3:])
        result.append(1.0 - scene.test_occlusions(rays).numpy().mean(axis=1))
    return time.perf_counter() - started, np.concatenate(result)


def pymeshlab(vertices, triangles, points, normals, samples) -> tuple[float, NDArray]:
    """MeshLab's filter on the vertices themselves, which ``points`` must be; normalised to 1 where all is open."""
    import pymeshlab

    started = time.perf_counter()
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles, v_normals_matrix=normals))
    meshes.compute_scalar_ambient_occlusion(rays=samples)
    # It sums the cosines of directions over the whole sphere, whose mean is a quarter where all is open.
    return time.perf_counter() - started, meshes.current_mesh().vertex_scalar_array() * 4.0 / samples


def libigl(vertices, triangles, points, normals, samples) -> tuple[float, NDArray]:
    """`igl.ambient_occlusion`, whose directions are uniform: it gives alpha."""
    import igl

    started = time.perf_counter()
    blocked = igl.ambient_occlusion(vertices, triangles.astype(np.int64), points, normals, samples)
    return time.perf_counter() - started, 1.0 - blocked


@dataclass(frozen=True)
class Peer:
    """``trace(vertices, triangles, points, normals, samples)`` returns its seconds and what each point sees: k_A where
    ``density`` is "cosine", alpha where it is "uniform"."""

    name: str
    module: str
    trace: Callable[[NDArray, NDArray, NDArray, NDArray, int], tuple[float, NDArray]]
    density: str = "cosine"

    @property
    def installed(self) -> bool:
        return importlib.util.find_spec(self.module) is not None


PEERS = (
    Peer("Mitsuba", "mitsuba", mitsuba),
    Peer("Open3D", "open3d", open3d),
    Peer("MeshLab", "pymeshlab", pymeshlab),
    Peer("libigl", "igl", libigl, "uniform"),
)
