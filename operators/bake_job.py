# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from start to end, as a generator: the operator, the command line and the tests drive the same one.

scene -> occluders and sample points -> rays -> channels -> attributes or images -> material nodes. Unless asked
otherwise everything is computed before anything is written, so closing the generator at any yield leaves the scene as
it was. What takes long runs in threads that know nothing of Blender's data. Between yields the artist may do anything
but undo or open another file: what became of the objects is found out before they are read, and again before they are
written.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Collection, Generator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from tempfile import gettempdir

import bpy
import numpy as np

from ..core.workers import in_thread, mapped
from .bake_record import baked_fingerprint, baked_source, record_bake, tell_of_record
from .base_color import read_own_albedo
from .bent_normal_map import read_bent_normal_map
from .fingerprint import fingerprint
from .high_to_low import pairs, read_projection
from .images import check_image_names, image_channels, is_nowhere, output_folder
from .mesh_reader import evaluated_mesh, read_mesh
from .names import CHANNELS
from .object_checks import check_evaluated, check_object
from .occluder_scenes import OccluderScenes
from .overrides import Overrides
from .preview import Preview
from .progress import Progress
from .report import BakeError, ObjectReport
from .settings import BakeSettings
from .texture_result import TextureResult
from .texture_target import bake_texture
from .tracer import RayCount, Tracer
from .uv_layout import uv_map_name
from .version import extension_version
from .vertex_target import VertexResult, bake_vertices, check_attribute_names, read_vertices

_Baked = tuple[bpy.types.Object, ObjectReport, VertexResult | TextureResult | None, bytes, BakeSettings]


def bake(
    context: bpy.types.Context,
    objects: list[bpy.types.Object],
    settings: BakeSettings,
    threads: int | None = None,
    *,
    selected: Collection[bpy.types.Object] = (),
    store_each: bool = False,
    resume: bool = False,
    share: tuple[int, int] = (1, 1),
    fixed: Collection[str] = (),
    preview: Preview | None = None,
) -> Generator[Progress, None, list[ObjectReport]]:
    """Bake ``objects`` (meshes of the context's view layer) with ``settings``, and what they and their collections
    override of them; return a report for each, in their order.

    An object that cannot be baked has its ``error`` set, and the others are done. Raises BakeError where the settings
    allow no bake at all. With Selected to Active the first of ``objects`` is the active one, and reports are of those
    that are baked to.

    threads     default one a core; it changes no bit of the result
    selected    what else blocks light with the occluders 'SELECTED'
    store_each  write each object when it is done, not all at the end: memory is that of one object's result, and
                closing the generator keeps those
    resume      leave an object as it is that has its bake already, with the same settings and the same geometry and
                colours around
    share       (i, n): bake the i-th of n shares of ``objects``, counted from 1, to the bits that a bake of all gives;
                a share may be empty
    fixed       names of settings that nothing overrides
    preview     shows how far it is; the result is the same with it
    """
    sources = pairs(objects, selected, settings)
    objects = objects if sources is None else list(sources)
    colours = settings.bounces == "RADIOSITY"
    overrides = Overrides(context.view_layer, fixed)
    own = {obj: overrides.settings_for(obj, settings) for obj in objects}
    scenes = OccluderScenes(context, objects, selected, settings, sources, colours=colours, own=own)
    objects = _share_of(objects, *share)
    settings_of = [own[obj] for obj in objects]
    reports = [
        ObjectReport(obj.name, each.target, samples=each.samples)
        for obj, each in zip(objects, settings_of, strict=True)
    ]
    folder = _folder(settings.output_directory, [report for report in reports if report.target == "TEXTURE"])
    done: list[_Baked] = []
    count = RayCount()
    baked_meshes: dict[bpy.types.Mesh, tuple[ObjectReport, BakeSettings]] = {}
    if preview is not None:
        preview.objects = len(objects)
        # Not where one has a scene of its own, which would be built twice.
        if len(objects) > 1 and sources is None and all(each.occluders != "SELF" for each in settings_of):
            yield from _sketches(context, {obj: own[obj] for obj in objects}, scenes, threads, count, preview)
    ends = _ends(objects, settings_of)
    for obj, chosen, report, begin, end in zip(objects, settings_of, reports, [0.0, *ends], ends, strict=False):

        def progress(part: float, report=report, begin=begin, end=end) -> Progress:
            return Progress(begin + (end - begin) * part, report.name, count.rays, note=report.note)

        started = time.perf_counter()
        yield progress(0.0)
        try:
            if chosen.target == "VERTEX" and obj.data in baked_meshes:
                result, mark = None, b""
                baked, baked_with = baked_meshes[obj.data]
                _share(baked, report, chosen.bounces)
                report.left = baked.left if baked_source(obj) is not None else None
                chosen = replace(baked_with, use_material_nodes=chosen.use_material_nodes)
            else:
                known, partners = baked_fingerprint(obj) if resume else b"", sources and sources[obj]
                how = count, report, known, threads, preview
                work = _bake_object(context, obj, partners, chosen, folder, scenes, *how)
                result, mark = yield from mapped(work, progress)
                if chosen.target == "VERTEX":
                    baked_meshes[obj.data] = report, chosen
                if result is None:
                    tell_of_record(obj, report)
                    continue
                report.rays = report.points * chosen.samples
        except BakeError as error:
            report.error = f"Object '{report.name}' {error}"
            continue
        except ReferenceError:
            report.error = _deleted(report)
            continue
        except Exception as error:  # a fault of ours, or no memory: the other objects are still to be baked
            traceback.print_exc()
            report.error = _fault(report, error)
            continue
        report.seconds = round(time.perf_counter() - started, 3)
        done.append((obj, report, result, mark, chosen))
        if store_each:
            _store(*done.pop())

    if done:
        name = done[0][1].name if len(done) == 1 else f"{len(done)} objects"
        yield Progress(1.0, name, count.rays, ready=True)
    for each in done:
        _store(*each)
    return reports


def _folder(setting: str, textures: list[ObjectReport]) -> str:
    """Where the images of those reports go; empty where they are packed. Raises BakeError."""
    if not textures:
        return ""
    if not is_nowhere(setting):
        return output_folder(setting)
    for report in textures:
        report.warnings.append(
            f"Output '{setting}' is relative to a .blend that is not saved yet: "
            "the images were packed in it instead. Save it and bake again for files"
        )
    return ""


def _sketches(
    context: bpy.types.Context,
    settings_of: dict[bpy.types.Object, BakeSettings],
    scenes: OccluderScenes,
    threads: int | None,
    count: RayCount,
    preview: Preview,
) -> Generator[Progress, None, None]:
    """Show all objects in the ``preview``, each with its settings, before the first is baked. What is wrong with one is
    said when its turn comes."""
    preview.is_sketching = True
    for obj, settings in settings_of.items():
        with suppress(Exception):
            report = ObjectReport(obj.name, settings.target)
            work = _bake_object(context, obj, None, settings, "", scenes, count, report, b"", threads, preview)
            yield from mapped(work, lambda _, name=report.name: Progress(0.0, name))
    preview.is_sketching = False


def _share_of(objects: list[bpy.types.Object], index: int, count: int) -> list[bpy.types.Object]:
    """Every ``count``-th mesh's, from the ``index``-th on: objects that share a mesh share a bake, too."""
    mine = set(list(dict.fromkeys(obj.data for obj in objects))[index - 1 :: count])
    return [obj for obj in objects if obj.data in mine]


def _ends(objects: list[bpy.types.Object], settings: list[BakeSettings]) -> list[float]:
    """The fraction of the whole bake that is done after each of ``objects`` with its ``settings``, by how many rays it
    has, from face corners or texels. Meshes that are shared are baked to vertices once."""
    seen, rays = set(), []
    for obj, each in zip(objects, settings, strict=True):
        points = each.resolution**2
        if each.target == "VERTEX":
            corners = len(obj.data.loops) if obj.type == "MESH" else 0
            points = 0 if obj.data in seen else max(1, corners)
            seen.add(obj.data)
        rays.append(float(points * each.samples))
    return list(np.cumsum(rays) / max(1.0, np.sum(rays)))


def _deleted(report: ObjectReport) -> str:
    return f"Object '{report.name}' was deleted while the bake was running: bring it back with undo, and bake again"


def _fault(report: ObjectReport, error: Exception) -> str:
    return f"Object '{report.name}' could not be baked ({type(error).__name__}: {error}): report this"


def _share(baked: ObjectReport, report: ObjectReport, bounces: str) -> None:
    """Fill the ``report`` of an object that shows the bake of another, because they share a mesh."""
    report.points, report.f0, report.outputs = baked.points, baked.f0, list(CHANNELS[bounces])
    report.warnings.append(
        f"Shares its mesh with '{baked.name}', whose bake it shows: "
        "for its own, make it single-user (Object > Relations > Make Single User)"
    )


def _bake_object(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    partners: Collection[bpy.types.Object] | None,
    settings: BakeSettings,
    folder: str,
    scenes: OccluderScenes,
    count: RayCount,
    report: ObjectReport,
    known: bytes,
    threads: int | None,
    preview: Preview | None,
) -> Generator[float, None, tuple[VertexResult | TextureResult | None, bytes]]:
    """Compute the bake of one object, of its own surface or of that of its ``partners``; yields the fraction done,
    returns the result and the fingerprint of all that it was made from. No result where that is ``known``. Raises
    BakeError."""
    check_object(obj, context.view_layer)
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    matrix = np.array(evaluated.matrix_world, np.float64)
    albedo = None
    if settings.target == "TEXTURE" and settings.use_colored_ao_map and settings.bounces != "RADIOSITY":
        albedo = read_own_albedo(evaluated, matrix, report.warnings)
    # Blender's mesh is only held while it is read: it may be gone after a yield.
    with evaluated_mesh(evaluated) as mesh:
        check_evaluated(mesh, matrix)
        projected = None if partners is None else read_projection(context, obj, mesh, partners, settings)
        if settings.target == "VERTEX":
            check_attribute_names(obj, settings.bounces)
            cage = projected and projected.cage
            source = read_vertices(obj, mesh, matrix, cage)
            bake_with, shown, more = partial(bake_vertices, obj.data, source), (), (projected,)
            drawn, domain = (source.own, source.domain) if source.modified is None else (source.modified, "POINT")
            picture = preview and preview.of_vertices(obj, drawn, domain, settings)
        else:
            check_image_names(obj, image_channels(settings))
            uv_map = uv_map_name(mesh, settings.uv_map)
            source = drawn = read_mesh(mesh, uv_map=uv_map)
            bake_with = partial(bake_texture, obj, source, uv_map, matrix)
            shown = albedo, read_bent_normal_map(mesh, matrix, uv_map, settings)
            more = settings, folder, projected, *shown, threads
            picture = preview and preview.of_texels(obj, source, settings)
    occluders = yield from scenes.scene_for(obj, report.warnings, drawn)
    tracer = Tracer(occluders, settings, threads, count, scenes.albedo(report.warnings))
    work = bake_with(tracer, report, *more, picture)
    made_from = extension_version(), settings.as_property(), folder, scenes.key, tracer.albedo, matrix
    made_from = *made_from, source, projected, shown
    return (yield from in_thread(_unless_known(known, made_from, work)))


def _unless_known(
    known: bytes, made_from: tuple, work: Generator[float, None, VertexResult | TextureResult]
) -> Generator[float, None, tuple[VertexResult | TextureResult | None, bytes]]:
    """``work``, unless the fingerprint of what it is ``made_from`` is ``known``; and that fingerprint."""
    yield 0.0
    mark = fingerprint(*made_from)
    result = None if mark == known else (yield from work)
    return result, mark


def _store(
    obj: bpy.types.Object,
    report: ObjectReport,
    result: VertexResult | TextureResult | None,
    mark: bytes,
    settings: BakeSettings,
) -> None:
    """Write the result, plug the nodes in, and leave the record of the bake on ``obj``; None: its mesh has it."""
    try:
        if obj.data.is_editmode and settings.target == "VERTEX":
            raise BakeError("is in Edit Mode: leave it, and bake again")
        if result is not None:
            replaces = result.replaces() if isinstance(result, TextureResult) else []
            report.outputs = result.write()
            report.warnings += replaces
        record_bake(obj, settings, report, mark, result.uv_map if isinstance(result, TextureResult) else None)
    except BakeError as error:
        report.error = f"Object '{report.name}' {error}"
    except ReferenceError:
        report.error = _deleted(report)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        how = f"stored in '{result.folder}' ({reason}): choose another output folder"
        if not result.folder:
            how = f"packed by way of the temporary folder '{gettempdir()}' ({reason}): make room there"
        report.error = f"Object '{report.name}' cannot be {how}"
    except Exception as error:  # a fault of ours: the other objects are still to be stored
        traceback.print_exc()
        report.error = _fault(report, error)
