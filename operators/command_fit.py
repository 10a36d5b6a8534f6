# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao fit SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time

import bpy

from .command_files import UsageError, keep
from .command_scene import add_command, exit_code, given_settings, no_object, open_scene, progress_for
from .fit_bounces import fit_source, summary
from .fit_job import FitReport, fit_bounces
from .fit_sources import FitSettings
from .progress import drive
from .report import BakeError


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``fit``."""
    add_command(
        commands,
        "fit",
        _fit,
        help="fit the bounce curves of a surface",
        description=(
            "Simulate light that bounces on a surface of SCENE.blend, fit the curves of Multibounce AO Fit to it, and "
            "keep the fit on the scene, with its curves as CSV and as a plot. The surface is the object named by "
            "--object, or the height map of the settings (--set height_map=IMAGE), or else the active object. An "
            "object stands among its occluders: --set occluders=SELF takes it alone, SELECTED with what is selected in "
            "the .blend, and --set use_ground_plane=on puts a floor under it."
        ),
        object_help="simulate this mesh object",
        failure="the surface could not be fitted or the .blend not saved",
    )


def _fit(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = open_scene(options)
    with given_settings(scene, options):
        source, settings = _source(options.object), FitSettings.of(scene)
    show = progress_for(options)
    if isinstance(source, str):
        report = FitReport(source, "MESH", error=no_object(source))
    else:
        try:
            selected = [obj for obj in bpy.context.view_layer.objects if obj.select_get()]
            report = drive(fit_bounces(bpy.context, source, settings, selected=selected), show)
        except BakeError as error:
            report = FitReport.of(source, error=str(error))

    kept = keep(options, [report], started)
    _tell(report, options)
    return exit_code(kept, [report])


def _source(names: list[str] | None) -> bpy.types.Object | bpy.types.Image | str:
    """What to simulate; the name of the object that was asked for where the view layer has none. Raises UsageError."""
    if names is None:
        source = fit_source(bpy.context)
        if source is None:
            raise UsageError(
                f"the active object of scene '{bpy.context.scene.name}' is no mesh: "
                "name one with --object, or choose a height map with --set height_map=IMAGE"
            )
        return source
    if len(names) > 1:
        raise UsageError(f"--object {names[1]}: name one object, as a scene keeps one fit")
    return bpy.context.view_layer.objects.get(names[0]) or names[0]


def _tell(report: FitReport, options: argparse.Namespace) -> None:
    """Print on stderr what was found, and where it is."""
    if report.error:
        print(f"Error: {report.error}", file=sys.stderr)
    elif not options.quiet:
        for warning in report.warnings:
            print(f"Warning: '{report.name}': {warning}", file=sys.stderr)
        print(summary(report), file=sys.stderr)
        for output in report.outputs:
            print(f"  {output}", file=sys.stderr)
        if options.save is None:
            print("The .blend was not saved: add --save to keep the fit in it", file=sys.stderr)
