# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells whether a bake would come out the same: a digest of all that goes into it."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b

import numpy as np


def fingerprint(*parts: object) -> bytes:
    """Of arrays, objects that hold these, and whatever its ``repr`` tells apart, one by one and in their order."""
    digest = blake2b(digest_size=16)
    for part in parts:
        _add(digest, part)
    return digest.digest()


def _add(digest: blake2b, part: object) -> None:
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
