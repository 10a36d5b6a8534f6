# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays scenes in Blender's own window: a timer moves the mouse and presses keys as an artist would.

blender --enable-event-simulate --python director.py -- FOLDER_OF_THE_TESTS FOLDER_FOR_RESULTS

A scene is a generator that yields what it waits for: seconds, or a function that has to become true. What it returns is
written to results.json under its name, and what it raises too. Blender quits after the last. While one is worked on,
WINDOW_SCENES="NAME..." plays some alone.
"""

import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Generator
from pathlib import Path

import bpy

tests, folder = (Path(argument) for argument in sys.argv[sys.argv.index("--") + 1 :])
sys.path[:0] = [str(tests), str(tests / "window")]
from artist import running  # noqa: E402
from measures import MEASURES  # noqa: E402
from scenes import SCENES  # noqa: E402

POLL, MOST_SECONDS = 0.02, 60.0


def play() -> Generator[float | Callable[[], bool], None, None]:
    """All scenes, one after another."""
    results = {}
    measures = MEASURES if os.environ.get("WINDOW_MEASURES") else []
    chosen = os.environ.get("WINDOW_SCENES", "").split()
    for scene in (*measures, *SCENES):  # the last of those quits
        if chosen and scene.__name__ not in chosen:
            continue
        print(f"{time.monotonic():.1f} {scene.__name__}", flush=True)
        try:
            outcome = yield from scene(folder)
        except Exception:
            outcome = {"error": traceback.format_exc()}
            if running() is not None:  # the next scene begins without it
                running().end("")
                yield lambda: running() is None
        results[scene.__name__] = outcome
        (folder / "results.json").write_text(json.dumps(results, indent=1))


class Director:
    """Blender's timer: goes on with the play when what it waits for is there."""

    def __init__(self):
        self._steps = play()
        self._wanted: Callable[[], bool] | None = None
        self._until = 0.0

    def __call__(self) -> float | None:
        if self._wanted is not None and not self._wanted():
            if time.monotonic() < self._until:
                return POLL
            return self._next(lambda: self._steps.throw(TimeoutError("waited for too long")))
        return self._next(lambda: next(self._steps))

    def _next(self, step: Callable) -> float | None:
        try:
            wanted = step()
        except StopIteration:
            bpy.ops.wm.quit_blender()
            return None
        self._wanted = wanted if callable(wanted) else None
        self._until = time.monotonic() + MOST_SECONDS
        return POLL if self._wanted else wanted


bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(Director(), first_interval=1.0, persistent=True)
