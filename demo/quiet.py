# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what renders print to themselves: before 5.0 Cycles tells of every sample."""

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def quiet() -> Iterator[None]:
    """Nothing on the standard output meanwhile, from C either; errors still show."""
    sys.stdout.flush()
    out = os.dup(1)
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(out, 1)
        os.close(out)
