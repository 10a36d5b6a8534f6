# SPDX-License-Identifier: GPL-3.0-or-later
"""Which .blend a map on disk is of: two that write into one folder may hold objects of one name."""

from __future__ import annotations

import json
from pathlib import Path

import bpy

from ..core.exr import read_metadata
from .names import PROPERTY


def blend_name() -> str:
    """Of the open .blend, as its maps name it: without its folder, which may move; empty where it was never saved."""
    return Path(bpy.data.filepath).name


def map_owner(path: str | Path) -> tuple[str, str]:
    """The .blend and the object whose bake wrote ``path``; empty where the file does not tell. Each bake leaves some
    OpenEXR file, so that others need not be read."""
    path = Path(path)
    if path.suffix != ".exr" or not path.is_file():
        return "", ""
    try:
        told = json.loads(read_metadata(path)[PROPERTY])
        return told["blend"], told["object"]
    except (OSError, ValueError, KeyError):  # from another program, or an earlier version
        return "", ""
