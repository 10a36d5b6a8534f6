# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao field SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time

import bpy

from .bake_field import field_source, summary
from .command_files import UsageError, keep
from .command_scene import (
    add_command,
    exit_code,
    given_settings,
    named_objects,
    names_set,
    no_object,
    open_scene,
    progress_for,
)
from .field_job import FieldReport, FieldSettings, bake_object_field
from .progress import drive
from .report import BakeError


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``field``."""
    add_command(
        commands,
        "field",
        _field,
        help="bake the AO fields of objects",
        description=(
            "Bake what objects of SCENE.blend block of the sky all around them: into node groups of the .blend and, "
            "with --set output_directory=FOLDER, into OpenEXR cubemaps and JSON. The objects are those named by "
            "--object, or else the active one."
        ),
        object_help="bake the field of this object, or of meshes that a pattern like 'Tree*' names; may be given again",
        failure="something could not be baked (the rest is done and kept) or the .blend not saved",
    )


def _field(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = open_scene(options)
    with given_settings(scene, options):
        settings = FieldSettings.of(scene)
    objects, missing = ([_active()], []) if options.object is None else named_objects(options.object)
    reports = [_bake(obj, settings, options) for obj in objects]
    reports += [FieldReport(name, error=no_object(name)) for name in missing]

    baked = any(report.error is None for report in reports)
    kept = keep(options, reports, started)
    _tell(reports, options, baked)
    return exit_code(kept, reports)


def _active() -> bpy.types.Object:
    """The active mesh. Raises UsageError."""
    source = field_source(bpy.context)
    if source is None:
        raise UsageError(f"the active object of scene '{bpy.context.scene.name}' is no mesh: name some with --object")
    return source


def _bake(obj: bpy.types.Object, settings: FieldSettings, options: argparse.Namespace) -> FieldReport:
    try:
        work = bake_object_field(bpy.context, obj, settings, fixed=names_set(options))
        return drive(work, progress_for(options))
    except BakeError as error:
        return FieldReport(obj.name, error=str(error))


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
