# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake looks like so far, for the window to show while it goes on: nothing of it is Blender's data.

First a sketch, of few rays: from some of the vertices, or from the texels of a small image. Then what the bake itself
finds, as it finds it, so that the picture gets finer without more rays. The bake's threads fill the pictures,
:mod:`.preview_overlay` draws them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.rasterise import Texels, rasterise
from ..core.sample_points import ChosenPoints, SamplePoints
from ..core.visibility import Visibility
from .mesh_reader import MeshArrays
from .settings import BakeSettings
from .tracer import Tracer, light_rays

# Rays of a sketch: this part of those of the bake, but so many that the first sight of a small bake shows something;
# and from one point.
SHARE, LEAST_RAYS = 0.02, 2**15
FEWEST_SAMPLES, MOST_SAMPLES = 4, 32
# Sides of the images that show a texture: of the sketch, and later. All images of a bake together have at most so many
# texels, of 16 bytes, and half of that in the graphics card.
LARGEST_SKETCH, LARGEST_IMAGE, MOST_TEXELS = 256, 1024, 2**22
# Larger meshes are not shown. Of smaller ones, pictures of so many triangles together are kept.
MOST_TRIANGLES = 2_000_000
# How much facing otherwise counts as distance, in sizes of the surface.
FACING = 0.1


@dataclass(frozen=True)
class Geometry:
    """What is drawn: positions (n, 3) float32 in object space, triangles (m, 3) int32 of them, and where they have a
    UV map, it (n, 2) float32. These are the mesh's vertices, or where the light is a corner's, all face corners."""

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    uv: NDArray[np.float32] | None = None

    @classmethod
    def of(cls, mesh: MeshArrays, domain: str) -> Geometry:
        """Of a ``mesh`` whose light has the ``domain`` "POINT" or "CORNER"."""
        if domain == "POINT":
            return cls(mesh.positions, mesh.corner_vertex[mesh.triangles])
        return cls(mesh.positions[mesh.corner_vertex], mesh.triangles, mesh.uv)


class Picture:
    """How far the bake of one object is: F0, or where it ``is_coloured`` all light, as soon as that is known.
    ``version`` counts what was changed, and is 0 while there is nothing yet; while there ``is_sketch`` alone, the bake
    itself comes later."""

    def __init__(self, geometry: Geometry, is_coloured: bool):
        self.geometry = geometry
        self.version = 0
        self.is_sketch = False
        self._is_coloured = is_coloured

    def _light(self, f0: NDArray, gathered: NDArray | None) -> NDArray[np.float64]:
        """What is shown of points (k, 3), or (k, 1) where it is grey."""
        return f0[:, None] + gathered if self._is_coloured else f0[:, None]


class VertexPicture(Picture):
    """Light (k, 3) of a bake's points, as ``values``; vertex or corner i of the geometry shows the mean of those
    ``shown[i]`` (j,) by ``weights[i]``."""

    def __init__(self, geometry: Geometry, is_coloured: bool):
        super().__init__(geometry, is_coloured)
        self.values = np.empty((0, 3), np.float32)
        self.shown = np.empty((0, 1), np.intp)
        self.weights = np.empty((0, 1), np.float32)

    def sketch(
        self, tracer: Tracer, points: SamplePoints, extent: float, shown: NDArray[np.intp], weights: NDArray[np.float32]
    ) -> Generator[int, None, None]:
        """Trace some of the ``points``; along their order each stands for those that follow it. Once is enough."""
        if len(self.values) == len(points):
            return
        samples, step = _effort(tracer, len(points))
        order, step = points.order(), math.ceil(step)
        seen = yield from tracer.glance(ChosenPoints(points, order[::step]), extent, samples)
        # What is inside of something takes the value before it, too.
        source = np.maximum.accumulate(np.where(seen.lost, 0, np.arange(len(seen.lost))))
        self.values = np.empty((len(points), 3), np.float32)
        self.values[order] = np.repeat(seen.f0[source], step)[: len(points), None]
        self.shown, self.weights = shown, weights
        self.version += 1

    def refine(self, point: NDArray, f0: NDArray, gathered: NDArray | None, lost: NDArray[np.bool_]) -> None:
        """What the bake has found at some points; see :data:`core.visibility.Watch`."""
        self.values[point[~lost]] = self._light(f0, gathered)[~lost]
        self.version += 1

    def colours(self) -> NDArray[np.float32]:
        """Light (n, 3) of the geometry."""
        return (self.values[self.shown] * self.weights[..., None]).sum(axis=1)


class TexturePicture(Picture):
    """Light as images (d, d, 4) float32, the ``tiles`` by number, of at most so many texels together."""

    def __init__(self, geometry: Geometry, is_coloured: bool, resolution: int, most_texels: float):
        super().__init__(geometry, is_coloured)
        self.tiles: dict[int, NDArray[np.float32]] = {}
        self._resolution, self._most_texels = resolution, most_texels
        self._step = 1  # of so many texels of a row one is shown, and of so many rows

    def sketch(
        self,
        tracer: Tracer,
        triangle_uv: dict[int, NDArray],
        points: Callable[[Texels, int], SamplePoints],
        extent: float,
        texels: int,
        threads: int | None,
    ) -> Generator[int, None, None]:
        """Trace small images of the tiles whose UVs (m, 3, 2) are given by number; ``points`` makes what stands for the
        texels of an image of that size, ``texels`` are about how many all will have. Once is enough."""
        if self.tiles.keys() == triangle_uv.keys():
            return
        side = min(LARGEST_IMAGE, math.sqrt(self._most_texels / len(triangle_uv)))
        self._step, texels = math.ceil(self._resolution / side), max(texels, 1)
        samples, step = _effort(tracer, texels, texels * min(1.0, (LARGEST_SKETCH / self._resolution) ** 2))
        size = max(1, int(self._resolution / math.sqrt(step)))
        for number, uv in triangle_uv.items():
            covered = rasterise(uv, size, size, threads=threads)
            seen = yield from tracer.glance(points(covered, size), extent, samples)
            self.tiles[number] = self._enlarged(covered.texel, seen, size)
        self.version += 1

    def refine(self, number: int, texel: NDArray) -> Callable[[NDArray, NDArray, NDArray | None, NDArray], None]:
        """As :meth:`VertexPicture.refine`, for points that are these texels of a tile."""

        def refine(point: NDArray, f0: NDArray, gathered: NDArray | None, lost: NDArray[np.bool_]) -> None:
            row, column = np.divmod(texel[point], self._resolution)
            some = ~lost & (row % self._step == 0) & (column % self._step == 0)
            row, column = row[some] // self._step, column[some] // self._step
            self.tiles[number][row, column, :3] = self._light(f0, gathered)[some]
            self.version += 1

        return refine

    def _enlarged(self, texel: NDArray, seen: Visibility, size: int) -> NDArray[np.float32]:
        """A sketch at the size that is shown later. What is not known takes the nearest that is."""
        from scipy.ndimage import distance_transform_edt

        light, unknown = np.ones((size, size), np.float32), np.ones((size, size), bool)
        light.reshape(-1)[texel], unknown.reshape(-1)[texel] = seen.f0, seen.lost
        if not unknown.all():
            light = light[*distance_transform_edt(unknown, return_distances=False, return_indices=True)]
        shown = np.arange(0, self._resolution, self._step) * size // self._resolution
        image = np.ones((len(shown), len(shown), 4), np.float32)
        image[..., :3] = light[np.ix_(shown, shown)][..., None]
        return image


class Preview:
    """Pictures of the objects of a bake, which are so many, by their session's number, as it comes to them; while it
    only ``is_sketching``, these end with the sketch."""

    def __init__(self) -> None:
        self.pictures: dict[int, Picture] = {}
        self.objects = 1
        self.is_sketching = False

    def of_vertices(
        self, obj: bpy.types.Object, mesh: MeshArrays, domain: str, settings: BakeSettings
    ) -> VertexPicture | None:
        """Begin a picture of ``obj``, whose evaluated ``mesh`` shows values of its ``domain``; None where that is too
        large."""
        return self._begin(obj, mesh, lambda: VertexPicture(Geometry.of(mesh, domain), _is_coloured(settings)))

    def of_texels(self, obj: bpy.types.Object, mesh: MeshArrays, settings: BakeSettings) -> TexturePicture | None:
        """The same, of one that shows images by its UV map."""
        how = _is_coloured(settings), settings.resolution, MOST_TEXELS / self.objects
        return self._begin(obj, mesh, lambda: TexturePicture(Geometry.of(mesh, "CORNER"), *how))

    def _begin(self, obj: bpy.types.Object, mesh: MeshArrays, picture: Callable[[], Picture]) -> Picture | None:
        triangles = len(mesh.triangles)
        if triangles > MOST_TRIANGLES:
            return None
        found = self.pictures.get(obj.session_uid)
        if found is None or len(found.geometry.triangles) != triangles:
            found = self.pictures[obj.session_uid] = picture()
        found.is_sketch = self.is_sketching
        while sum(len(each.geometry.triangles) for each in self.pictures.values()) > MOST_TRIANGLES:
            del self.pictures[next(uid for uid, each in self.pictures.items() if each is not found)]
        return found


def nearest_shown(
    positions: NDArray, normals: NDArray, points: NDArray, point_normals: NDArray, extent: float
) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Which ``points`` (k, 3) stand for other places (n, 3) of a surface of that ``extent``, (n, j), and their weights:
    the nearest ones that face the same way."""
    from scipy.spatial import cKDTree

    there = np.column_stack((points, FACING * extent * point_normals))
    here = np.column_stack((positions, FACING * extent * normals))
    distance, shown = cKDTree(there).query(here, k=min(3, len(points)))
    distance, shown = distance.reshape(len(here), -1), shown.reshape(len(here), -1)
    weights = 1.0 / np.maximum(distance, 1e-6 * extent)
    return shown, (weights / weights.sum(axis=1, keepdims=True)).astype(np.float32)


def _is_coloured(settings: BakeSettings) -> bool:
    return settings.bounces == "RADIOSITY"


def _effort(tracer: Tracer, points: int, most: float = math.inf) -> tuple[int, float]:
    """Samples of a sketch of a bake of so many ``points``, and of how many of these one is traced: at ``most`` so many
    are."""
    rays = points * tracer.settings.samples
    rays = max(LEAST_RAYS, SHARE * (rays + (0 if tracer.settings.bounces == "FITTED" else light_rays(rays))))
    samples = int(np.clip(rays // max(min(points, most), 1), FEWEST_SAMPLES, MOST_SAMPLES))
    samples = min(samples, tracer.settings.samples)
    return samples, max(1.0, points / most, samples * points / rays)
