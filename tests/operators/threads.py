# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads that a closed bake leaves: none for long."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection


def assert_others_end(threads: Collection[threading.Thread], within: float = 20.0) -> None:
    """All but ``threads`` end by themselves. Most have by now; one that cannot be stopped in its step may go on."""
    until = time.monotonic() + within
    while set(threading.enumerate()) - set(threads):
        assert time.monotonic() < until, threading.enumerate()
        time.sleep(0.01)
