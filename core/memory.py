# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory this process can still have."""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import suppress
from pathlib import Path


def free_memory() -> int | None:
    """Bytes that can be had without another program's giving any up, swap included; None where the system does not
    tell. On macOS, which makes room as it goes, all that is built in."""
    if sys.platform == "win32":
        return _windows()
    if sys.platform == "darwin":
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return _linux()


def _linux(root: Path = Path("/")) -> int | None:
    try:
        lines = (root / "proc/meminfo").read_text().splitlines()
        told = {line.split(":")[0]: int(line.split()[1]) * 1024 for line in lines}
        free = told["MemAvailable"] + told["SwapFree"]
    except (OSError, KeyError, ValueError, IndexError):
        return None
    # A container may have less than the machine.
    group = root / "sys/fs/cgroup"
    with suppress(OSError, ValueError):  # none, or "max"
        free = min(free, int((group / "memory.max").read_text()) - int((group / "memory.current").read_text()))
    return free


def _windows() -> int | None:
    class Status(ctypes.Structure):  # MEMORYSTATUSEX
        _fields_ = [
            ("length", ctypes.c_ulong),
            ("load", ctypes.c_ulong),
            *((name, ctypes.c_ulonglong) for name in ("physical", "free_physical", "commit", "free_commit")),
            *((name, ctypes.c_ulonglong) for name in ("virtual", "free_virtual", "free_extended")),
        ]

    status = Status(length=ctypes.sizeof(Status))
    if not ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status)):
        return None
    return status.free_commit
