# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that blocks light, as one Embree scene that rays are traced against.

Embree works in float32, which resolves a ten-millionth of a coordinate. The scene is therefore moved in float64 so that
what is baked lies about the origin, where that is finest, wherever it is in the world and whatever stands far away.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from .closed_parts import in_closed_parts
from .mesh_parts import mesh_parts, triangle_numbers

Falloff = Literal["NONE", "LINEAR", "SMOOTH"]

# Distance kept from the surface that a ray leaves, as a fraction of the baked object's extent: small enough that
# contacts stay dark, large enough that no ray meets the face it starts from.
OFFSET = 1e-5
# ... plus this fraction of the distance to the scene's centre: eight steps of float32, for what rounding moves.
OFFSET_PER_COORDINATE = 2.0**-20
# No step of a ray that goes on is smaller, not even where its origin is zero.
NO_STEP = float(np.finfo(np.float32).tiny)


@dataclass(frozen=True)
class Obscurance:
    """What counts as a blocker: rho(d) of a hit at distance d, 0 where it blocks fully and 1 past ``max_distance``.

    NONE 0; LINEAR d/max; SMOOTH the smoothstep of d/max. (Zhukov et al. 1998, "An Ambient Light Illumination Model".)
    ``max_distance`` in world units, ``inf``: plain ambient occlusion, where any hit blocks and ``falloff`` has no say.
    """

    max_distance: float = np.inf
    falloff: Falloff = "NONE"
    ignore_backfaces: bool = False

    @property
    def reach(self) -> float:
        """Furthest distance that blocks: ``max_distance``, finite, so that "no hit" (``inf``) lies beyond it."""
        return min(self.max_distance, np.finfo(np.float64).max)

    @property
    def needs_distance(self) -> bool:
        return self.falloff != "NONE" and np.isfinite(self.max_distance)

    def rho(self, distance: NDArray) -> NDArray[np.float64]:
        """rho of the nearest hit's ``distance`` in world units (``inf``: none)."""
        t = np.minimum(distance / self.max_distance, 1.0)
        rho = t if self.falloff == "LINEAR" else t * t * (3.0 - 2.0 * t)
        # In steps of 2^-12, so that sums with the pattern's weights stay exact.
        return np.rint(rho * 2.0**12) / 2.0**12


@dataclass(frozen=True)
class Hits:
    """What r rays meet first.

    visible   (r,) float64, V: 1 where nothing blocks, 0 where something does, between them rho(d)
    triangle  (r,) int32, of the occluders; their number stands for the floor, -1 for nothing that blocks
    distance  (r,) float, in the units that Embree sees; any number where nothing blocks
    normal    (r, 3) float32 of that triangle's front, of any length
    behind    (r,) bool, whether it is seen from its back
    u, v      (r,) float32, weights of that triangle's second and third corner
    """

    visible: NDArray[np.float64]
    triangle: NDArray[np.int32]
    distance: NDArray[np.floating]
    normal: NDArray[np.float32]
    behind: NDArray[np.bool_]
    u: NDArray[np.float32]
    v: NDArray[np.float32]

    def normals(self, ray: NDArray[np.intp]) -> NDArray[np.float32]:
        """Unit normals (k, 3) of the sides that are met, for rays (k,) that meet something."""
        normal = self.normal[ray] * np.where(self.behind[ray], -1.0, 1.0).astype(np.float32)[:, None]
        return normal / np.maximum(np.sqrt(np.square(normal).sum(axis=1)), np.finfo(np.float32).tiny)[:, None]


class Occluders:
    """Triangles (and perhaps an infinite floor) that rays are tested against.

    vertices      (n, 3) float, world units
    triangles     (m, 3) int, counter-clockwise seen from the front
    ground_height world z of an infinite floor, or None
    centre        (3,) float, where precision is wanted most; default the median vertex, which few far ones do not move

    As attributes, ``vertices`` (n, 3) float32 are in the units that Embree sees, as are rays.

    Raises ValueError where a vertex is not finite. Safe to use from many threads: Embree only reads.
    """

    def __init__(
        self, vertices: NDArray, triangles: NDArray, ground_height: float | None = None, centre: NDArray | None = None
    ):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        vertices = np.asarray(vertices, np.float64).reshape(-1, 3)
        triangles = np.ascontiguousarray(triangles, np.int32).reshape(-1, 3)
        if not np.isfinite(vertices).all():
            raise ValueError("occluder vertices must be finite")
        is_used = np.zeros(len(vertices), bool)
        is_used[triangles] = True
        used = vertices[is_used] if len(triangles) else np.array([(-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)])
        self.centre = np.median(used, axis=0) if centre is None else np.asarray(centre, np.float64)
        self.scale = 2.0 / max(float(np.ptp(used, axis=0).max()), np.finfo(np.float32).tiny)
        self.ground_height = ground_height
        self.triangles = triangles
        self.vertices = ((vertices - self.centre) * self.scale).astype(np.float32)
        # robust: watertight at the edges of separate faces that meet, where the faster mode leaks.
        self._scene = EmbreeScene(robust=True)
        if len(triangles):
            self._meshes = [TriangleMesh(self._scene, *part) for part in mesh_parts(self.vertices, triangles)]
            # The first ray has Embree build its tree: here, not under the first of many threads.
            self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")

    @cached_property
    def _is_closed(self) -> NDArray[np.bool_]:
        """(m,): few scenes ask for it. Two threads that do so together find the same."""
        return in_closed_parts(self.triangles, len(self.vertices))

    def origins(self, positions: NDArray, normals: NDArray, extent: float) -> NDArray[np.float64]:
        """Where rays start (3, ...), in the units that Embree sees: just off the surface at world ``positions``
        (3, ...), along unit ``normals``.

        ``extent`` is the size of the baked object in world units. The offset is local to it, so that a small prop in a
        wide landscape keeps its contacts.
        """
        local = np.stack([(axis - middle) * self.scale for axis, middle in zip(positions, self.centre, strict=True)])
        return self.off_surface(local, normals, extent)

    def off_surface(self, local: NDArray, normals: NDArray, extent: float) -> NDArray[np.float64]:
        """As :meth:`origins`, for positions ``local`` that are in Embree's units already."""
        away = OFFSET * extent * self.scale + OFFSET_PER_COORDINATE * np.abs(local).max(axis=0)
        return np.ascontiguousarray(local + away * normals)

    def lift(self, origins: NDArray[np.float64], normals: NDArray, height: NDArray, extent: float) -> None:
        """Move ``origins`` (3, ...), as :meth:`origins` makes them, in place along ``normals`` (3, ...), by ``height``
        (...) in world units, but at most half way to what is there. Less than the offset they have already is left
        out."""
        height = height.reshape(-1) * self.scale
        raised = np.flatnonzero(height > OFFSET * extent * self.scale)
        if not len(raised):
            return
        height = height.take(raised)
        at, along = (each.reshape(3, -1).take(raised, axis=1) for each in (origins, normals))
        rays = [each.T.astype(np.float32, order="C") for each in (at, along)]
        # Few have anything within twice their height, and short rays tell that fast.
        if len(self.triangles):
            blocked = self._scene.run(*rays, dists=(2.0 * height).astype(np.float32), query="OCCLUDED")
            low = np.flatnonzero(blocked == 0)
            height[low] = np.minimum(height[low], 0.5 * self._first(*(each[low] for each in rays)))
        if self.ground_height is not None:
            height = np.minimum(height, 0.5 * self.scale * self._ground(*rays))
        for position, step in zip(origins, height * along, strict=True):
            position.reshape(-1)[raised] += step

    def visibility(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        obscurance: Obscurance,
        out: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """V of each ray: 1 escapes, 0 is blocked, between them rho(d). Arrays (r, 3) float32, result (r,) float64, in
        ``out`` where it is given."""
        visible = np.empty(len(origins)) if out is None else out
        if obscurance.needs_distance:
            visible[:] = obscurance.rho(self._nearest(origins, directions, obscurance))
            return visible
        if obscurance.ignore_backfaces:
            np.greater(self._nearest(origins, directions, obscurance), obscurance.reach, out=visible)
            return visible
        if len(self.triangles):
            far = None
            if np.isfinite(obscurance.max_distance):
                far = np.full(len(origins), min(obscurance.max_distance * self.scale, 1e30), np.float32)
            blocked = self._scene.run(origins, directions, dists=far, query="OCCLUDED")
            np.negative(blocked, out=visible)  # Embree's answer: -1 a miss, 0 a hit
        else:
            visible.fill(1.0)
        if self.ground_height is not None:
            visible[self._ground(origins, directions) <= obscurance.reach] = 0.0
        return visible

    def _nearest(self, origins, directions, obscurance: Obscurance) -> NDArray[np.float64]:
        """Distance in world units to the nearest hit that counts, ``inf`` where there is none."""
        distance = np.full(len(origins), np.inf)
        if len(self.triangles):
            if obscurance.ignore_backfaces:
                distance = self._first_front(origins, directions).distance / self.scale
            else:
                distance = self._first(origins, directions) / self.scale
        if self.ground_height is not None:
            distance = np.minimum(distance, self._ground(origins, directions))
        return distance

    def _first(self, origins, directions) -> NDArray[np.float64]:
        distance = self._scene.run(origins, directions, query="DISTANCE").astype(np.float64)
        return np.where(distance < 1e30, distance, np.inf)

    def hits(self, origins: NDArray[np.float32], directions: NDArray[np.float32], obscurance: Obscurance) -> Hits:
        """What each ray (r, 3) meets first, and how much it blocks: ``visible`` is as from :meth:`visibility`."""
        if not len(self.triangles):
            hits = _no_hits(len(origins))
        elif obscurance.ignore_backfaces:
            hits = self._first_front(origins, directions)
        else:
            found = self._scene.run(origins, directions, query="INTERSECT", output=True)
            behind = np.einsum("ij,ij->i", found["Ng"], directions) > 0.0
            triangle = triangle_numbers(found)
            hits = Hits(np.empty(len(origins)), triangle, found["tfar"], found["Ng"], behind, found["u"], found["v"])
        if self.ground_height is not None:
            floor = self._ground(origins, directions) * self.scale
            lower = np.flatnonzero(floor < np.where(hits.triangle >= 0, hits.distance, np.inf))
            hits.triangle[lower], hits.distance[lower] = len(self.triangles), floor[lower]
            hits.normal[lower], hits.behind[lower] = (0.0, 0.0, 1.0), False
        missed = hits.triangle < 0
        if obscurance.needs_distance:
            hits.visible[:] = obscurance.rho(np.where(missed, np.inf, hits.distance) / self.scale)
        else:
            hits.visible[:] = missed
            if np.isfinite(obscurance.max_distance):
                hits.visible[hits.distance > obscurance.max_distance * self.scale] = 1.0
        hits.triangle[hits.visible == 1.0] = -1
        return hits

    def see_inside(self, origins: NDArray[np.float32], directions: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Whether the first that each ray (r, 3) meets is the inside of something closed."""
        if not len(origins):
            return np.zeros(0, bool)
        hits = self.hits(origins, directions, Obscurance())
        inside = hits.behind & (hits.triangle >= 0)
        if inside.any():
            inside[inside] = self._is_closed[hits.triangle[inside]]
        return inside

    def _first_front(self, origins, directions) -> Hits:
        """What each ray meets first from the front; it goes on through faces that it hits from behind."""
        hits = _no_hits(len(origins))
        travelled, step = np.zeros((2, len(origins)))
        alive = np.arange(len(origins))
        start = origins
        while len(alive):
            hit = self._scene.run(start, directions[alive], query="INTERSECT", output=True)
            found, triangle = np.flatnonzero(hit["primID"] >= 0), triangle_numbers(hit)
            alive, t, normal = alive[found], hit["tfar"][found].astype(np.float64), hit["Ng"][found]
            travelled[alive] += t
            front = np.einsum("ij,ij->i", normal, directions[alive]) < 0.0
            met = alive[front]
            hits.distance[met], hits.triangle[met] = travelled[met], triangle[found[front]]
            hits.normal[met] = normal[front]
            hits.u[met], hits.v[met] = hit["u"][found[front]], hit["v"][found[front]]
            alive, t = alive[~front], t[~front]
            # A step past the face, as small as float32 resolves at this distance; twice the last one where that did not
            # lead past it, as in faces that have no width there.
            least = OFFSET_PER_COORDINATE * (np.abs(origins[alive]).max(axis=1) + travelled[alive]) + NO_STEP
            step[alive] = np.where(t <= step[alive], np.maximum(2.0 * step[alive], least), least)
            travelled[alive] += step[alive]
            start = (origins[alive] + travelled[alive, None] * directions[alive]).astype(np.float32)
        return hits

    def _ground(self, origins, directions) -> NDArray[np.float64]:
        """Distance in world units to the floor, ``inf`` for rays that rise."""
        plane = (self.ground_height - self.centre[2]) * self.scale
        # A point of the floor itself starts its offset below it when it faces down.
        height = np.maximum(origins[:, 2].astype(np.float64) - plane, 0.0)
        down = -directions[:, 2].astype(np.float64)
        distance = np.full(len(origins), np.inf)
        np.divide(height, down * self.scale, out=distance, where=down > 0.0)
        return distance


def _no_hits(rays: int) -> Hits:
    return Hits(
        np.empty(rays),
        np.full(rays, -1, np.int32),
        np.full(rays, np.inf),
        np.zeros((rays, 3), np.float32),
        np.zeros(rays, bool),
        np.zeros(rays, np.float32),
        np.zeros(rays, np.float32),
    )
