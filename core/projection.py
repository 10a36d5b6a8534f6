# SPDX-License-Identifier: GPL-3.0-or-later
"""From a low surface to the high one that it stands for: points of the one that show the other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rays import Obscurance, Occluders
from .sample_points import CornerTable, SamplePoints, Start
from .surface import Surface


class HighSurface:
    """What low points look for.

    surface    world space
    extrusion  how far outside of the low surface rays start, along its normals; world units
    reach      how long they are, world units; ``inf``: no limit
    """

    def __init__(self, surface: Surface, extrusion: float = 0.0, reach: float = np.inf):
        self.extent = surface.extent
        self.corners = CornerTable(surface)
        self._scene = Occluders(surface.vertices, surface.vertex_triangles)
        self._extrusion, self._reach = extrusion, reach

    def show(self, low: Start, cage: Start | None) -> Start:
        """Where rays from the points of the high surface start that those of ``low`` show; the normals of the high
        surface.

        Each looks against its normal, from where the extrusion takes it, or from ``cage`` towards itself; it shows the
        first that it meets, and is missing where that is nothing.
        """
        if cage is None:
            origins, ways = low.positions + self._extrusion * low.normals, -low.normals
        else:
            origins, ways = cage.positions, low.positions - cage.positions
            length = np.sqrt(np.square(ways).sum(axis=0))
            ways = np.where(length > 1e-30, ways / np.maximum(length, 1e-30), -low.normals)
        shape = low.positions.shape[1:]
        # A hair further out, so that surfaces in one place meet.
        local = self._scene.origins(origins, -ways, self.extent)
        rays = [np.ascontiguousarray(each.reshape(3, -1).T, np.float32) for each in (local, ways)]
        hits = self._scene.hits(*rays, Obscurance(self._reach))
        missing = hits.triangle < 0
        triangle, v, w = (np.where(missing, 0, each) for each in (hits.triangle, hits.u, hits.v))
        start = self.corners.start(*(each.reshape(shape) for each in (triangle, *np.float64((v, w)))))
        return start._replace(missing=missing.reshape(shape))


class ProjectedPoints:
    """The points ``low`` as :class:`SamplePoints` on the ``high`` surface. ``cage`` has the same points on a cage."""

    def __init__(self, low: SamplePoints, high: HighSurface, cage: SamplePoints | None = None):
        self._low, self._high, self._cage = low, high, cage
        self.places = low.places

    def __len__(self) -> int:
        return len(self._low)

    def order(self) -> NDArray[np.intp]:
        return self._low.order()

    def number(self, block: NDArray[np.intp]) -> NDArray[np.integer]:
        return self._low.number(block)

    def at(self, block: NDArray[np.intp]) -> Start:
        return self._high.show(self._low.at(block), None if self._cage is None else self._cage.at(block))
