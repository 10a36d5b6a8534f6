# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from start to end, as a generator: the operator, the command line and the tests drive the same one.

scene -> occluders and sample points -> rays -> channels -> attributes or images -> material nodes. Unless asked
otherwise everything is computed before anything is written, so closing the generator at any yield leaves the scene as
it was.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Generator
from dataclasses import replace
from functools import partial

import bpy
import numpy as np

from ..core.rays import Occluders
from ..core.workers import mapped
from .bake_record import record_bake
from .base_color import read_own_albedo
from .high_to_low import pairs, read_projection
from .images import check_image_names, image_channels, is_nowhere, output_folder
from .mesh_reader import evaluated_mesh, read_surface
from .names import CHANNELS
from .object_checks import check_evaluated, check_object
from .occluder_scenes import OccluderScenes
from .progress import Progress
from .report import BakeError, ObjectReport
from .settings import BakeSettings
from .texture_result import TextureResult
from .texture_target import bake_texture
from .tracer import Tracer
from .uv_layout import uv_map_name
from .vertex_target import VertexResult, bake_vertices, check_attribute_names, vertex_points


def bake(
    context: bpy.types.Context,
    objects: list[bpy.types.Object],
    settings: BakeSettings,
    threads: int | None = None,
    *,
    selected: Collection[bpy.types.Object] = (),
    store_each: bool = False,
) -> Generator[Progress, None, list[ObjectReport]]:
    """Bake ``objects`` (meshes of the context's view layer) and return a report for each, in their order.

    An object that cannot be baked has its ``error`` set, and the others are done. Raises BakeError where the settings
    allow no bake at all. With Selected to Active the first of ``objects`` is the active one, and reports are of those
    that are baked to.

    threads     default one a core; it changes no bit of the result
    selected    what else blocks light with the occluders 'SELECTED'
    store_each  write each object when it is done, not all at the end: memory is that of one object's result, and
                closing the generator keeps those
    """
    sources = pairs(objects, selected, settings)
    objects = objects if sources is None else list(sources)
    warnings = []
    if settings.target == "TEXTURE" and is_nowhere(settings.output_directory):
        warnings.append(
            f"Output '{settings.output_directory}' is relative to a .blend that is not saved yet: "
            "the images were packed in it instead. Save it and bake again for files"
        )
    folder = output_folder(settings.output_directory) if settings.target == "TEXTURE" and not warnings else ""
    reports = [
        ObjectReport(obj.name, settings.target, samples=settings.samples, warnings=[*warnings]) for obj in objects
    ]
    done: list[tuple[bpy.types.Object, ObjectReport, VertexResult | TextureResult | None]] = []
    scenes = OccluderScenes(context, objects, selected, settings, sources)
    tracer = partial(Tracer, settings=settings, threads=threads)
    baked_meshes: dict[bpy.types.Mesh, ObjectReport] = {}
    for index, (obj, report) in enumerate(zip(objects, reports, strict=True)):
        started = time.perf_counter()
        yield Progress(index / len(objects), obj.name)
        result = None
        if settings.target == "VERTEX" and obj.data in baked_meshes:
            _share(baked_meshes[obj.data], report, settings.bounces)
        else:
            partners = None if sources is None else sources[obj]
            work = _bake_object(context, obj, partners, settings, folder, scenes, tracer, report, threads)
            try:
                result = yield from mapped(work, partial(_progress, index, len(objects), report))
            except BakeError as error:
                report.error = f"Object '{obj.name}' {error}"
                continue
            baked_meshes[obj.data] = report
            report.rays = report.points * settings.samples
        report.seconds = round(time.perf_counter() - started, 3)
        done.append((obj, report, result))
        if store_each:
            _store(*done.pop(), settings)

    for obj, report, result in done:
        _store(obj, report, result, settings)
    return reports


def _share(baked: ObjectReport, report: ObjectReport, bounces: str) -> None:
    """Fill the ``report`` of an object that shows the bake of another, because they share a mesh."""
    report.points, report.f0, report.outputs = baked.points, baked.f0, list(CHANNELS[bounces])
    report.warnings.append(
        f"Shares its mesh with '{baked.name}', whose bake it shows: "
        "for its own, make it single-user (Object > Relations > Make Single User)"
    )


def _progress(index: int, count: int, report: ObjectReport, part: float) -> Progress:
    return Progress((index + part) / count, report.name, report.note)


def _bake_object(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    partners: Collection[bpy.types.Object] | None,
    settings: BakeSettings,
    folder: str,
    scenes: OccluderScenes,
    tracer: Callable[[Occluders], Tracer],
    report: ObjectReport,
    threads: int | None,
) -> Generator[float, None, VertexResult | TextureResult]:
    """Compute the bake of one object, of its own surface or of that of its ``partners``; yields the fraction done.
    Raises BakeError."""
    check_object(obj, context.view_layer)
    tracer = tracer(scenes.scene_for(obj, report.warnings))
    if settings.bounces == "RADIOSITY":
        tracer = replace(tracer, albedo=scenes.albedo(report.warnings))
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    matrix = np.array(evaluated.matrix_world, np.float64)
    albedo = None
    if settings.target == "TEXTURE" and settings.use_colored_ao_map and settings.bounces != "RADIOSITY":
        albedo = read_own_albedo(evaluated, matrix, report.warnings)
    # Blender's mesh is only held while it is read: it may be gone after a yield.
    with evaluated_mesh(evaluated) as mesh:
        check_evaluated(mesh, matrix)
        projection = None if partners is None else read_projection(context, obj, mesh, partners, settings)
        if settings.target == "VERTEX":
            check_attribute_names(obj, settings.bounces)
            points = vertex_points(obj, mesh, matrix, projection and projection.cage)
            work = bake_vertices(obj.data, points, matrix, tracer, report, projection)
        else:
            check_image_names(obj, image_channels(settings))
            uv_map = uv_map_name(mesh, settings.uv_map)
            surface = read_surface(mesh, matrix, uv_map)
            shown = projection, albedo
            work = bake_texture(obj, surface, uv_map, matrix, tracer, report, settings, folder, *shown, threads)
    return (yield from work)


def _store(
    obj: bpy.types.Object,
    report: ObjectReport,
    result: VertexResult | TextureResult | None,
    settings: BakeSettings,
) -> None:
    """Write the result, plug the nodes in, and leave the record of the bake on ``obj``; None: its mesh has it."""
    try:
        if result is not None:
            report.outputs = result.write()
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        report.error = (
            f"Object '{obj.name}' cannot be stored in '{result.folder}' ({reason}): choose another output folder"
        )
        return
    record_bake(obj, settings, report, result.uv_map if isinstance(result, TextureResult) else None)
