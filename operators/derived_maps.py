# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps that other programs show as they are, made from the channels of a bake.

Bent Normal the bent direction as a normal map; a bake leaves it in its colours
AO          grey: F0, which is k_A
Colored AO  E/E0 in red, green and blue, with the base colour that the material has now: it multiplies that colour
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..core.exr import write_exr
from ..core.multibounce import irradiance_from_bounces
from ..core.png import write_png
from .names import AO_MAP, BENT_NORMAL, COLORED_AO_MAP, MULTIBOUNCE_AO, RADIOSITY
from .settings import BakeSettings

ROWS_AT_ONCE = 128


def derive(name: str, channels: Mapping[str, NDArray], albedo: NDArray[np.float32] | None) -> NDArray[np.float32]:
    """The map ``name`` (h, w, 1 or 3), linear, from what a bake left (h, w, 4) and the base colour (h, w, 3)."""
    radiosity, bounces = channels.get(RADIOSITY), channels.get(MULTIBOUNCE_AO)
    if name == BENT_NORMAL:
        return channels[BENT_NORMAL][..., :3]
    if name == AO_MAP:
        return bounces[..., :1] if radiosity is None else radiosity[..., 3:]
    if radiosity is not None:
        return radiosity[..., :3]
    colours = np.empty(albedo.shape, np.float32)
    for row in range(0, len(colours), ROWS_AT_ONCE):
        rows = slice(row, row + ROWS_AT_ONCE)
        colours[rows] = irradiance_from_bounces(*np.moveaxis(bounces[rows, :, :, None], 2, 0), albedo[rows])
    return colours


def extension(settings: BakeSettings) -> str:
    """Of the maps' files."""
    return ".exr" if settings.map_format == "OPEN_EXR" else ".png"


def colour_space(name: str, settings: BakeSettings) -> str:
    """In which the file of the map ``name`` is: colours in PNG files are taken for sRGB everywhere."""
    return "sRGB" if name == COLORED_AO_MAP and settings.map_format != "OPEN_EXR" else "Non-Color"


def write_map(
    path: Path, name: str, pixels: NDArray[np.float32], settings: BakeSettings, metadata: Mapping[str, str]
) -> None:
    """Write what :func:`derive` made. Raises OSError."""
    if settings.map_format == "OPEN_EXR":
        opaque = np.ones((*pixels.shape[:2], 4), np.float32)
        opaque[..., :3] = pixels
        write_exr(path, opaque, half=settings.color_depth == "16", codec=settings.exr_codec, metadata=metadata)
        return
    if colour_space(name, settings) == "sRGB":
        pixels = _to_srgb(pixels)
    write_png(path, pixels, 16 if settings.map_format == "PNG_16" else 8, metadata)


def _to_srgb(linear: NDArray[np.float32]) -> NDArray[np.float32]:
    """IEC 61966-2-1, for values in [0, 1]."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1.0 / 2.4) - 0.055)
