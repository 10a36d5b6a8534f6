# SPDX-License-Identifier: GPL-3.0-or-later
"""What the bakes are measured against: random rays that share nothing with theirs but Embree.

Directions are jittered in a square of strata, anew for each point, and mapped to the hemisphere. Every truth comes as
two independent estimates t1 and t2, because the mean of (x - t1)(x - t2) is the squared error of x without their own.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import bpy
import numpy as np
from numpy.typing import NDArray

RAYS_PER_CHUNK = 2**16
STRATA = 96  # squared: rays of each of the two estimates
COARSE_STRATA = 24
UNSETTLED = 0.06  # many times the error of a truth of COARSE_STRATA
OFFSET = 1e-5  # of the size, off the surface
HAIR = 1e-6  # of the size: some steps of float32
INSET = 1e-4  # of the way from a corner to its triangle's centre


def rms(values: NDArray, truth: NDArray) -> float:
    """rms error of ``values`` (..., n) against ``truth`` (2, n)."""
    return float(np.sqrt(np.mean((values - truth[0]) * (values - truth[1]))))


@dataclass
class Geometry:
    """A mesh in world space, as float64.

    vertices (n, 3), triangles (m, 3), normals of vertices (n, 3) and of triangle corners (m, 3, 3);
    corners (m, 3), the face corner of each triangle's corner; corner_vertex (c,)
    """

    vertices: NDArray
    triangles: NDArray
    vertex_normals: NDArray
    corner_normals: NDArray
    corners: NDArray
    corner_vertex: NDArray

    @classmethod
    def of(cls, obj: bpy.types.Object) -> Geometry:
        """``obj`` without modifiers, only moved, turned and scaled evenly."""
        mesh = obj.data
        mesh.calc_loop_triangles()

        def read(data, name, kind, width=3):
            values = np.empty(width * len(data), kind)
            data.foreach_get(name, values)
            return values.reshape(-1, width) if width > 1 else values

        matrix = np.array(obj.matrix_world, np.float64)
        turn = matrix[:3, :3] / np.cbrt(np.linalg.det(matrix[:3, :3]))
        return cls(
            read(mesh.vertices, "co", np.float32) @ matrix[:3, :3].T + matrix[:3, 3],
            read(mesh.loop_triangles, "vertices", np.int32),
            read(mesh.vertex_normals, "vector", np.float32) @ turn.T,
            read(mesh.corner_normals, "vector", np.float32) @ turn.T,
            read(mesh.loop_triangles, "loops", np.int32),
            read(mesh.loops, "vertex_index", np.int32, 1),
        )

    @cached_property
    def extent(self) -> float:
        return float(np.ptp(self.vertices[self.triangles], axis=(0, 1)).max())

    def elements(self, domain: str) -> tuple[NDArray, NDArray]:
        """Positions and normals (k, 3) of what an attribute of ``domain`` has values for.

        A face's corner is a hair within its face: on the edge itself the wall that the face meets would block or not as
        rounding has it.
        """
        if domain == "POINT":
            return self.vertices, self.vertex_normals
        positions = self.vertices[self.corner_vertex]
        corners = self.vertices[self.triangles]
        positions[self.corners] = corners + INSET * (corners.mean(axis=1, keepdims=True) - corners)
        return positions, self.corner_normals

    def used(self, domain: str) -> NDArray[np.intp]:
        """The elements of ``domain`` that face somewhere: those of faces with an area, where normals do not cancel."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        has_area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12 * self.extent**2
        on_faces = np.unique((self.triangles if domain == "POINT" else self.corners)[has_area])
        _, normals = self.elements(domain)
        return on_faces[np.linalg.norm(normals[on_faces], axis=1) > 0.5]

    @cached_property
    def _scene(self):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        scene = EmbreeScene(robust=True)
        self._centre = np.median(self.vertices[self.triangles].reshape(-1, 3), axis=0)
        self._mesh = TriangleMesh(scene, self._local(self.vertices), self.triangles)
        return scene

    def _local(self, points: NDArray) -> NDArray[np.float32]:
        return ((points - self._centre) / self.extent).astype(np.float32)

    def is_settled(self, points: NDArray, normals: NDArray) -> NDArray[np.bool_]:
        """Whether k_A of each point (n,) stays the same from half and twice the offset, and a hair to any side.

        Where faces lie on one another, or a vertex on another face, rounding decides which side of it the vertex sees,
        and no bake is right or wrong.
        """
        aside = HAIR * self.extent * tangents(normals)
        moved = [points + sign * each for sign in (-1.0, 1.0) for each in aside]
        trials = [(points, 0.5 * OFFSET), (points, 2.0 * OFFSET), *((each, OFFSET) for each in moved)]
        values = [
            self.visibility(at, normals, strata=COARSE_STRATA, offset=offset).mean(axis=0) for at, offset in trials
        ]
        return np.ptp(values, axis=0) < UNSETTLED

    def visibility(
        self,
        points: NDArray,
        normals: NDArray,
        density: str = "cosine",
        strata: int = STRATA,
        seed: int = 0,
        offset: float = OFFSET,
    ) -> NDArray[np.float64]:
        """Two estimates of k_A ("cosine") or alpha ("uniform") of each point: (2, n)."""
        scene = self._scene
        step = max(1, RAYS_PER_CHUNK // strata**2)
        chunks = [slice(start, start + step) for start in range(0, len(points), step)]

        def trace(chunk, half):
            directions = hemisphere(normals[chunk], strata, density, (seed, half, chunk.start))
            off = points[chunk] + offset * self.extent * normals[chunk]
            origins = np.repeat(self._local(off), strata**2, axis=0)
            blocked = scene.run(origins, directions.reshape(-1, 3), query="OCCLUDED") >= 0
            return 1.0 - blocked.reshape(-1, strata**2).mean(axis=1)

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return np.array([np.concatenate(list(pool.map(trace, chunks, [half] * len(chunks)))) for half in (0, 1)])

    def blocked(self, points: NDArray, normals: NDArray, directions: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether the ray from each point (n, 3) meets anything."""
        scene = self._scene
        off = self._local(points + OFFSET * self.extent * normals)
        return scene.run(off, directions, query="OCCLUDED") >= 0


def hemisphere(normals: NDArray, strata: int, density: str, seed: tuple[int, ...]) -> NDArray[np.float32]:
    """Directions (n, strata^2, 3) about ``normals`` (n, 3), jittered in equal parts of azimuth and of the density."""
    random = np.random.default_rng(seed)
    cell = np.arange(strata, dtype=np.float32)
    shape = (len(normals), strata, strata)
    u = (cell[:, None] + random.random(shape, np.float32)) / np.float32(strata)
    azimuth = (cell + random.random(shape, np.float32)) * np.float32(2.0 * np.pi / strata)
    z = np.sqrt(u) if density == "cosine" else u
    radius = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    local = np.stack((radius * np.cos(azimuth), radius * np.sin(azimuth), z), axis=-1).reshape(len(normals), -1, 3)
    frame = np.stack((*tangents(normals), normals), axis=1).astype(np.float32)
    return np.matmul(local, frame)


def tangents(normals: NDArray) -> NDArray[np.float64]:
    """Any two (2, n, 3) of each of ``normals`` (n, 3): crossed with the axis that the normal is furthest from."""
    axis = np.eye(3)[np.abs(normals).argmin(axis=1)]
    tangent = np.cross(axis, normals)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return np.stack((tangent, np.cross(normals, tangent)))
