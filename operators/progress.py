# SPDX-License-Identifier: GPL-3.0-or-later
"""The progress of long work: what is told, how long it will take still, and to whom."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

from .report import count_text

Result = TypeVar("Result")

STARTED = 1e-6
"""Fraction of work that has begun to do what all of it will be like: its time counts from there."""


@dataclass(frozen=True)
class Progress:
    """How far work is.

    fraction  of the whole, in [0, 1], in proportion to time as far as that can be told before
    name      of the object at work
    rays      traced so far; 0 where they are not counted
    ready     all is computed, and the next step writes it
    note      what to know of that object's work
    """

    fraction: float
    name: str
    rays: int = 0
    ready: bool = False
    note: str = ""


class Pace:
    """How fast work goes, from its progress. ``now`` is the clock, in seconds."""

    # Nothing is said before so many seconds, nor before this part of the work; after long ones a smaller part will do.
    LEAST_SECONDS, LEAST_FRACTION = 0.5, 0.02
    LONG_SECONDS, LONG_FRACTION = 3.0, 0.002

    def __init__(self, now: Callable[[], float] = time.perf_counter):
        self._now = now
        # When the work was last where it began: reading the scene until then says nothing of the rest.
        self._began = now()
        self._first_ray: float | None = None
        self.left: float | None = None
        """Seconds to go; None while that is unknown."""
        self.rate: float | None = None
        """Rays a second since the first; None while there is none."""

    def __call__(self, progress: Progress) -> None:
        now = self._now()
        if progress.fraction <= 0.0:
            self._began = now
        else:
            elapsed = now - self._began
            least = self.LEAST_FRACTION if elapsed < self.LONG_SECONDS else self.LONG_FRACTION
            if elapsed >= self.LEAST_SECONDS and progress.fraction >= least:
                self.left = elapsed * (1.0 / progress.fraction - 1.0)
        if progress.rays:
            self._first_ray = self._first_ray or now
            if now > self._first_ray:
                self.rate = progress.rays / (now - self._first_ray)

    def text(self) -> str:
        """Both in one line, empty while neither is known."""
        parts = [f"{count_text(self.rate)} rays/s"] if self.rate else []
        return ", ".join([*parts, f"{duration_text(self.left)} left"] if self.left is not None else parts)


def duration_text(seconds: float) -> str:
    """A time as people say it: 4 s, 2 min 10 s, 1 h 5 min."""
    seconds = round(seconds)
    minutes, hours = seconds // 60, seconds // 3600
    if hours:
        return f"{hours} h {minutes % 60} min"
    return f"{minutes} min {seconds % 60} s" if minutes else f"{seconds} s"


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
