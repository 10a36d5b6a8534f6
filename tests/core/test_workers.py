# SPDX-License-Identifier: GPL-3.0-or-later
"""Work shared among threads: all of it once, errors raised, the rest dropped when nobody asks for it."""

import os
import sys
import threading
import time

import pytest

from core.workers import LINGER, NEWS_WITHIN, NICENESS, Workers, calling, giving_way, in_thread


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("count", [0, 1, 500])
def test_every_part_is_done_once(threads, count):
    done = []
    with Workers(threads) as workers:
        reports = list(workers.run(lambda part: done.append(part) or 2, range(count)))
    assert sorted(done) == list(range(count))
    assert reports[-1] == 2 * count and reports == sorted(reports)


@pytest.mark.parametrize("threads", [1, 3])
def test_results_come_in_the_order_of_the_parts(threads):
    with Workers(threads) as workers:
        assert workers.map(lambda part: part * part, range(200)) == [part * part for part in range(200)]
        assert workers.map(abs, []) == []


def test_threads_work_at_the_same_time():
    meeting = threading.Barrier(2, timeout=20)
    with Workers(2) as workers:
        list(workers.run(lambda part: meeting.wait() * 0, [0, 1]))


def test_an_error_ends_the_work_and_is_raised():
    done = []

    def task(part):
        if part == 3:
            raise ValueError("part 3")
        time.sleep(1e-3)
        done.append(part)
        return 1

    with Workers(2) as workers, pytest.raises(ValueError, match="part 3"):
        list(workers.run(task, range(1000)))
    assert len(done) < 20


def test_closing_drops_the_rest():
    started = []

    def task(part):
        started.append(part)
        time.sleep(0.03)
        return 1

    with Workers(2) as workers:
        work = workers.run(task, range(1000))
        next(work)
        work.close()
        count = len(started)
        time.sleep(0.1)
        assert 0 < count == len(started) < 20


def counting(log, pause=0.0, until=3):
    try:
        for number in range(until):
            log.append(threading.current_thread())
            time.sleep(pause)
            yield number
        return "done"
    finally:
        log.append("closed")


def test_a_generator_in_a_thread_of_its_own():
    log, steps, waits = [], [], []
    work = in_thread(counting(log, 0.1), start="begin")
    while True:
        began = time.perf_counter()
        try:
            steps.append(next(work))
        except StopIteration as finished:
            assert finished.value == "done"
            break
        waits.append(time.perf_counter() - began)
    numbers = [step for step in steps if step != "begin"]
    assert sorted(waits)[len(waits) // 2] < 5 * NEWS_WITHIN  # the work sleeps for longer, and others use the machine
    assert steps[0] == "begin"
    assert numbers == sorted(numbers) and numbers[-1] > 0
    assert log[-1] == "closed"
    assert threading.current_thread() not in log
    assert not log[0].is_alive()


def test_what_it_raises_is_raised_to_the_caller():
    def work():
        yield 0
        raise ValueError("no")

    with pytest.raises(ValueError, match="no"):
        list(in_thread(work()))
    with pytest.raises(ZeroDivisionError):
        list(in_thread(calling(divmod, 1, 0)))


def test_closing_stops_it_at_its_next_step():
    log = []
    work = in_thread(counting(log, 0.03, until=1000))
    next(work)
    work.close()
    assert log[-1] == "closed" and len(log) < 10


def test_closing_does_not_wait_for_what_cannot_be_stopped():
    wake = threading.Event()
    work = in_thread(calling(wake.wait, 20.0))
    next(work)
    began = time.perf_counter()
    work.close()
    assert time.perf_counter() - began < LINGER + 2.0
    wake.set()


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has priorities of threads")
def test_threads_give_way_to_the_caller_where_that_is_asked():
    def priority():
        return os.getpriority(os.PRIO_PROCESS, threading.get_native_id())

    def work():
        yield 0
        with Workers(2) as workers:
            return [priority(), *workers.map(lambda part: priority(), range(4))]

    def priorities():
        working = in_thread(work())
        while True:
            try:
                next(working)
            except StopIteration as finished:
                return set(finished.value)

    own = priority()
    assert priorities() == {own}
    with giving_way():
        assert priorities() == {max(own, NICENESS)}
    assert priorities() == {priority()} == {own}
