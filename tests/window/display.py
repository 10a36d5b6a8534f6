# SPDX-License-Identifier: GPL-3.0-or-later
"""A display in memory, and pictures of it."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

XVFB = shutil.which("Xvfb")
SIZE = 1280, 800


@contextmanager
def virtual_display(folder: Path) -> Iterator[dict[str, str]]:
    """Environment of a program that is to show its windows on an Xvfb display, whose picture is a file in ``folder``,
    drawn by software."""
    Path("/tmp/.X11-unix").mkdir(exist_ok=True)
    read, write = os.pipe()
    screen = "{}x{}x24".format(*SIZE)
    command = [XVFB, "-displayfd", str(write), "-screen", "0", screen, "-fbdir", str(folder), "-nolisten", "tcp"]
    with open(folder / "xvfb.log", "w", encoding="utf-8") as log:
        server = subprocess.Popen(command, pass_fds=[write], stdout=log, stderr=log)
    try:
        os.close(write)
        with open(read, encoding="ascii") as pipe:
            number = pipe.readline().strip()  # when it listens; empty where it has ended
        if not number:
            raise RuntimeError((folder / "xvfb.log").read_text(encoding="utf-8"))
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("WAYLAND", "XDG_"))}
        yield environment | {"DISPLAY": f":{number}", "LIBGL_ALWAYS_SOFTWARE": "1"}
    finally:
        server.terminate()
        server.wait()


def picture(dump: Path) -> np.ndarray:
    """What Xvfb kept, copied to ``dump``: (h, w, 3) uint8, top row first. (xwd's format, see XWDFile.h.)"""
    data = dump.read_bytes()
    header = struct.unpack(">25I", data[:100])
    start, width, height, bytes_per_line, colours = header[0], header[4], header[5], header[12], header[19]
    rows = np.frombuffer(data, np.uint8, height * bytes_per_line, start + 12 * colours).reshape(height, -1)
    return rows[:, : 4 * width].reshape(height, width, 4)[..., 2::-1]


def write_png(path: Path, rgb: np.ndarray) -> None:
    """Write a :func:`picture` as PNG."""
    height, width, _ = rgb.shape
    lines = np.insert(rgb.reshape(height, -1), 0, 0, axis=1)  # each begins with its filter: none
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
        + _chunk(b"IDAT", zlib.compress(lines.tobytes(), 6))
        + _chunk(b"IEND", b"")
    )


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
