# SPDX-License-Identifier: GPL-3.0-or-later
"""Work shared among threads: all of it once, errors raised, the rest dropped when nobody asks for it."""

import threading
import time

import pytest

from core.workers import Workers


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
