# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells whether a bake would come out the same: a digest of all that goes into it."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256

import numpy as np


def fingerprint(*parts: object) -> bytes:
    """Of arrays, objects that hold these, and whatever its ``repr`` tells apart, one by one and in their order."""
    digest = sha256()  # the fastest there is where the processor has instructions for it
    for part in parts:
        _add(digest, part)
    return digest.digest()[:16]


def _add(digest, part: object) -> None:
    if isinstance(part, np.ndarray):
        digest.update(f"{part.dtype}{part.shape}".encode())
        digest.update(np.ascontiguousarray(part).data)
    elif hasattr(part, "__dict__"):
        digest.update(type(part).__name__.encode())
        for name, value in vars(part).items():
            digest.update(name.encode())
            _add(digest, value)
    elif isinstance(part, Sequence) and not isinstance(part, (str, bytes)):
        digest.update(f"{len(part)} of".encode())
        for item in part:
            _add(digest, item)
    else:
        digest.update(repr(part).encode())
