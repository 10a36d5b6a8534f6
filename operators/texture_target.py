# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to images: the texels of a UV map, a band of rows at a time."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.adjacent_faces import AdjacentFaces
from ..core.albedo import Albedo
from ..core.exr import write_exr
from ..core.fill import fill_texels
from ..core.margin import extend_margin
from ..core.projection import ProjectedPoints
from ..core.rasterise import bands, rasterise
from ..core.sample_points import PROBES, CornerTable, TexelPoints, spread_points, texel_places
from ..core.surface import Surface, unit
from ..core.whole_files import whole_files
from ..core.workers import Workers, mapped, slices
from .derived_maps import colour_space, derive, extension, write_map
from .high_to_low import Projection
from .images import file_metadata, file_path, map_names, store_file, store_image
from .mesh_reader import linear_inverse
from .names import CHANNELS
from .report import BakeError, ObjectReport
from .settings import BakeSettings
from .tracer import LIGHT_SHARE, Tracer
from .uv_layout import check_layout, expected_texels, overlaps

# Texels whose channels a thread computes together.
TEXELS_PER_PART = 2**15


@dataclass(frozen=True)
class TextureResult:
    """Images (h, w, 4) of one object by channel, ready to be stored in ``folder``, or packed where that is empty; and
    the base colour (h, w, 3), where a map needs it."""

    obj: bpy.types.Object
    uv_map: str
    folder: str
    settings: BakeSettings
    channels: dict[str, NDArray[np.float32]]
    albedo: NDArray[np.float32] | None

    def write(self) -> list[str]:
        """Store the images; returns their files or names. Raises OSError where a file cannot be written."""
        maps = map_names(self.settings)
        if not self.folder:
            stored = [store_image(self.obj, channel, pixels, "") for channel, pixels in self.channels.items()]
            with TemporaryDirectory() as folder:
                paths = [Path(folder) / f"{number}{extension(self.settings)}" for number in range(len(maps))]
                self._write_maps(dict(zip(maps, paths, strict=True)))
                return stored + self._store_maps(dict(zip(maps, paths, strict=True)), is_packed=True)
        files = {channel: file_path(self.obj, channel, self.folder) for channel in self.channels}
        files |= {name: file_path(self.obj, name, self.folder, extension(self.settings)) for name in maps}
        # All files before any of them takes its name, and before any image: where one cannot be written, the disk and
        # the .blend stay as they were.
        with whole_files(*files.values()) as parts:
            parts = dict(zip(files, parts, strict=True))
            for channel, pixels in self.channels.items():
                write_exr(
                    parts[channel],
                    pixels,
                    half=self.settings.color_depth == "16",
                    codec=self.settings.exr_codec,
                    metadata=self._metadata(channel),
                )
            self._write_maps({name: parts[name] for name in maps})
        stored = [store_image(self.obj, channel, pixels, self.folder) for channel, pixels in self.channels.items()]
        return stored + self._store_maps({name: files[name] for name in maps}, is_packed=False)

    def _write_maps(self, paths: dict[str, Path]) -> None:
        for name, path in paths.items():
            write_map(path, name, derive(name, self.channels, self.albedo), self.settings, self._metadata(name))

    def _store_maps(self, paths: dict[str, Path], is_packed: bool) -> list[str]:
        return [
            store_file(self.obj, name, path, colour_space(name, self.settings), is_packed)
            for name, path in paths.items()
        ]

    def _metadata(self, channel: str) -> dict[str, str]:
        return file_metadata(self.obj, channel, self.uv_map, self.settings)


def bake_texture(
    obj: bpy.types.Object,
    surface: Surface,
    uv_map: str,
    matrix: NDArray,
    tracer: Tracer,
    report: ObjectReport,
    settings: BakeSettings,
    folder: str,
    projection: Projection | None,
    albedo: Albedo | None,
    threads: int | None,
) -> Generator[float, None, TextureResult]:
    """Bake the texels of ``obj``, whose evaluated ``surface`` has the UVs of ``uv_map``; yields the fraction done.

    ``matrix`` (4, 4) places the object; its texels show its own surface, or that of a ``projection``; ``albedo``
    of its triangles is kept for the maps; ``threads`` rasterise. Raises BakeError where the UV map leaves nothing to
    bake.
    """
    triangle_uv = surface.corner_uv[surface.triangles]
    report.warnings += check_layout(triangle_uv, uv_map)

    size = settings.resolution
    world_to_object = linear_inverse(matrix)
    images = {channel: np.zeros((size * size, 4), np.float32) for channel in CHANNELS[settings.bounces]}
    colours = None if albedo is None else np.zeros((size * size, 3), np.float32)
    f0, lost, lost_normals = [], [], []
    covered, known = np.zeros((2, size * size), bool)
    places = texel_places(settings.samples)
    corners = CornerTable(surface)
    shown, extent, cage = corners, surface.extent, None
    if projection is not None:
        shown, extent = projection.high.corners, projection.high.extent
        if projection.cage is not None:
            cage = CornerTable(replace(surface, vertices=projection.cage))
    lighting = tracer.light(spread_points(shown, PROBES), expected_texels(triangle_uv, size), extent)
    cache = yield from mapped(lighting, lambda done: LIGHT_SHARE * done)
    begin = LIGHT_SHARE if cache else 0.0
    for first, last in bands(size, size, places):
        texels = rasterise(triangle_uv, size, size, places, (first, last), threads)
        if not len(texels.texel):
            continue
        points = TexelPoints(corners, texels, size)
        if projection is not None:
            points = ProjectedPoints(points, projection.high, cage and TexelPoints(cage, texels, size))
        tracing = tracer.visibility(points, extent, cache)
        rows = (last - first) / len(texels.texel)

        def fraction(done: int, first=first, rows=rows) -> float:
            return begin + (1.0 - begin) * (first + done * rows) / size

        visibility = yield from mapped(tracing, fraction)

        def fill(part: slice, texels=texels, texel=texels.texel, visibility=visibility) -> None:
            for channel, values in tracer.channels(visibility[part], world_to_object).items():
                images[channel][texel[part]] = values
            covered[texel[part]] = True
            known[texel[part]] = ~visibility.lost[part]
            if albedo is not None:
                triangle, weights = texels.triangle[part], texels.weights[part].reshape(-1, 2).T
                values = albedo.at(triangle.reshape(-1), *weights)
                colours[texel[part]] = values.reshape(*triangle.shape, 3).mean(axis=1)

        with Workers(threads) as workers:
            workers.map(fill, slices(len(texels.texel), TEXELS_PER_PART))
        report.points += len(texels.texel)
        f0.append(visibility.f0[~visibility.lost])
        at = np.flatnonzero(visibility.lost)
        lost.append(texels.texel[at])
        lost_normals.append(points.at(at).normals.mean(axis=2).T)
    if not report.points:
        raise BakeError(f"touches no texel in UV map '{uv_map}': pack its islands (UV > Pack Islands)")
    if overlaps(triangle_uv, report.points, size):
        report.warnings.append(
            f"UV map '{uv_map}' overlaps itself: where faces share texels, one of them decides their colour"
        )
    report.tell_f0(np.concatenate(f0), "texels", projection is not None)

    shaped = {channel: pixels.reshape(size, size, 4) for channel, pixels in images.items()}
    covered, known = covered.reshape(size, size), known.reshape(size, size)
    fill_texels(list(shaped.values()), covered, known)
    tracer.fill_cones(images, np.concatenate(lost), unit(np.concatenate(lost_normals)), world_to_object)
    images = shaped
    faces = None
    if settings.margin and settings.margin_type == "ADJACENT_FACES":
        faces = AdjacentFaces(triangle_uv, surface.vertex_triangles, size, size)
    colours = None if colours is None else colours.reshape(size, size, 3)
    extended = [*images.values(), *([] if colours is None else [colours])]
    extend_margin(extended, covered, settings.margin, threads, faces)
    return TextureResult(obj, uv_map, folder, settings, images, colours)
