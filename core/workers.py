# SPDX-License-Identifier: GPL-3.0-or-later
"""A thread a core that take pieces of work from one list, while the caller hears now and then how far they are."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from typing import Any, TypeVar

Part = TypeVar("Part")
Result = TypeVar("Result")

# Seconds between reports. Waking the caller for each piece would take Python's lock from the workers.
REPORT_EVERY = 0.05


class Workers:
    """Threads for :meth:`run` and :meth:`map`, default one a core; a context manager that ends them."""

    def __init__(self, threads: int | None = None):
        self._threads = threads or os.cpu_count() or 1
        self._pool = ThreadPoolExecutor(self._threads)

    def __enter__(self) -> Workers:
        return self

    def __exit__(self, *_) -> None:
        self._pool.shutdown()

    def run(self, task: Callable[[Part], int], parts: Sequence[Part]) -> Generator[int, None, None]:
        """Call ``task`` on each of ``parts``; yields the sum of what the calls have returned so far, at the end and
        about twenty times a second until then.

        Which thread gets which part is chance. An exception in a task ends the others and is raised here. Closing the
        generator waits for the parts in hand and drops the rest.
        """
        left, results = iter(parts), []

        def work() -> None:
            try:
                for part in left:  # one iterator for all threads: Python's lock gives each part to one of them
                    results.append(task(part))
            finally:
                drop()

        def drop() -> None:
            for _ in left:
                pass

        working = [self._pool.submit(work) for _ in range(min(self._threads, len(parts)))]
        try:
            while wait(working, REPORT_EVERY).not_done:
                yield sum(results)
            for finished in working:
                finished.result()
            yield sum(results)
        finally:
            drop()
            wait(working)

    def map(self, task: Callable[[Part], Result], parts: Sequence[Part]) -> list[Result]:
        """What ``task`` returns for each of ``parts``, in their order, when all are done."""
        working = self.mapping(task, parts)
        while True:
            try:
                next(working)
            except StopIteration as finished:
                return finished.value

    def mapping(self, task: Callable[[Part], Result], parts: Sequence[Part]) -> Generator[float, None, list[Result]]:
        """As :meth:`map`, as a generator that yields the fraction done."""
        results: list[Result] = [None] * len(parts)

        def keep(index: int) -> int:
            results[index] = task(parts[index])
            return 1

        for done in self.run(keep, range(len(parts))):
            yield done / max(1, len(parts))
        return results


def mapped(work: Generator[Any, None, Result], change: Callable[[Any], Any]) -> Generator[Any, None, Result]:
    """The generator ``work`` with each yield passed through ``change``; closing this closes ``work``."""
    try:
        while True:
            yield change(next(work))
    except StopIteration as finished:
        return finished.value
    finally:
        work.close()


def slices(count: int, size: int) -> list[slice]:
    """Consecutive slices of ``size``, the last one shorter, that make up ``count``."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
