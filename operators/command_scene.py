# SPDX-License-Identifier: GPL-3.0-or-later
"""What all commands share: their options, the .blend that they open, what they work on, and what they print."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path

import bpy

from .command_files import AnyReport, UsageError, begin_files
from .progress import Progress, StderrProgress
from .settings_text import set_from_text

DONE, NOT_ALL_DONE, WRONG_USAGE = 0, 1, 2


def add_command(
    commands: argparse._SubParsersAction,
    name: str,
    run: Callable[[argparse.Namespace], int],
    *,
    help: str,
    description: str,
    object_help: str,
    failure: str,
    changes: bool = True,
    bakes: bool = True,
    several: bool = False,
) -> argparse.ArgumentParser:
    """A command that ``run`` does, with the options that all have; ``failure`` is what exit code 1 stands for. One that
    ``changes`` nothing has nothing to save, and no settings, nor has one that ``bakes`` nothing. With ``several`` files
    it has a list of them, ``files``, as they were written."""
    command = commands.add_parser(
        name,
        help=help,
        description=description,
        epilog=f"Exit code: 0 done, 1 {failure}, 2 wrong usage.",
    )
    if several:
        command.add_argument(
            "files",
            metavar="SCENE.blend",
            nargs="+",
            help="a file, or all that a pattern such as 'shot_*.blend' or '*/lit.blend' names",
        )
    else:
        command.add_argument("scene", metavar="SCENE.blend", type=Path)
    command.add_argument("--object", metavar="NAME", action="append", help=object_help)
    command.set_defaults(run=run, set=[], save=None)
    if changes and bakes:
        command.add_argument(
            "--set",
            metavar="PROPERTY=VALUE",
            action="append",
            default=[],
            help="use this setting of scene.multibounce_ao in this run, such as samples=64 or target=TEXTURE, also for "
            "objects and collections that override it; --save keeps the scene's own; may be given again",
        )
    if changes:
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
    """Open the .blend; returns its scene. Raises UsageError."""
    (scene,) = open_scenes(options, None)
    return scene


def open_scenes(options: argparse.Namespace, patterns: list[str] | None) -> list[bpy.types.Scene]:
    """Open the .blend; returns those of its scenes that ``patterns`` name, or its active one. Raises UsageError."""
    path = options.scene
    if path.is_dir():
        raise UsageError(f"'{path}' is a folder: name a .blend in it")
    if not path.is_file():
        raise UsageError(f"there is no file '{path}'")
    begin_files(options)
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False)
    except RuntimeError as error:
        reason = str(error).strip().removeprefix("Error: ")
        raise UsageError(f"'{path}' cannot be opened: {reason}") from None
    return [bpy.context.scene] if patterns is None else _named_scenes(patterns)


def _named_scenes(patterns: list[str]) -> list[bpy.types.Scene]:
    """Each once, in the order of the patterns. Raises UsageError where one names none."""
    found = {}
    for pattern in patterns:
        exact = bpy.data.scenes.get((pattern, None))
        named = [exact] if exact else [each for each in bpy.data.scenes if fnmatchcase(each.name, pattern)]
        if not named:
            names = ", ".join(f"'{each.name}'" for each in bpy.data.scenes)
            raise UsageError(f"there is no scene '{pattern}' in the .blend: choose among {names}")
        found.update(dict.fromkeys(named))
    return list(found)


@contextmanager
def given_settings(scene: bpy.types.Scene, options: argparse.Namespace) -> Iterator[None]:
    """``scene`` has the settings that --set gives, for a copy to be made of them; at the end it has its own again, and
    those are saved. Raises UsageError."""
    settings = scene.multibounce_ao
    names = names_set(options) & set(settings.bl_rna.properties.keys())
    own = {name: getattr(settings, name) for name in names if settings.is_property_set(name)}
    try:
        for assignment in options.set:
            name, separator, value = assignment.partition("=")
            if not separator:
                raise UsageError(f"--set {assignment}: write it as PROPERTY=VALUE")
            try:
                set_from_text(settings, name, value)
            except ValueError as error:
                raise UsageError(f"--set {assignment}: {error}") from None
        yield
    finally:
        for name in names:
            if name in own:
                setattr(settings, name, own[name])
            else:
                settings.property_unset(name)


def scenes_of_objects() -> dict[bpy.types.Object, list[bpy.types.Scene]]:
    """By object, the scenes of the .blend that have it; in the order in which a bake of all scenes takes them."""
    found: dict[bpy.types.Object, list[bpy.types.Scene]] = {}
    for scene in bpy.data.scenes:
        layer = bpy.context.view_layer if scene == bpy.context.scene else scene.view_layers[0]
        for obj in dict.fromkeys([*layer.objects, *scene.objects]):
            found.setdefault(obj, []).append(scene)
    return found


def exit_code(kept: bool, reports: Iterable[AnyReport]) -> int:
    """Of a command whose work is ``kept``, or was not to be, and told by ``reports``."""
    return DONE if kept and not any(report.error for report in reports) else NOT_ALL_DONE


def names_set(options: argparse.Namespace) -> set[str]:
    """The settings that were given by --set: they hold for all objects, whatever these override."""
    return {assignment.partition("=")[0] for assignment in options.set}


def no_object(name: str, objects: Iterable[bpy.types.Object] | None = None) -> str:
    """What to say where the view layer has no object ``name``, or else none of ``objects``, all of the .blend."""
    where = "view layer" if objects is None else ".blend"
    objects = bpy.context.view_layer.objects if objects is None else objects
    meshes = ", ".join(f"'{obj.name}'" for obj in objects if obj.type == "MESH")
    return f"There is no object '{name}' in the {where}: choose among {meshes or 'none, it has no mesh'}"


def named_objects(
    patterns: Iterable[str], among: Iterable[bpy.types.Object] | None = None
) -> tuple[list[bpy.types.Object], list[str]]:
    """The objects of the view layer, or ``among`` others, that ``patterns`` name, each once, and the patterns that name
    none.

    A pattern is a name, or else it names all meshes that it matches: * stands for any letters, ? for one.
    """
    objects = {obj.name: obj for obj in (bpy.context.view_layer.objects if among is None else among)}
    meshes = [obj for obj in objects.values() if obj.type == "MESH"]
    found, missing = {}, []
    for pattern in patterns:
        exact = objects.get(pattern)
        named = [exact] if exact else [obj for obj in meshes if fnmatchcase(obj.name, pattern)]
        found.update(dict.fromkeys(named))
        if not named and pattern not in missing:
            missing.append(pattern)
    return list(found), missing


def meshes_in_collections(patterns: Iterable[str]) -> tuple[list[bpy.types.Object], list[str]]:
    """The meshes of the view layer in collections that ``patterns`` name, and in those inside; and the patterns that
    name none. Patterns as for :func:`named_objects`."""
    collections = [bpy.context.scene.collection, *bpy.context.scene.collection.children_recursive]
    objects, found, missing = set(bpy.context.view_layer.objects), {}, []
    for pattern in dict.fromkeys(patterns):
        exact = [each for each in collections if each.name == pattern]
        named = exact or [each for each in collections if fnmatchcase(each.name, pattern)]
        found.update(
            dict.fromkeys(obj for each in named for obj in each.all_objects if obj.type == "MESH" and obj in objects)
        )
        if not named:
            missing.append(pattern)
    return list(found), missing


def no_collection(name: str) -> str:
    """What to say where the scene has no collection ``name``."""
    names = ", ".join(f"'{each.name}'" for each in bpy.context.scene.collection.children_recursive)
    return f"There is no collection '{name}' in the scene: choose among {names or 'none, it has no collection'}"


def progress_for(options: argparse.Namespace) -> Callable[[Progress], None]:
    """Lines on stderr for someone who looks at a terminal; a pipe or a file gets only what comes of it."""
    return StderrProgress() if sys.stderr.isatty() and not options.quiet else lambda step: None


def print_table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]], file, names: int = 1) -> None:
    """In columns, the first ``names`` of them to the left and the others to the right."""
    lines = [head, *rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(head))]
    for line in lines:
        cells = [
            f"{cell:<{width}}" if column < names else f"{cell:>{width}}"
            for column, (cell, width) in enumerate(zip(line, widths, strict=True))
        ]
        print("  ".join(cells).rstrip(), file=file)
