# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that blocks light, as one Embree scene that rays are traced against.

Embree works in float32, which resolves a ten-millionth of a coordinate. The scene is therefore moved in float64 so that
what is baked lies about the origin, where that is finest, wherever it is in the world and whatever stands far away.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Falloff = Literal["NONE", "LINEAR", "SMOOTH"]

# Distance kept from the surface that a ray leaves, as a fraction of the baked object's extent: small enough that
# contacts stay dark, large enough that no ray meets the face it starts from.
OFFSET = 1e-5
# ... plus this fraction of the distance to the scene's centre: eight steps of float32, for what rounding moves.
OFFSET_PER_COORDINATE = 2.0**-20


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


class Occluders:
    """Triangles (and perhaps an infinite floor) that rays are tested against.

    vertices      (n, 3) float, world units
    triangles     (m, 3) int, counter-clockwise seen from the front
    ground_height world z of an infinite floor, or None
    centre        (3,) float, where precision is wanted most; default the median vertex, which few far ones do not move

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
        self.triangle_count = len(triangles)
        # robust: watertight at the edges of separate faces that meet, where the faster mode leaks.
        self._scene = EmbreeScene(robust=True)
        if len(triangles):
            in_scene = ((vertices - self.centre) * self.scale).astype(np.float32)
            self._mesh = TriangleMesh(self._scene, in_scene, triangles)
            # The first ray has Embree build its tree: here, not under the first of many threads.
            self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")

    def origins(self, positions: NDArray, normals: NDArray, extent: float) -> NDArray[np.float64]:
        """Where rays start (3, ...), in the units that Embree sees: just off the surface at world ``positions``
        (3, ...), along unit ``normals``.

        ``extent`` is the size of the baked object in world units. The offset is local to it, so that a small prop in a
        wide landscape keeps its contacts.
        """
        local = np.stack([(axis - middle) * self.scale for axis, middle in zip(positions, self.centre, strict=True)])
        away = OFFSET * extent * self.scale + OFFSET_PER_COORDINATE * np.abs(local).max(axis=0)
        local += away * normals
        return local

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
        if self.triangle_count:
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
        if self.triangle_count:
            first = self._first_front if obscurance.ignore_backfaces else self._first
            distance = first(origins, directions) / self.scale
        if self.ground_height is not None:
            distance = np.minimum(distance, self._ground(origins, directions))
        return distance

    def _first(self, origins, directions) -> NDArray[np.float64]:
        distance = self._scene.run(origins, directions, query="DISTANCE").astype(np.float64)
        return np.where(distance < 1e30, distance, np.inf)

    def _first_front(self, origins, directions) -> NDArray[np.float64]:
        """As :meth:`_first`, but rays go on through faces hit from behind."""
        distance = np.full(len(origins), np.inf)
        travelled = np.zeros(len(origins))
        alive = np.arange(len(origins))
        start = origins
        while len(alive):
            hit = self._scene.run(start, directions[alive], query="INTERSECT", output=True)
            found = hit["primID"] >= 0
            alive, t, normal = alive[found], hit["tfar"][found].astype(np.float64), hit["Ng"][found]
            travelled[alive] += t
            front = np.einsum("ij,ij->i", normal, directions[alive]) < 0.0
            distance[alive[front]] = travelled[alive[front]]
            alive = alive[~front]
            # A step past the face, as small as float32 resolves at this distance.
            travelled[alive] += OFFSET_PER_COORDINATE * (np.abs(origins[alive]).max(axis=1) + travelled[alive])
            start = (origins[alive] + travelled[alive, None] * directions[alive]).astype(np.float32)
        return distance

    def _ground(self, origins, directions) -> NDArray[np.float64]:
        """Distance in world units to the floor, ``inf`` for rays that rise."""
        plane = (self.ground_height - self.centre[2]) * self.scale
        # A point of the floor itself starts its offset below it when it faces down.
        height = np.maximum(origins[:, 2].astype(np.float64) - plane, 0.0)
        down = -directions[:, 2].astype(np.float64)
        distance = np.full(len(origins), np.inf)
        np.divide(height, down * self.scale, out=distance, where=down > 0.0)
        return distance
