# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads: one a core that take pieces of work from one list, while the caller hears now and then how far they are; and
one that drives a whole generator, for callers that must not be kept waiting."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from contextvars import ContextVar
from threading import Event, get_native_id
from typing import Any, TypeVar

Part = TypeVar("Part")
Result = TypeVar("Result")

# Seconds between reports. Waking the caller for each piece would take Python's lock from the workers.
REPORT_EVERY = 0.05
# Seconds that a step of in_thread waits for news, and that closing it waits for what cannot be stopped at once.
NEWS_WITHIN, LINGER = 0.01, 0.3
# Of threads that give way to a window, as the command nice has it.
NICENESS = 10

_gives_way: ContextVar[bool] = ContextVar("gives_way", default=False)


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


def in_thread(work: Generator[Any, None, Result], start: Any = 0.0) -> Generator[Any, None, Result]:
    """The generator ``work`` run by a thread of its own; yields what it yielded last, ``start`` before that.

    No step takes much longer than NEWS_WITHIN, whatever ``work`` does between its yields: the thread that also draws
    Blender's window can drive it. Closing this closes ``work`` where it yields next. What takes longer than LINGER to
    come there ends by itself, without a caller.
    """
    latest, unwanted, gives_way = [start], Event(), _gives_way.get()

    def run() -> Result:
        if gives_way:
            _lower_priority()
        try:
            while not unwanted.is_set():
                latest[0] = next(work)
        except StopIteration as finished:
            return finished.value
        finally:
            work.close()

    pool = ThreadPoolExecutor(1)
    working = pool.submit(run)
    try:
        while wait([working], NEWS_WITHIN).not_done:
            yield latest[0]
        return working.result()
    finally:
        unwanted.set()
        pool.shutdown(wait=not wait([working], LINGER).not_done)


@contextmanager
def giving_way() -> Iterator[None]:
    """In here :func:`in_thread` begins threads that leave the processor to the caller's whenever that has work, with
    all threads that they begin. On Linux alone: elsewhere Python has no word for a thread's priority."""
    before = _gives_way.set(True)
    try:
        yield
    finally:
        _gives_way.reset(before)


def _lower_priority() -> None:
    """Of the calling thread, whose own threads inherit it."""
    if sys.platform == "linux":
        thread = get_native_id()
        os.setpriority(os.PRIO_PROCESS, thread, max(NICENESS, os.getpriority(os.PRIO_PROCESS, thread)))


def calling(function: Callable[..., Result], *arguments: Any) -> Generator[float, None, Result]:
    """A call as a generator, for :func:`in_thread`; it yields once, before."""
    yield 0.0
    return function(*arguments)


def slices(count: int, size: int) -> list[slice]:
    """Consecutive slices of ``size``, the last one shorter, that make up ``count``."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
