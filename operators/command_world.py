# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao world SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import asdict, dataclass, field

from .command_files import UsageError, keep
from .command_scene import add_command, exit_code, given_settings, open_scene
from .project_world import project_world, summary
from .report import BakeError


@dataclass
class WorldReport:
    """What was projected; ``error`` is None where it was done. The JSON report lists these fields."""

    name: str
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    error: str | None = None

    def as_dict(self) -> dict:
        return asdict(self)


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``world``."""
    add_command(
        commands,
        "world",
        _project,
        help="project the World's light for bent cones",
        description="Project the light of the World of SCENE.blend for the bent-cone nodes, and keep it on the scene.",
        object_help="not used: a scene has one World",
        failure="the World could not be projected or the .blend not saved",
    )


def _project(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = open_scene(options)
    if options.object is not None:
        raise UsageError(f"--object {options.object[0]}: a World belongs to the scene: leave --object out")
    report = WorldReport(scene.world.name if scene.world is not None else "")
    try:
        with given_settings(scene, options):  # none of them matters to a World, but a wrong one is told
            project_world(scene)
    except BakeError as error:
        report.error = str(error)
    report.seconds = round(time.perf_counter() - started, 3)
    kept = keep(options, [report], started)
    if report.error:
        print(f"Error: {report.error}", file=sys.stderr)
    elif not options.quiet:
        print(summary(scene), file=sys.stderr)
        if options.save is None:
            print("The .blend was not saved: add --save to keep the projection in it", file=sys.stderr)
    return exit_code(kept, [report])
