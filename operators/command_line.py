# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao COMMAND SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys

import bpy

from .command_files import UsageError
from .command_scene import DONE, WRONG_USAGE


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
    # Here, with all that commands do: enabling the extension stays instant.
    from . import command_bake, command_field, command_fit, command_info, command_merge, command_world

    parser = argparse.ArgumentParser(
        prog="blender --command multibounce_ao",
        description="Ambient occlusion, coloured as light is after many bounces.",
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    command_bake.add_to(commands)
    command_field.add_to(commands)
    command_fit.add_to(commands)
    command_world.add_to(commands)
    command_info.add_to(commands)
    command_merge.add_to(commands)
    return parser


_handles: list[object] = []


def register() -> None:
    _handles.append(bpy.utils.register_cli_command("multibounce_ao", run))


def unregister() -> None:
    while _handles:
        bpy.utils.unregister_cli_command(_handles.pop())
