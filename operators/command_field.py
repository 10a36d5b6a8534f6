# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao field SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable

import bpy

from .bake_field import field_source, summary
from .command_scene import DONE, NOT_ALL_DONE, UsageError, add_command, no_object, open_scene, save_scene, write_report
from .field_job import FieldReport, FieldSettings, bake_object_field
from .progress import Progress, StderrProgress, drive
from .report import BakeError, bake_report
from .version import extension_version


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``field``."""
    command = add_command(
        commands,
        "field",
        help="bake the AO fields of objects",
        description=(
            "Bake what objects of SCENE.blend block of the sky all around them: into node groups of the .blend and, "
            "with --set output_directory=FOLDER, into OpenEXR cubemaps and JSON. The objects are those named by "
            "--object, or else the active one."
        ),
        object_help="bake the field of this mesh object; may be given again",
        failure="something could not be baked (the rest is done and kept) or the .blend not saved",
    )
    command.set_defaults(run=_field)


def _field(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = open_scene(options)
    names = list(dict.fromkeys(options.object)) if options.object is not None else [_active().name]
    settings = FieldSettings.of(scene)
    reports = [_bake(name, settings, (lambda step: None) if options.quiet else StderrProgress()) for name in names]

    baked = any(report.error is None for report in reports)
    saved = save_scene(options.save) if options.save is not None and baked else True
    if options.report is not None:
        seconds = time.perf_counter() - started
        write_report(options.report, bake_report(extension_version(), str(options.scene), seconds, reports))
    _tell(reports, options, baked)
    return DONE if saved and not any(report.error for report in reports) else NOT_ALL_DONE


def _active() -> bpy.types.Object:
    """The active mesh. Raises UsageError."""
    source = field_source(bpy.context)
    if source is None:
        raise UsageError(f"the active object of scene '{bpy.context.scene.name}' is no mesh: name some with --object")
    return source


def _bake(name: str, settings: FieldSettings, show: Callable[[Progress], None]) -> FieldReport:
    obj = bpy.context.view_layer.objects.get(name)
    if obj is None:
        return FieldReport(name, error=no_object(name))
    try:
        return drive(bake_object_field(bpy.context, obj, settings), show)
    except BakeError as error:
        return FieldReport(name, error=str(error))


def _tell(reports: list[FieldReport], options: argparse.Namespace, baked: bool) -> None:
    """Print on stderr what was baked, and where it is."""
    for report in reports:
        if report.error:
            print(f"Error: {report.error}", file=sys.stderr)
        elif not options.quiet:
            for warning in report.warnings:
                print(f"Warning: '{report.name}': {warning}", file=sys.stderr)
            print(summary(report), file=sys.stderr)
            for output in report.outputs:
                print(f"  {output}", file=sys.stderr)
    if baked and options.save is None and not options.quiet:
        print("The .blend was not saved: add --save to keep the fields in it", file=sys.stderr)
