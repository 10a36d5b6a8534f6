# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to images: the texels of a UV map, tile by tile, a band of rows at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.adjacent_faces import AdjacentFaces
from ..core.albedo import Albedo
from ..core.fill import fill_texels
from ..core.light_cache import LightCache
from ..core.margin import extend_margin
from ..core.projection import ProjectedPoints
from ..core.rasterise import Texels, bands, rasterise
from ..core.sample_points import PROBES, CornerTable, SamplePoints, TexelPoints, spread_points, texel_places
from ..core.surface import Surface, unit
from ..core.workers import Workers, mapped, slices
from .bent_normal_map import BentNormalMap
from .high_to_low import ProjectionSource
from .mesh_reader import MeshArrays, linear_inverse
from .names import BENT_NORMAL, CHANNELS
from .preview import TexturePicture
from .progress import STARTED
from .report import BakeError, ObjectReport
from .settings import BakeSettings
from .texture_memory import check_memory, needed_memory
from .texture_result import TextureResult, Tile
from .tracer import Tracer
from .uv_layout import check_layout, expected_texels, overlaps, touched_tiles

# Texels whose channels a thread computes together: so few that OpenBLAS wakes no threads for their products.
TEXELS_PER_PART = 2**14
# What finding a place of a texel takes, in rays; only what is told of the progress depends on it.
RAYS_BEFORE = 0.5


def bake_texture(
    obj: bpy.types.Object,
    source: MeshArrays,
    uv_map: str,
    matrix: NDArray,
    tracer: Tracer,
    report: ObjectReport,
    settings: BakeSettings,
    folder: str,
    projected: ProjectionSource | None,
    albedo: Albedo | None,
    bent_normals: BentNormalMap | None,
    threads: int | None,
    picture: TexturePicture | None = None,
) -> Generator[float, None, TextureResult | None]:
    """Bake the texels of ``obj``, whose evaluated mesh is ``source``, with the UVs of ``uv_map``; yields the fraction
    done.

    ``matrix`` (4, 4) places the object; its texels show its own surface, or what is ``projected``; ``albedo`` of its
    triangles is kept for the maps; ``bent_normals`` makes one more image; ``threads`` rasterise; ``picture`` shows how
    far it is. None where that is only to be a sketch. Raises BakeError where the UV map leaves nothing to bake.
    """
    yield 0.0
    surface = source.surface(matrix)
    triangle_uv = surface.corner_uv[surface.triangles]
    report.warnings += check_layout(triangle_uv, uv_map, settings.use_udim)
    numbers = touched_tiles(triangle_uv) if settings.use_udim else [1001]
    report.memory = needed_memory(settings, len(numbers), len(triangle_uv))
    check_memory(report.memory)
    yield 0.0
    projection = projected and projected.projection()
    corners = CornerTable(surface)
    shown, extent, cage = corners, surface.extent, None
    if projection is not None:
        shown, extent = projection.high.corners, projection.high.extent
        if projection.cage is not None:
            cage = CornerTable(replace(surface, vertices=projection.cage))
    texels = expected_texels(triangle_uv, settings.resolution, len(numbers))

    def points(texels: Texels, size: int) -> SamplePoints:
        low = TexelPoints(corners, texels, size)
        if projection is None:
            return low
        return ProjectedPoints(low, projection.high, cage and TexelPoints(cage, texels, size))

    if picture is not None:
        tile_uv = {number: _in_tile(triangle_uv, number) for number in numbers}
        sketch = picture.sketch(tracer, tile_uv, points, extent, texels, threads)
        yield from mapped(sketch, lambda done: 0.0)
        if picture.is_sketch:
            return None
    begin = tracer.light_share(texels, texel_places(settings.samples))
    lighting = tracer.light(partial(spread_points, shown, PROBES), texels, extent)
    cache = yield from mapped(lighting, lambda done: begin * done)
    maps, shown = (albedo, bent_normals), (settings, threads, picture)
    baker = _TileBaker(surface, triangle_uv, points, tracer, cache, extent, linear_inverse(matrix), *maps, *shown)
    tiles, f0 = {}, []
    for done, number in enumerate(numbers):

        def fraction(part: float, done=done) -> float:
            return max(STARTED, begin + (1.0 - begin) * (done + part) / len(numbers))

        tile = yield from mapped(baker.bake(number, report, f0), fraction)
        if tile is not None:
            tiles[number] = tile
    if not tiles:
        raise BakeError(f"touches no texel in UV map '{uv_map}': pack its islands (UV > Pack Islands)")
    if overlaps(triangle_uv, report.points, settings.resolution, settings.use_udim):
        report.warnings.append(
            f"UV map '{uv_map}' overlaps itself: where faces share texels, one of them decides their color"
        )
    report.tell_f0(np.concatenate(f0), "texels", projection is not None)
    return TextureResult(obj, uv_map, folder, settings, tiles)


@dataclass(frozen=True)
class _TileBaker:
    """What all tiles of a bake have in common; see :func:`bake_texture`."""

    surface: Surface
    triangle_uv: NDArray[np.float64]
    points: Callable[[Texels, int], SamplePoints]
    tracer: Tracer
    cache: LightCache | None
    extent: float
    world_to_object: NDArray[np.float64]
    albedo: Albedo | None
    bent_normals: BentNormalMap | None
    settings: BakeSettings
    threads: int | None
    picture: TexturePicture | None

    def bake(
        self, number: int, report: ObjectReport, f0: list[NDArray[np.float32]]
    ) -> Generator[float, None, Tile | None]:
        """The tile of that ``number``; None where nothing lies in it. Counts its points in ``report``, and adds their
        F0 to ``f0``."""
        yield 0.0
        size, tracer, threads = self.settings.resolution, self.tracer, self.threads
        triangle_uv = _in_tile(self.triangle_uv, number)
        flat = {channel: np.zeros((size * size, 4), np.float32) for channel in CHANNELS[self.settings.bounces]}
        if self.bent_normals is not None:
            flat[BENT_NORMAL] = np.tile(self.bent_normals.background(), (size * size, 1))
        colours = None if self.albedo is None else np.zeros((size * size, 3), np.float32)
        lost, lost_normals = [], []
        covered, known = np.zeros((2, size * size), bool)
        places = texel_places(self.settings.samples)
        for first, last in bands(size, size, places):
            texels = rasterise(triangle_uv, size, size, places, (first, last), threads)
            if not len(texels.texel):
                continue
            points = self.points(texels, size)
            watch = self.picture and self.picture.refine(number, texels.texel)
            tracing = tracer.visibility(points, self.extent, self.cache, watch)
            begin, part = first / size, (last - first) / size
            ahead = part / (1.0 + self.settings.samples / (RAYS_BEFORE * places))
            each = (part - ahead) / len(texels.texel)

            def fraction(done: int, begin=begin, ahead=ahead, each=each) -> float:
                # Half of what goes before is done when tracing is asked for, and all when the first is traced.
                return begin + (ahead + done * each if done else 0.5 * ahead)

            visibility = yield from mapped(tracing, fraction)

            def fill(part: slice, texels=texels, visibility=visibility) -> None:
                texel = texels.texel[part]
                for channel, values in tracer.channels(visibility[part], self.world_to_object).items():
                    flat[channel][texel] = values
                covered[texel] = True
                known[texel] = ~visibility.lost[part]
                if self.bent_normals is not None:
                    flat[BENT_NORMAL][texel] = self.bent_normals.colours(texels[part], visibility.bent[part])
                if colours is not None:
                    triangle, weights = texels.triangle[part], texels.weights[part].reshape(-1, 2).T
                    values = self.albedo.at(triangle.reshape(-1), *weights)
                    colours[texel] = values.reshape(*triangle.shape, 3).mean(axis=1)

            with Workers(threads) as workers:
                workers.map(fill, slices(len(texels.texel), TEXELS_PER_PART))
            report.points += len(texels.texel)
            f0.append(visibility.f0[~visibility.lost])
            at = np.flatnonzero(visibility.lost)
            lost.append(texels.texel[at])
            lost_normals.append(points.at(at).normals.mean(axis=1).T)
        if not lost:
            return None
        images = {channel: pixels.reshape(size, size, 4) for channel, pixels in flat.items()}
        covered, known = covered.reshape(size, size), known.reshape(size, size)
        # A texel that is lost has a bent normal already, its own normal; its bent cone gets the same direction.
        fill_texels([images[channel] for channel in CHANNELS[self.settings.bounces]], covered, known)
        tracer.fill_cones(flat, np.concatenate(lost), unit(np.concatenate(lost_normals)), self.world_to_object)
        tile = Tile(images, None if colours is None else colours.reshape(size, size, 3))
        faces = None
        if self.settings.margin and self.settings.margin_type == "ADJACENT_FACES":
            faces = AdjacentFaces(triangle_uv, self.surface.vertex_triangles, covered, self.settings.margin)
        # Across a seam the tangent space is another one.
        local = {BENT_NORMAL} if self.bent_normals is not None and self.bent_normals.is_tangent else set()
        extended = [images[channel] for channel in images.keys() - local]
        extended += [] if tile.albedo is None else [tile.albedo]
        extend_margin(extended, covered, self.settings.margin, threads, faces)
        extend_margin([images[channel] for channel in local], covered, self.settings.margin, threads)
        return tile


def _in_tile(triangle_uv: NDArray[np.float64], number: int) -> NDArray[np.float64]:
    """UVs (m, 3, 2) as the tile of that ``number`` has them."""
    return triangle_uv - ((number - 1001) % 10, (number - 1001) // 10)
