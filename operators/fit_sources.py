# SPDX-License-Identifier: GPL-3.0-or-later
"""What bounce curves are simulated on: a mesh object as it is evaluated among its occluders, or an image's relief.

Messages go on from "Object 'name' " or "Image 'name' ".
"""

from __future__ import annotations

from collections.abc import Collection, Generator
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.area_mean import area_mean, fitting_shape
from ..core.height_map import HeightMap
from ..core.rays import Occluders
from ..core.sample_points import CornerTable
from ..core.simulation import MOST_RAYS, Simulation, simulate_height_map, simulate_mesh
from ..core.surface import Surface, extent_of, unit
from ..core.workers import in_thread
from .occluder_reader import read_occluders
from .occluder_scenes import OccluderScenes
from .report import BakeError

# On average this many in each of a hundred bins are enough for smooth curves; large height maps are scaled down to so
# many pixels. Fewer where the samples are so many that the rays would pass MOST_RAYS: each point of a mesh may count
# for four.
MESH_POINTS = 2**14
IMAGE_POINTS = 2**16


@dataclass(frozen=True)
class FitSettings:
    """A copy of those settings that a fit reads, at the moment it starts."""

    samples: int
    occluders: str
    use_ground_plane: bool
    seed: int
    height_map_amplitude: float
    output_directory: str

    @classmethod
    def of(cls, scene: bpy.types.Scene) -> FitSettings:
        return cls(**{name: getattr(scene.multibounce_ao, name) for name in cls.__dataclass_fields__})


def simulate_object(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    settings: FitSettings,
    selected: Collection[bpy.types.Object],
    warnings: list[str],
    threads: int | None = None,
) -> Generator[float, None, Simulation]:
    """Simulate a mesh object with its modifiers and the instances it makes, flat as its faces are.

    Light is blocked by, and comes off, what the settings name, as in a bake: ``selected`` with the occluders
    'SELECTED'. Yields the fraction done; appends to ``warnings``. Raises BakeError.
    """
    if obj.type != "MESH":
        raise BakeError("is not a mesh: choose a mesh, or a height map")
    if obj.mode == "EDIT":
        raise BakeError("is in Edit Mode: leave it first")
    if not obj.visible_get(view_layer=context.view_layer):
        raise BakeError("is hidden in the viewport: show it first")
    depsgraph = context.evaluated_depsgraph_get()
    vertices, triangles, found = read_occluders(depsgraph, {obj})
    warnings += found
    scenes = OccluderScenes(context, [obj], selected, settings)
    others, other_triangles, found = read_occluders(depsgraph, scenes.owners_for(obj) - {obj})
    warnings += found
    return (
        yield from in_thread(
            _simulate(vertices, triangles, others, other_triangles, scenes.ground_height, settings, threads)
        )
    )


def _simulate(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int32],
    others: NDArray[np.float64],
    other_triangles: NDArray[np.int32],
    ground_height: float | None,
    settings: FitSettings,
    threads: int | None,
) -> Generator[float, None, Simulation]:
    """Simulate ``triangles`` of ``vertices`` among ``other_triangles`` of ``others``."""
    yield 0.0
    corners = CornerTable(_flat_surface(vertices, triangles))
    if not corners.areas().sum() > 0.0:
        raise BakeError("has no faces with an area: add some, or choose another object")
    used = vertices[triangles].reshape(-1, 3)
    occluders = Occluders(
        np.concatenate((vertices, others)),
        np.concatenate((triangles, other_triangles + len(vertices))),
        ground_height,
        centre=0.5 * (used.min(axis=0) + used.max(axis=0)),
    )
    return (
        yield from simulate_mesh(
            occluders,
            corners,
            points=min(MESH_POINTS, MOST_RAYS // (4 * settings.samples)),
            samples=settings.samples,
            extent=extent_of(vertices, triangles),
            seed=settings.seed,
            threads=threads,
        )
    )


def simulate_image(
    image: bpy.types.Image, settings: FitSettings, warnings: list[str], threads: int | None = None
) -> Generator[float, None, Simulation]:
    """Simulate the relief of ``image``, which repeats without end; as :func:`simulate_object`."""
    heights = _read_heights(image)
    shape = fitting_shape(heights.shape, min(IMAGE_POINTS, MOST_RAYS // settings.samples))
    if shape != heights.shape:
        warnings.append(
            f"Simulated at {shape[1]} x {shape[0]} pixels, the means of its {image.size[0]} x {image.size[1]}"
        )
        heights = area_mean(heights, shape)
    height_map = HeightMap(heights, settings.height_map_amplitude)
    simulating = simulate_height_map(height_map, samples=settings.samples, seed=settings.seed, threads=threads)
    return (yield from in_thread(simulating))


def _flat_surface(vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> Surface:
    """Triangles (m, 3) that each have their own normal."""
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    count = len(triangles)
    return Surface(
        vertices=vertices,
        corner_vertex=triangles.ravel(),
        corner_normals=np.repeat(unit(np.cross(b - a, c - a)), 3, axis=0),
        triangles=np.arange(3 * count, dtype=np.int32).reshape(-1, 3),
        face_start=np.arange(0, 3 * count, 3, dtype=np.int32),
        face_size=np.full(count, 3, np.int32),
    )


def _read_heights(image: bpy.types.Image) -> NDArray[np.float64]:
    """(h, w), bottom row first: the mean of the colours as they are stored. Raises BakeError."""
    width, height = image.size
    if not width * height:
        raise BakeError("has no pixels: reload it from its file, or choose another")
    if min(width, height) < 2:
        raise BakeError(f"is {width} x {height} pixels: choose one of 2 x 2 or more")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(height, width, image.channels)
    heights = pixels[..., : 3 if image.channels >= 3 else 1].mean(axis=-1, dtype=np.float64)
    if not np.isfinite(heights).all():
        raise BakeError("has pixels that are not finite numbers: paint over them, or choose another")
    return heights
