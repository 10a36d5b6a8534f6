# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's version, kept in one place: the manifest."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path


@cache
def extension_version() -> str:
    """``version`` of ``blender_manifest.toml``."""
    manifest = Path(__file__).parents[1] / "blender_manifest.toml"
    return tomllib.loads(manifest.read_text(encoding="utf-8"))["version"]
