# SPDX-License-Identifier: GPL-3.0-or-later
"""The images of a texture bake: packed in the .blend, or as files."""

from __future__ import annotations

import json
import os
import tempfile
import zlib
from collections.abc import Collection
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from .map_owner import blend_name
from .names import (
    AO_MAP,
    BENT_CONE,
    BENT_NORMAL,
    CHANNELS,
    COLORED_AO_MAP,
    MEANINGS,
    MULTIBOUNCE_AO,
    PROPERTY,
    RADIOSITY,
)
from .report import BakeError
from .settings import BakeSettings
from .version import extension_version

FILE_SUFFIX = {
    MULTIBOUNCE_AO: "_multibounce_ao.exr",
    RADIOSITY: "_multibounce_radiosity.exr",
    BENT_CONE: "_bent_cone.exr",
    BENT_NORMAL: "_bent_normal.png",
    AO_MAP: "_ao.png",
    COLORED_AO_MAP: "_colored_ao.png",
}

# The number of a tile in a file's name, as Blender writes it.
UDIM = "<UDIM>"


def is_nowhere(setting: str) -> bool:
    """Whether the folder ``output_directory`` is relative to a .blend that is not saved yet."""
    return setting.startswith("//") and not bpy.data.filepath


def output_folder(setting: str) -> str:
    """Absolute folder of ``output_directory``, made and tried; empty where images are packed. Raises BakeError."""
    if not setting:
        return ""
    if is_nowhere(setting):
        raise BakeError(
            f"Output '{setting}' is relative to a .blend that is not saved yet: save it, or choose another folder"
        )
    folder = os.path.abspath(bpy.path.abspath(setting))
    try:
        os.makedirs(folder, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
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


def map_names(settings: BakeSettings) -> tuple[str, ...]:
    """The maps for other programs that a texture bake leaves."""
    wanted = {
        BENT_NORMAL: settings.use_bent_normal_map,
        AO_MAP: settings.use_ao_map or settings.use_gltf_occlusion,
        COLORED_AO_MAP: settings.use_colored_ao_map,
    }
    return tuple(name for name, is_wanted in wanted.items() if is_wanted)


def image_channels(settings: BakeSettings) -> tuple[str, ...]:
    """What a texture bake leaves an image of."""
    return CHANNELS[settings.bounces] + map_names(settings)


def file_path(
    obj: bpy.types.Object, channel: str, folder: str, extension: str | None = None, has_tiles: bool = False
) -> Path:
    """File of ``channel`` inside ``folder``, whatever characters the object's name has, and no other object's; with the
    ``extension`` that is usual for it, or another, and the place of a tile's number where it ``has_tiles``."""
    suffix = Path(FILE_SUFFIX[channel])
    end = f"{suffix.stem}{f'.{UDIM}' if has_tiles else ''}{extension or suffix.suffix}"
    others = [other for other in bpy.data.objects if other.type == "MESH" and other != obj]
    # Names that differ only in what a file name cannot show, and files named after an object that was renamed since.
    stems = {bpy.path.clean_name(other.name).lower() for other in others}
    shown = {_file_of(image) for other in others for image in recorded_images(other).values()}
    stem = clean_name = bpy.path.clean_name(obj.name)
    digest = zlib.crc32(obj.name.encode())
    while stem.lower() in stems or _comparable(path := Path(folder) / (stem + end)) in shown:
        stem = f"{clean_name}_{digest:08x}"
        digest = zlib.crc32(stem.encode())
    return path


def image_files(image: bpy.types.Image) -> list[str]:
    """The files that ``image`` shows, one a tile where it has tiles."""
    path = bpy.path.abspath(image.filepath)
    return [path.replace(UDIM, str(tile.number)) for tile in image.tiles] if image.source == "TILED" else [path]


def file_metadata(obj: bpy.types.Object, channel: str, uv_map: str, settings: BakeSettings) -> dict[str, str]:
    """What the header of a file says: who wrote it, and as JSON what its channels hold and how they were baked."""
    version = extension_version()
    told = {
        "version": version,
        "blend": blend_name(),
        "object": obj.name,
        "uv_map": uv_map,
        "channels": dict(zip("RGBA", MEANINGS[channel], strict=False)),
        "settings": settings.as_property(),
    }
    return {"software": f"Multibounce AO {version}", PROPERTY: json.dumps(told)}


def check_image_names(obj: bpy.types.Object, channels: Collection[str]) -> None:
    """Raises BakeError where an image that is no bake has a name that the bake needs: it may be the artist's work."""
    for channel in channels:
        image = bpy.data.images.get((image_name(obj, channel), None))
        if image is not None and PROPERTY not in image:
            raise BakeError(f"would replace the image '{image.name}', which is no bake: rename or remove that image")


def recorded_images(obj: bpy.types.Object) -> dict[str, bpy.types.Image]:
    """By channel, the images that bakes of ``obj`` left: its record points to them, whatever names they have by now."""
    images = obj.get(PROPERTY, {}).get("images", {})
    return {channel: image for channel, image in images.items() if image is not None}


def images_of_only(objects: Collection[bpy.types.Object]) -> set[bpy.types.Image]:
    """The recorded images of ``objects`` that no other object has; a duplicate has those of its original."""
    images = {image for obj in objects for image in recorded_images(obj).values()}
    return images - {
        image for other in bpy.data.objects if other not in objects for image in recorded_images(other).values()
    }


def store_image(obj: bpy.types.Object, channel: str, pixels: NDArray[np.float32]) -> str:
    """Keep ``pixels`` (h, w, 4), bottom row first, as the packed image of ``channel``; returns its name."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(channel, width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
    image.pack()
    image.buffers_free()  # until somebody looks at it: large ones take gigabytes
    keep_image(obj, channel, image)
    return image.name


def store_file(
    obj: bpy.types.Object, channel: str, path: Path, colour_space: str, tiles: list[int], is_packed: bool
) -> list[str]:
    """Keep what the file ``path`` holds, or those of its ``tiles``, as the image of ``channel``; returns the files, or
    the image's name where it ``is_packed``, so that the files may go."""
    shown = str(path) if is_packed else as_blender_shows_it(path)
    # The first tile by its own name: Blender finds none by the pattern of all in a folder such as "maps é".
    image = bpy.data.images.load(shown.replace(UDIM, str(tiles[0])) if tiles else shown, check_existing=False)
    if tiles:
        image.source = "TILED"
        image.filepath_raw = shown
        image.tiles[0].number = tiles[0]
        for number in tiles[1:]:
            image.tiles.new(tile_number=number)
    image.colorspace_settings.name = colour_space
    if is_packed:
        image.pack()
        image.filepath_raw = f"//{path.name}"
        for packed in image.packed_files:  # each of a tile has the path of its own
            packed.filepath = f"//{Path(packed.filepath).name}"
    keep_image(obj, channel, image)
    if is_packed:
        return [image.name]
    return [str(path).replace(UDIM, str(number)) for number in tiles] if tiles else [str(path)]


def keep_image(obj: bpy.types.Object, channel: str, image: bpy.types.Image) -> None:
    """Let ``image`` take the place of the one of an earlier bake, which hands its users over, unless a duplicate of
    ``obj`` has it too. The record of ``obj`` points to the new one."""
    image.alpha_mode = "CHANNEL_PACKED"
    image[PROPERTY] = True
    previous = recorded_images(obj).get(channel)
    if previous in images_of_only({obj}):
        image.use_fake_user |= previous.use_fake_user
        previous.user_remap(image)
        bpy.data.images.remove(previous)
    if PROPERTY not in obj:
        obj[PROPERTY] = {}
    # Blender also saves the image for this, where no material has it.
    obj[PROPERTY]["images"] = recorded_images(obj) | {channel: image}
    _name_after(image, obj, channel)


def _name_after(image: bpy.types.Image, obj: bpy.types.Object, channel: str) -> None:
    """Name ``image``; another bake that has this name from the time before an object was renamed, gives it up."""
    name = image_name(obj, channel)
    taken = bpy.data.images.get((name, None))
    if taken not in (None, image) and PROPERTY in taken:
        owner = next((other for other in bpy.data.objects if recorded_images(other).get(channel) == taken), None)
        if owner is None:
            taken.name = channel
        else:
            _name_after(taken, owner, channel)
    image.name = name


def _file_of(image: bpy.types.Image) -> str:
    return _comparable(bpy.path.abspath(image.filepath))


def _comparable(path: Path | str) -> str:
    return os.path.abspath(path).lower()


def as_blender_shows_it(path: Path) -> str:
    """``path`` relative to a saved .blend on the same drive, else absolute."""
    try:
        return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)
    except ValueError:
        return str(path)
