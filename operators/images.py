# SPDX-License-Identifier: GPL-3.0-or-later
"""The images of a texture bake: packed in the .blend, or as OpenEXR files."""

from __future__ import annotations

import os
import tempfile
import zlib
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from .names import BENT_CONE, MULTIBOUNCE_AO, PROPERTY
from .report import BakeError

FILE_SUFFIX = {MULTIBOUNCE_AO: "_multibounce_ao.exr", BENT_CONE: "_bent_cone.exr"}


def output_folder(setting: str) -> str:
    """Absolute folder of ``output_directory``, made and tried; empty where images are packed. Raises BakeError."""
    if not setting:
        return ""
    if setting.startswith("//") and not bpy.data.filepath:
        raise BakeError(
            f"Output '{setting}' is relative to a .blend that is not saved yet: save it, or choose another folder"
        )
    folder = os.path.abspath(bpy.path.abspath(setting))
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = error.strerror.lower()
        raise BakeError(
            f"Output '{folder}' cannot be written ({reason}): choose another folder, or none to pack"
        ) from None
    return folder


def image_name(obj: bpy.types.Object, channel: str) -> str:
    """``<object> <channel>``; the object's part is shortened, and kept apart from others, past Blender's 63 bytes."""
    name = f"{obj.name} {channel}"
    if len(name.encode()) <= 63:
        return name
    suffix = f"_{zlib.crc32(obj.name.encode()):08x} {channel}"
    return obj.name.encode()[: 63 - len(suffix)].decode(errors="ignore") + suffix


def file_path(obj: bpy.types.Object, channel: str, folder: str) -> Path:
    """File of ``channel`` inside ``folder``, whatever characters the object's name has, and no other object's."""
    stem = bpy.path.clean_name(obj.name)
    # Names that differ only in what a file name cannot show.
    if any(bpy.path.clean_name(other.name).lower() == stem.lower() for other in bpy.data.objects if other != obj):
        stem += f"_{zlib.crc32(obj.name.encode()):08x}"
    return Path(folder) / (stem + FILE_SUFFIX[channel])


def check_image_names(obj: bpy.types.Object) -> None:
    """Raises BakeError where an image that is no bake has a name that the bake needs: it may be the artist's work."""
    for channel in FILE_SUFFIX:
        image = bpy.data.images.get((image_name(obj, channel), None))
        if image is not None and PROPERTY not in image:
            raise BakeError(f"would replace the image '{image.name}', which is no bake: rename or remove that image")


def find_image(obj: bpy.types.Object, channel: str) -> bpy.types.Image | None:
    """The image that a bake of ``obj`` left, if any."""
    image = bpy.data.images.get((image_name(obj, channel), None))
    return image if image is not None and PROPERTY in image else None


def store_image(obj: bpy.types.Object, channel: str, pixels: NDArray[np.float32], folder: str) -> str:
    """Keep ``pixels`` (h, w, 4), bottom row first, as the image of ``channel``; returns its name if it is packed.

    With a ``folder`` its file is there already: the image shows that file, whose path is returned. An older image of
    that name hands its users over.
    """
    name = image_name(obj, channel)
    if folder:
        path = file_path(obj, channel, folder)
        image = bpy.data.images.load(_as_blender_shows_it(path), check_existing=False)
    else:
        height, width = pixels.shape[:2]
        image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    image[PROPERTY] = True
    image.use_fake_user = True  # Blender saves no image that nothing uses, not even a packed one
    if not folder:
        image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
        image.pack()
    previous = bpy.data.images.get((name, None))
    if previous is not None and previous != image:
        previous.user_remap(image)
        bpy.data.images.remove(previous)
    image.name = name
    return str(path) if folder else name


def remove_images(obj: bpy.types.Object) -> None:
    """Take back the images of ``obj``; files on disk stay."""
    for channel in (MULTIBOUNCE_AO, BENT_CONE):
        image = find_image(obj, channel)
        if image is not None:
            bpy.data.images.remove(image)


def _as_blender_shows_it(path: Path) -> str:
    """``path`` relative to a saved .blend on the same drive, else absolute."""
    try:
        return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)
    except ValueError:
        return str(path)
