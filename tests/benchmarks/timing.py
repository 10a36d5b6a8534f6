# SPDX-License-Identifier: GPL-3.0-or-later
"""Clocks: what is compared takes turns, and what counts is the median."""

from __future__ import annotations

import importlib
import os
import statistics
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any
from unittest.mock import patch

import numpy as np
from enable_extension import PACKAGE


def seconds(call: Callable[[], Any]) -> float:
    started = time.perf_counter()
    call()
    return time.perf_counter() - started


def side_by_side(calls: dict[str, Callable[[], float]], repeats: int, budget: float = 10.0) -> dict[str, float]:
    """Median of what each call returns, its own seconds, over ``repeats`` rounds that run them in turns.

    A call that has used ``budget`` seconds sits out the rest, so that a slow one may run once only.
    """
    taken: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(repeats):
        for name, call in calls.items():
            if sum(taken[name]) < budget:
                taken[name].append(call())
    return {name: statistics.median(each) for name, each in taken.items()}


@dataclass
class RayClock:
    """Notes the rays of the extension's bakes and the wall time of their tracing, while it is a context.

    Tracing is what the ray loop does after it has sorted its points: from the first ray's origin to the last sum, with
    directions and sums. All else of a bake is not.

    keep    copy each block of rays too, into ``blocks``: (occluders, origins, directions)
    """

    keep: bool = False
    rays: int = 0
    seconds: float = 0.0
    blocks: list[tuple[Any, np.ndarray, np.ndarray]] = field(default_factory=list)

    def __enter__(self) -> RayClock:
        occluders = importlib.import_module(f"{PACKAGE}.core.rays").Occluders
        tracer = importlib.import_module(f"{PACKAGE}.operators.tracer")
        lock = threading.Lock()
        started: list[float] = []

        def origins(scene, *args, _whole=occluders.origins):
            started.append(time.perf_counter())
            return _whole(scene, *args)

        def visibility(scene, origins, directions, *args, _whole=occluders.visibility, **kwargs):
            result = _whole(scene, origins, directions, *args, **kwargs)
            with lock:
                self.rays += len(origins)
                if self.keep:
                    self.blocks.append((scene, origins.copy(), directions.copy()))
            return result

        def trace_visibility(*args, _whole=tracer.trace_visibility, **kwargs):
            started.clear()
            result = yield from _whole(*args, **kwargs)
            self.seconds += time.perf_counter() - min(started)
            return result

        self._patches = ExitStack()
        for owner, wrapper in ((occluders, origins), (occluders, visibility), (tracer, trace_visibility)):
            self._patches.enter_context(patch.object(owner, wrapper.__name__, wrapper))
        return self

    def __exit__(self, *_) -> None:
        self._patches.close()

    def embree_alone(self) -> float:
        """Seconds that Embree takes for the rays that were kept, on a thread a core."""
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            started = time.perf_counter()
            list(pool.map(lambda block: block[0]._scene.run(*block[1:], query="OCCLUDED"), self.blocks))
            return time.perf_counter() - started
