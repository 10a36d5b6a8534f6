# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao bake SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time

import bpy

from .bake_job import bake
from .command_scene import DONE, NOT_ALL_DONE, UsageError, add_command, no_object, open_scene, save_scene, write_report
from .occluder_reader import rendered_objects
from .progress import StderrProgress, drive
from .report import BakeError, ObjectReport, bake_report, count_text
from .settings import BakeSettings
from .version import extension_version


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``bake``."""
    command = add_command(
        commands,
        "bake",
        help="bake the meshes of a .blend",
        description="Bake the meshes of SCENE.blend that are enabled in renders, or those named by --object.",
        object_help="bake this object; may be given again",
        failure="something could not be baked (the rest is done and kept)",
    )
    command.set_defaults(run=_bake)


def _bake(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = open_scene(options)
    objects, missing = _objects(options.object)
    show = (lambda progress: None) if options.quiet else StderrProgress()
    settings = BakeSettings.of(scene)
    try:
        reports = drive(bake(bpy.context, objects, settings, store_each=True), show)
    except BakeError as error:
        reports = [ObjectReport(obj.name, settings.target, error=str(error)) for obj in objects]
    reports += [ObjectReport(name, settings.target, error=no_object(name)) for name in missing]

    baked = any(report.error is None for report in reports)
    saved = save_scene(options.save) if options.save is not None and baked else True
    if options.report is not None:
        write_report(
            options.report, bake_report(extension_version(), str(options.scene), time.perf_counter() - started, reports)
        )
    _tell(reports, options, baked)
    return DONE if saved and not any(report.error for report in reports) else NOT_ALL_DONE


def _objects(names: list[str] | None) -> tuple[list[bpy.types.Object], list[str]]:
    """The objects to bake, and the names among ``names`` that the view layer does not have."""
    view_layer = bpy.context.view_layer
    if names is None:
        rendered = rendered_objects(view_layer)
        objects = [obj for obj in view_layer.objects if obj.type == "MESH" and obj.data.polygons and obj in rendered]
        if not objects:
            raise UsageError(
                f"scene '{bpy.context.scene.name}' has no mesh with faces that is visible and enabled in renders"
            )
        return objects, []
    names = list(dict.fromkeys(names))
    found = [view_layer.objects[name] for name in names if name in view_layer.objects]
    return found, [name for name in names if name not in view_layer.objects]


def _tell(reports: list[ObjectReport], options: argparse.Namespace, baked: bool) -> None:
    """Print a line an object on stderr."""
    for report in reports:
        if report.error:
            print(f"Error: {report.error}", file=sys.stderr)
        elif not options.quiet:
            for warning in report.warnings:
                print(f"Warning: '{report.name}': {warning}", file=sys.stderr)
            if report.f0:
                print(
                    f"'{report.name}': {count_text(report.points)} points, {count_text(report.rays)} rays "
                    f"in {report.seconds:.2f} s, mean AO {report.f0['mean']:.4f}",
                    file=sys.stderr,
                )
    if baked and options.save is None and not options.quiet:
        print("The .blend was not saved: add --save to keep the bake in it", file=sys.stderr)
