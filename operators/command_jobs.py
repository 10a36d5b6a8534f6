# SPDX-License-Identifier: GPL-3.0-or-later
"""``bake`` of several .blend files in one call: a process of this same Blender for each, ``--jobs`` of them at a time.

Each child is one plain ``bake`` of one file, with its part of the threads, so its bits are those of that command, and a
crash in one file is that file's alone. What the children report comes together in one table and one JSON report.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import IO

import bpy

from .command_files import UsageError, check_writable, remove_unfinished, write_report
from .command_scene import DONE, NOT_ALL_DONE, WRONG_USAGE, exit_code
from .command_tell import tell
from .report import ObjectReport
from .version import extension_version

# Seconds between two looks at the children, and that these have to end by themselves when they are told to.
TICK, PATIENCE = 0.05, 5.0
# Before what a command says of wrong usage.
USAGE = "multibounce_ao: "


@dataclass
class FileReport:
    """The bake of one file by a child; ``error`` is None where all that was asked for was done, or is told of an
    object. The JSON report lists these fields."""

    file: str
    seconds: float = 0.0
    error: str | None = None


def bake_files(files: list[Path], options: argparse.Namespace) -> int:
    """Bake ``files``, several; returns the exit code. Raises UsageError."""
    started = time.perf_counter()
    if options.save:
        raise UsageError(f"--save {options.save}: several files are saved each in its place, so write --save alone")
    program = _program()
    if options.report is not None:
        check_writable("--report", options.report)
    reports, objects = [FileReport(str(file), error="was not begun") for file in files], []
    with TemporaryDirectory() as folder:
        children = [
            _Child(report, [*program, *_arguments(file, options)], Path(folder) / str(index))
            for index, (file, report) in enumerate(zip(files, reports, strict=True))
        ]
        threads = options.threads or os.cpu_count() or 1
        _run(children, _shared_out(threads, min(options.jobs, len(files))), options)
        for child in children:
            objects += child.objects()
    _tell_same_files(objects)
    seconds = time.perf_counter() - started
    written = options.report is None or write_report(
        options.report,
        {
            "version": extension_version(),
            "seconds": round(seconds, 3),
            "files": [vars(report) for report in reports],
            "objects": [report.as_dict() for report in objects],
        },
    )
    tell(objects, options, seconds, {report.file: report.error for report in reports})
    return exit_code(written, [*reports, *objects])


class _Child:
    """A process that bakes one file. ``place`` is where its own report and its messages go."""

    def __init__(self, report: FileReport, command: list[str], place: Path):
        self.report = report
        self._json, self._messages = place.with_suffix(".json"), place.with_suffix(".txt")
        self._command = [*command, f"--report={self._json}"]
        self._process: subprocess.Popen | None = None
        self._output: IO[bytes] | None = None
        self._began = 0.0
        self.threads = 0

    def start(self, threads: int) -> None:
        self.threads = threads
        self._began = time.perf_counter()
        self._output = self._messages.open("wb")
        # A group of its own: Ctrl-C in the terminal is for the parent, which ends the children in their order.
        group = (
            {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
            if sys.platform == "win32"
            else {"start_new_session": True}
        )
        try:
            self._process = subprocess.Popen(
                [*self._command, f"--threads={threads}"],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=self._output,
                **group,
            )
        except OSError as error:
            self._output.close()
            self.report.error = f"cannot be baked, as Blender does not start ({(error.strerror or str(error)).lower()})"

    def has_ended(self) -> bool:
        """Whether it has, its result told in its report."""
        if self._process is None:
            return True
        if self._process.poll() is None:
            return False
        self._end()
        self.report.error = self._reason(self._process.returncode)
        return True

    def terminate(self) -> None:
        """Tell it, which has not ended, to end where it is: files that it writes stay as they were."""
        self._process.terminate()

    def stop(self) -> None:
        """Wait for its end, and bring it about if need be."""
        try:
            self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._end()
        self.report.error = "was interrupted"

    def objects(self) -> list[ObjectReport]:
        """What it told of its objects; none where it did not come to that."""
        return [ObjectReport(**entry, file=self.report.file) for entry in self._told() or ()]

    def _told(self) -> list[dict] | None:
        try:
            return json.loads(self._json.read_text(encoding="utf-8"))["objects"]
        except (OSError, ValueError):
            return None

    def _end(self) -> None:
        self._output.close()
        remove_unfinished(Path(self.report.file).resolve(), self._process.pid)
        self.report.seconds = round(time.perf_counter() - self._began, 3)

    def _reason(self, code: int) -> str | None:
        """Why it has not done all, where none of its objects tells."""
        objects = self._told()
        lines = self._messages.read_text(encoding="utf-8", errors="replace").splitlines()
        usage = [line.removeprefix(USAGE) for line in lines if line.startswith(USAGE)]
        if code == WRONG_USAGE and usage:
            return f"cannot be baked: {usage[-1]}"
        if code == DONE and objects is not None:
            return None
        if code == NOT_ALL_DONE and objects is not None:
            errors = [line.removeprefix("Error: ") for line in lines if line.startswith("Error: ")]
            errors = [error for error in errors if error not in [entry["error"] for entry in objects]]
            return "is not done: " + "; ".join(errors) if errors else None
        last = next((line.strip() for line in reversed(lines) if line.strip()), "")
        return f"crashed ({_exit_text(code)}{': ' + last if last else ''}): bake it alone to see more"


def _tell_same_files(objects: list[ObjectReport]) -> None:
    """Set the error of those that wrote a file which an object of another .blend before them wrote, too."""
    first: dict[str, ObjectReport] = {}
    for report in objects:
        if report.error:
            continue
        for output in filter(os.path.isabs, report.outputs):  # the others are names in the .blend
            other = first.setdefault(os.path.normcase(output), report)
            if other.file != report.file:
                report.error = (
                    f"Object '{report.name}' of '{report.file}' and '{other.name}' of '{other.file}' both wrote "
                    f"'{output}': choose another Output in one of the files, or bake each in a call of its own with "
                    "another --set output_directory=FOLDER"
                )
                break


def _run(children: list[_Child], threads: list[int], options: argparse.Namespace) -> None:
    """Let all ``children`` run, as many at a time as there are entries in ``threads``, with so many each. Where that is
    interrupted, those that run are ended, and the others not begun."""
    shows = sys.stderr.isatty() and not options.quiet
    waiting, running, free, done = [*children], [], [*threads], 0
    with _interruption() as interrupted:
        try:
            while (waiting or running) and not interrupted.is_set():
                while waiting and free:
                    running.append(waiting.pop(0))
                    running[-1].start(free.pop(0))
                for child in [child for child in running if child.has_ended()]:
                    running.remove(child)
                    free.append(child.threads)
                    done += 1
                    if shows:
                        told = child.report.error or f"in {child.report.seconds:.1f} s"
                        print(f"Multibounce AO: {done} of {len(children)}  {child.report.file} {told}", file=sys.stderr)
                if running:
                    time.sleep(TICK)
        finally:
            left = [child for child in running if not child.has_ended()]
            for child in left:
                child.terminate()
            for child in left:
                child.stop()


@contextmanager
def _interruption() -> Iterator[threading.Event]:
    """Set by Ctrl-C and by a farm's SIGTERM, in place of what Blender does then."""
    interrupted = threading.Event()
    if threading.current_thread() is not threading.main_thread():  # the others cannot say what signals do
        yield interrupted
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda *_: interrupted.set())
    try:
        yield interrupted
    finally:
        for number, handler in before.items():
            signal.signal(number, handler or signal.SIG_DFL)  # None: not Python's


def _program() -> list[str]:
    """This Blender's command, as it was called."""
    if not bpy.app.binary_path:
        raise UsageError("several files need Blender's program, and this is its Python module: bake them one by one")
    commands = [index for index, argument in enumerate(sys.argv) if argument in {"-c", "--command"}]
    before = sys.argv[1 : commands[0]] if commands else []
    return [bpy.app.binary_path, *before, "--command", "multibounce_ao"]


def _arguments(file: Path, options: argparse.Namespace) -> list[str]:
    """A plain bake of ``file`` with the same ``options``."""
    repeated = {"object": options.object, "collection": options.collection, "scene": options.scenes, "set": options.set}
    index, count = options.share
    return [
        "bake",
        str(file.resolve()),
        *(f"--{name}={value}" for name, values in repeated.items() for value in values or ()),
        *(["--resume"] if options.resume else []),
        f"--checkpoint={options.checkpoint}",
        f"--share={index}/{count}",
        *(["--save"] if options.save is not None else []),
        "--quiet",
    ]


def _shared_out(threads: int, jobs: int) -> list[int]:
    """``threads`` for each of ``jobs``, as many together, but each one at least."""
    return [max(1, threads // jobs + (job < threads % jobs)) for job in range(jobs)]


def _exit_text(code: int) -> str:
    if code < 0:
        try:
            return signal.Signals(-code).name
        except ValueError:
            return f"signal {-code}"
    return f"exit code {code:#x}" if code > 255 else f"exit code {code}"
