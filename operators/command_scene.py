# SPDX-License-Identifier: GPL-3.0-or-later
"""What all commands share: their options, the .blend that they open and save, and the report."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import bpy

from .settings import set_from_text

DONE, NOT_ALL_DONE, WRONG_USAGE = 0, 1, 2


class UsageError(Exception):
    """What was asked for cannot be understood or found; exit code 2."""


def add_command(
    commands: argparse._SubParsersAction, name: str, *, help: str, description: str, object_help: str, failure: str
) -> argparse.ArgumentParser:
    """A command with the options that all have; ``failure`` is what exit code 1 stands for."""
    command = commands.add_parser(
        name,
        help=help,
        description=description,
        epilog=f"Exit code: 0 done, 1 {failure}, 2 wrong usage.",
    )
    command.add_argument("scene", metavar="SCENE.blend", type=Path)
    command.add_argument("--object", metavar="NAME", action="append", help=object_help)
    command.add_argument(
        "--set",
        metavar="PROPERTY=VALUE",
        action="append",
        default=[],
        help="change a setting of scene.multibounce_ao, such as samples=64 or target=TEXTURE; may be given again",
    )
    command.add_argument(
        "--save",
        metavar="FILE.blend",
        nargs="?",
        const="",
        help="save the .blend afterwards, under its own name or as FILE.blend",
    )
    command.add_argument("--report", metavar="FILE.json", type=Path, help="write what was done as JSON")
    command.add_argument("--quiet", action="store_true", help="print errors only")
    return command


def open_scene(options: argparse.Namespace) -> bpy.types.Scene:
    """Open the .blend and change its settings as asked; returns its scene. Raises UsageError."""
    path = options.scene
    if not path.is_file():
        raise UsageError(f"there is no file '{path}'")
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
    except RuntimeError as error:
        raise UsageError(f"'{path}' cannot be opened: {str(error).strip()}") from None
    scene = bpy.context.scene
    for assignment in options.set:
        name, separator, value = assignment.partition("=")
        if not separator:
            raise UsageError(f"--set {assignment}: write it as PROPERTY=VALUE")
        try:
            set_from_text(scene.multibounce_ao, name, value)
        except ValueError as error:
            raise UsageError(f"--set {assignment}: {error}") from None
    return scene


def no_object(name: str) -> str:
    """What to say where the view layer has no object ``name``."""
    meshes = ", ".join(f"'{obj.name}'" for obj in bpy.context.view_layer.objects if obj.type == "MESH")
    return f"There is no object '{name}' in the view layer: choose among {meshes or 'none, it has no mesh'}"


def save_scene(name: str) -> bool:
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


def write_report(path: Path, report: dict) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise UsageError(f"the report '{path}' cannot be written: {error.strerror}") from None
