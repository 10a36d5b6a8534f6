# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao COMMAND SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
from itertools import pairwise
from typing import NoReturn

import bpy

from .command_files import UsageError
from .command_scene import DONE, WRONG_USAGE

# How what argparse says of missing files ends: with the names that the commands give them.
MISSING = ("SCENE.blend", "PART.blend")


def run(arguments: list[str]) -> int:
    """The command with its ``arguments``; returns the exit code."""
    try:
        options = _parser().parse_args(arguments)
        return options.run(options)
    except SystemExit as wanted:  # argparse has printed the help or what is wrong
        return int(wanted.code or DONE)
    except UsageError as error:
        print(f"multibounce_ao: {error}", file=sys.stderr)
        return WRONG_USAGE


class _Parser(argparse.ArgumentParser):
    """Says where a file went that is missing."""

    def parse_known_args(self, args=None, namespace=None):
        self._given = list(args or ())
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """Raises UsageError where --save took the .blend, else SystemExit."""
        for option, value in pairwise(self._given):
            if option == "--save" and not value.startswith("-") and message.endswith(MISSING):
                raise UsageError(f"--save took {value} as the name to save as: write the .blend first, or --save=NAME")
        super().error(message)


def _parser() -> argparse.ArgumentParser:
    # Here, with all that commands do: enabling the extension stays instant.
    from . import command_bake, command_field, command_fit, command_info, command_merge, command_world

    parser = _Parser(
        prog="blender --command multibounce_ao",
        description="Ambient occlusion, colored as light is after many bounces.",
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
