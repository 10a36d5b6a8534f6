# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that commands write, the .blend and the report: safely, and tried before a night's work, not after it."""

from __future__ import annotations

import argparse
import glob
import json
import os
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

import bpy

from ..core.whole_files import whole_files
from .report import bake_report
from .version import extension_version


class AnyReport(Protocol):
    """Of one object, whatever was done with it."""

    error: str | None

    def as_dict(self) -> dict: ...


class UsageError(Exception):
    """What was asked for cannot be understood or found; exit code 2."""


def blend_files(names: Sequence[str]) -> list[Path]:
    """The files of these names, or that patterns among them name, each once; ** stands for folders at any depth. Raises
    UsageError where there is none."""
    found: dict[Path, Path] = {}
    for name in map(Path, names):
        matches = (
            [name] if name.exists() else [Path(path) for path in sorted(glob.glob(_pattern(name), recursive=True))]
        )
        named = [path for path in matches if path.is_file()]
        if matches and not named:
            raise UsageError(f"'{name}' is a folder: write '{name / '*.blend'}'")
        if not named:
            raise UsageError(f"there is no file '{name}'")
        for path in named:
            found.setdefault(path.resolve(), path)
    return list(found.values())


def _pattern(path: Path) -> str:
    """``path`` as a pattern; but the folders at its beginning that are there by that very name, as "shots [v1]" may be,
    stand for themselves."""
    there = next((folder for folder in path.parents if folder.exists()), Path(path.anchor))
    return os.path.join(glob.escape(str(there)), path.relative_to(there))


def save_scene(name: str) -> bool:
    """Save the .blend as ``name``, or under its own if that is empty; prints why where it cannot be.

    All of it is written before it takes the place of what was there, under a name that no other process writes to.
    Where another has saved the file since it was opened, that is kept, and this goes beside it.
    """
    path = Path(name or bpy.data.filepath).resolve()
    changed = path in _opened and _opened[path] != _state(path)
    target = path.with_name(f"{path.stem}_{os.getpid()}{path.suffix}") if changed else path
    unfinished = _unfinished(target, os.getpid())
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(unfinished), copy=True, relative_remap=True)
        os.replace(unfinished, target)
    except (RuntimeError, OSError) as error:
        print(f"Error: '{path}' cannot be saved: {str(error).strip()}", file=sys.stderr)
        remove_unfinished(target, os.getpid())
        return False
    if changed:
        print(f"Error: '{path}' was saved by another program meanwhile: this is '{target.name}'", file=sys.stderr)
    else:
        _opened[path] = _state(path)
    return not changed


def _unfinished(path: Path, process: int) -> Path:
    return path.with_name(f".{path.name}.{process}.part.blend")


def remove_unfinished(path: Path, process: int) -> None:
    """Remove what the ``process`` had written of the .blend ``path``, and did not come to finish."""
    unfinished = _unfinished(path, process)
    for rest in (unfinished, Path(f"{unfinished}@")):  # the second is Blender's own
        with suppress(OSError):
            rest.unlink(missing_ok=True)


# The .blend that was opened, as it was then or when it was last saved here.
_opened: dict[Path, tuple[int, int] | None] = {}


def _state(path: Path) -> tuple[int, int] | None:
    """Tells two states of a file apart; None where there is none."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size


def begin_files(options: argparse.Namespace) -> None:
    """Look whether the .blend and the report can be written, and keep in mind what the .blend is now. Raises
    UsageError."""
    if options.report is not None:
        check_writable("--report", options.report)
    if options.save is not None:
        check_writable("--save", Path(options.save or options.scene))
    _opened[options.scene.resolve()] = _state(options.scene)


def keep(options: argparse.Namespace, reports: Sequence[AnyReport], started: float) -> bool:
    """Save the .blend where that is asked and any of ``reports`` is of something done; then write these, whatever
    happened. False where one cannot be written. ``started`` is when the command did, by ``time.perf_counter``."""
    done = any(report.error is None for report in reports)
    saved = save_scene(options.save) if options.save is not None and done else True
    if options.report is None:
        return saved
    seconds = time.perf_counter() - started
    return (
        write_report(options.report, bake_report(extension_version(), str(options.scene), seconds, reports)) and saved
    )


def check_writable(option: str, path: Path) -> None:
    """Make the folder now of what is only written at the end, perhaps of a night, and try it. Raises UsageError."""
    path = path.resolve()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise UsageError(f"{option} '{path}' cannot be written ({(error.strerror or str(error)).lower()})") from None


def write_report(path: Path, report: dict) -> bool:
    """Write all of it or nothing; prints why where it cannot be."""
    try:
        with whole_files(path) as (unfinished,):
            unfinished.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        print(f"Error: the report '{path}' cannot be written: {error.strerror}", file=sys.stderr)
        return False
    return True
