# SPDX-License-Identifier: GPL-3.0-or-later
"""Where an AO field goes: pictures that shaders read, packed in the .blend, and files for other programs."""

from __future__ import annotations

import zlib

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.ao_field import AOField
from ..shader_nodes.field_atlas import atlas_pixels
from ..shader_nodes.field_volume import volume_pixels
from .field_record import FIELD
from .images import image_name

# By their keys in a field's record: the atlas, and the volume of a field that has one.
_IMAGE_NAMES = {"image": "AO Field", "volume_image": "AO Field Volume"}


def store_images(field: AOField) -> dict[str, object]:
    """The pictures of ``field`` as new packed images, for its record, and with a volume where that lies: its box from
    the field's centre. :func:`name_images` names them."""
    found: dict[str, object] = {"image": _packed(atlas_pixels(field))}
    if field.volume is not None:
        found["volume_image"] = _packed(volume_pixels(field.volume))
        found["volume_low"] = field.volume.low.tolist()
        found["volume_size"] = (field.volume.high - field.volume.low).tolist()
    return found


def name_images(obj: bpy.types.Object, found: dict[str, object]) -> list[str]:
    """Call the images that :func:`store_images` made after ``obj``, once those of an earlier bake are gone; returns
    their names."""
    images = {key: found[key] for key in _IMAGE_NAMES if key in found}
    for key, image in images.items():
        image.name = image_name(obj, _IMAGE_NAMES[key])
    return [image.name for image in images.values()]


def _packed(pixels: NDArray[np.float32]) -> bpy.types.Image:
    height, width = pixels.shape[:2]
    image = bpy.data.images.new("AO Field", width, height, alpha=True, float_buffer=True)
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
