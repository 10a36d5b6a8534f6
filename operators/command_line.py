# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao bake SCENE.blend ...``"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

import bpy

from .bake_job import bake
from .occluder_reader import rendered_objects
from .progress import StderrProgress, drive
from .report import BakeError, ObjectReport, bake_report, count_text
from .settings import BakeSettings, set_from_text
from .version import extension_version

DONE, NOT_ALL_BAKED, WRONG_USAGE = 0, 1, 2


class UsageError(Exception):
    """What was asked for cannot be understood or found; exit code 2."""


def run(arguments: list[str]) -> int:
    """The command with its ``arguments``; returns the exit code."""
    try:
        options = _parser().parse_args(arguments)
    except SystemExit as wanted:  # argparse has printed the help or what is wrong
        return int(wanted.code or DONE)
    try:
        return options.run(options)
    except UsageError as error:
        print(f"multibounce_ao: {error}", file=sys.stderr)
        return WRONG_USAGE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="blender --command multibounce_ao",
        description="Ambient occlusion, coloured as light is after many bounces.",
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    bake_command = commands.add_parser(
        "bake",
        help="bake the meshes of a .blend",
        description="Bake the meshes of SCENE.blend that are enabled in renders, or those named by --object.",
        epilog="Exit code: 0 done, 1 something could not be baked (the rest is done and kept), 2 wrong usage.",
    )
    bake_command.add_argument("scene", metavar="SCENE.blend", type=Path)
    bake_command.add_argument("--object", metavar="NAME", action="append", help="bake this object; may be given again")
    bake_command.add_argument(
        "--set",
        metavar="PROPERTY=VALUE",
        action="append",
        default=[],
        help="change a setting of scene.multibounce_ao, such as samples=64 or target=TEXTURE; may be given again",
    )
    bake_command.add_argument(
        "--save",
        metavar="FILE.blend",
        nargs="?",
        const="",
        help="save the .blend afterwards, under its own name or as FILE.blend",
    )
    bake_command.add_argument("--report", metavar="FILE.json", type=Path, help="write what was done as JSON")
    bake_command.add_argument("--quiet", action="store_true", help="print errors only")
    bake_command.set_defaults(run=_bake)
    return parser


def _bake(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    _open(options.scene)
    scene = bpy.context.scene
    for assignment in options.set:
        name, separator, value = assignment.partition("=")
        if not separator:
            raise UsageError(f"--set {assignment}: write it as PROPERTY=VALUE")
        try:
            set_from_text(scene.multibounce_ao, name, value)
        except ValueError as error:
            raise UsageError(f"--set {assignment}: {error}") from None
    objects, missing = _objects(options.object)
    show = (lambda progress: None) if options.quiet else StderrProgress()
    settings = BakeSettings.of(scene)
    try:
        reports = drive(bake(bpy.context, objects, settings, store_each=True), show)
    except BakeError as error:
        reports = [ObjectReport(obj.name, settings.target, error=str(error)) for obj in objects]
    reports += [ObjectReport(name, settings.target, error=_no_object(name)) for name in missing]

    baked = any(report.error is None for report in reports)
    saved = _save(options.save) if options.save is not None and baked else True
    if options.report is not None:
        _write_report(
            options.report, bake_report(extension_version(), str(options.scene), time.perf_counter() - started, reports)
        )
    _tell(reports, options, baked)
    return DONE if saved and not any(report.error for report in reports) else NOT_ALL_BAKED


def _open(path: Path) -> None:
    if not path.is_file():
        raise UsageError(f"there is no file '{path}'")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
    except RuntimeError as error:
        raise UsageError(f"'{path}' cannot be opened: {str(error).strip()}") from None


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


def _no_object(name: str) -> str:
    meshes = ", ".join(f"'{obj.name}'" for obj in bpy.context.view_layer.objects if obj.type == "MESH")
    return f"There is no object '{name}' in the view layer: choose among {meshes or 'none, it has no mesh'}"


def _save(name: str) -> bool:
    """Save the .blend as ``name``, or under its own if that is empty; prints why where it cannot be."""
    try:
        if name:
            bpy.ops.wm.save_as_mainfile(filepath=str(Path(name).resolve()), relative_remap=True)
        else:
            bpy.ops.wm.save_mainfile()
    except RuntimeError as error:
        print(f"Error: '{name or bpy.data.filepath}' cannot be saved: {str(error).strip()}", file=sys.stderr)
        return False
    return True


def _write_report(path: Path, report: dict) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"the report '{path}' cannot be written: {error.strerror}") from None


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


_handles: list[object] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("multibounce_ao", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
