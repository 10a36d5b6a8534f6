# SPDX-License-Identifier: GPL-3.0-or-later
"""What memory a texture bake needs beside the scene, and whether there is so much."""

from __future__ import annotations

from ..core.memory import free_memory
from .images import map_names
from .names import CHANNELS
from .report import BakeError
from .settings import BakeSettings

# Four floats a texel of an image. While one is stored, Blender or OpenEXR hold it twice more.
IMAGE = 16
STORING = 2 * IMAGE
COLOURED = 52  # for the coloured map, while it is made and written
# Which texels are covered, and which known; the base colour in float32.
MASKS, COLOUR = 2, 12
# Of a band of texels and its rays, whatever the resolution; of the triangles' UVs and seams.
BAND = 0.6e9
TRIANGLE = 500


def needed_memory(settings: BakeSettings, tiles: int, triangles: int) -> float:
    """About how many bytes the bake of so many ``tiles`` of a surface of ``triangles`` takes at its peak, over what the
    scene takes already."""
    texels = settings.resolution**2
    colour = COLOUR if settings.use_colored_ao_map and settings.bounces != "RADIOSITY" else 0
    images = IMAGE * (len(CHANNELS[settings.bounces]) + settings.use_bent_normal_map) + colour
    # Maps get an alpha first.
    storing = STORING + IMAGE * (settings.map_format == "OPEN_EXR" and bool(map_names(settings)))
    if settings.use_colored_ao_map:
        storing = max(storing, COLOURED)
    return tiles * texels * images + max(texels * MASKS + BAND, texels * storing) + TRIANGLE * triangles


def check_memory(needed: float) -> None:
    """Raises BakeError where there is less than is ``needed``."""
    free = free_memory()
    if free is not None and needed > free:
        raise BakeError(
            f"needs about {needed / 1e9:.1f} GB of memory for its images, and {free / 1e9:.1f} GB are free: lower "
            "Resolution, or close what takes memory"
        )
