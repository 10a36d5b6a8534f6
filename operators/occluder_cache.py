# SPDX-License-Identifier: GPL-3.0-or-later
"""The last scene that was built for rays, kept so that the next bake of an unchanged one starts tracing at once."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.rays import Occluders
from .fingerprint import fingerprint

# Larger scenes are freed with their bake, because Embree's tree takes memory that the artist's work may need.
KEPT_TRIANGLES = 4_000_000

_kept: tuple[bytes, Occluders] | None = None


def occluders_of(
    vertices: NDArray[np.float64], triangles: NDArray[np.int32], ground_height: float | None, centre: NDArray | None
) -> tuple[bytes, Occluders]:
    """:class:`Occluders` of these arguments and their fingerprint. Built unless they are those of the last call,
    whatever objects they come from."""
    global _kept
    key = fingerprint(vertices, triangles, ground_height, centre)
    if _kept is not None and _kept[0] == key:
        return _kept
    _kept = None  # freed before the next is built
    occluders = Occluders(vertices, triangles, ground_height, centre)
    if len(triangles) <= KEPT_TRIANGLES:
        _kept = key, occluders
    return key, occluders


@bpy.app.handlers.persistent
def forget(*_: object) -> None:
    """Free what is kept: another file is opened, or the extension disabled."""
    global _kept
    _kept = None


def register() -> None:
    bpy.app.handlers.load_pre.append(forget)


def unregister() -> None:
    bpy.app.handlers.load_pre.remove(forget)
    forget()
