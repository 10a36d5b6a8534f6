# SPDX-License-Identifier: GPL-3.0-or-later
"""Where an AO field goes: the atlas that shaders read, packed in the .blend, and files for other programs."""

from __future__ import annotations

import zlib

import bpy

from ..core.ao_field import AOField
from ..shader_nodes.field_atlas import atlas_pixels
from .field_record import FIELD

AO_FIELD = "AO Field"
"""Image ``<object> AO Field``: the atlas."""


def store_atlas(field: AOField) -> bpy.types.Image:
    """The atlas of ``field`` as a new packed image, named by its caller."""
    pixels = atlas_pixels(field)
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(AO_FIELD, width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    image.use_half_precision = False  # the denominator a r^2 + b r + c is a difference
    image[FIELD] = True
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def write_field(obj: bpy.types.Object, field: AOField, folder: str) -> list[str]:
    """Write ``field`` into ``folder`` as OpenEXR cubemaps and JSON; returns the paths. Raises OSError."""
    from ..core.field_files import save_field

    return [str(path) for path in save_field(field, folder, _stem(obj))]


def _stem(obj: bpy.types.Object) -> str:
    """The object's name as file names can show it, and no other object's."""
    clean_name = bpy.path.clean_name(obj.name)
    others = (other for other in bpy.data.objects if other.type == "MESH" and other != obj)
    if clean_name.lower() in (bpy.path.clean_name(other.name).lower() for other in others):
        return f"{clean_name}_{zlib.crc32(obj.name.encode()):08x}"
    return clean_name
