# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of a bake: what is told, and to whom."""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True)
class Progress:
    """``fraction`` of a whole bake in [0, 1], the ``name`` of the object at work, and a ``note`` about it."""

    fraction: float
    name: str
    note: str = ""


def drive(work: Generator[Progress, None, Result], show: Callable[[Progress], None]) -> Result:
    """Run ``work`` to its end, show each step, and return its result."""
    try:
        while True:
            show(next(work))
    except StopIteration as finished:
        return finished.value
    finally:
        work.close()


class StderrProgress:
    """Prints a line on stderr for every tenth of the way, and for every note."""

    def __init__(self) -> None:
        self._printed = -1
        self._note = ""

    def __call__(self, progress: Progress) -> None:
        tenth = int(10 * progress.fraction)
        if tenth > self._printed or progress.note not in ("", self._note):
            self._printed, self._note = tenth, progress.note
            note = f", {progress.note}" if progress.note else ""
            print(f"Multibounce AO: {10 * tenth:3d} %  {progress.name}{note}", file=sys.stderr, flush=True)
