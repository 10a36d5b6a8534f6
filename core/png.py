# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of whole numbers as PNG files (ISO/IEC 15948), grey or RGB, 8 or 16 bits a channel.

Blender saves 16 bits through its render settings only, with their view transform.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

SIGNATURE = b"\x89PNG\r\n\x1a\n"
UP = 2  # each byte less the one above it: smooth maps become small
GREY, RGB = 0, 2


def write_png(
    path: str | Path, pixels: NDArray[np.floating], bits: int, metadata: Mapping[str, str] | None = None
) -> None:
    """Write ``pixels`` (h, w, 1 or 3) in [0, 1], bottom row first as Blender keeps them, with so many ``bits``, 8 or
    16, a channel; ``metadata`` as text. What is there already is written over. Raises OSError."""
    height, width, channels = pixels.shape
    kind = {1: GREY, 3: RGB}[channels]
    with Path(path).open("wb") as file:
        file.write(SIGNATURE)
        file.write(_chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, bits, kind, 0, 0, 0)))
        for key, text in (metadata or {}).items():
            # Language tags left empty; the text is UTF-8.
            file.write(_chunk(b"iTXt", key.encode("latin-1") + b"\0\0\0\0\0" + text.encode()))
        file.write(_chunk(b"IDAT", zlib.compress(_filtered(pixels[::-1], bits), 6)))
        file.write(_chunk(b"IEND", b""))


def _filtered(pixels: NDArray[np.floating], bits: int) -> bytes:
    """Rows from the top, each after the number of its filter."""
    whole = np.rint(np.clip(pixels, 0.0, 1.0) * (2**bits - 1)).astype(f">u{bits // 8}")
    rows = np.ascontiguousarray(whole).view(np.uint8).reshape(len(pixels), -1)
    filtered = np.full((len(rows), rows.shape[1] + 1), UP, np.uint8)
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    return filtered.tobytes()


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
