# SPDX-License-Identifier: GPL-3.0-or-later
"""What a texture bake leaves: images, packed in the .blend or in files, one or one a tile."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.exr import write_exr
from ..core.whole_files import whole_files
from .derived_maps import colour_space, derive, extension, write_map
from .images import UDIM, file_metadata, file_path, image_channels, map_names, store_file, store_image
from .map_owner import blend_name, map_owner
from .names import CHANNELS
from .settings import BakeSettings


@dataclass(frozen=True)
class Tile:
    """Images (h, w, 4) by channel, and the base colour (h, w, 3) where a map needs it; all float32."""

    channels: dict[str, NDArray[np.float32]]
    albedo: NDArray[np.float32] | None


@dataclass(frozen=True)
class TextureResult:
    """The tiles of one object by number, ready to be stored in ``folder``, or packed where that is empty. Without UDIM
    that is tile 1001 alone."""

    obj: bpy.types.Object
    uv_map: str
    folder: str
    settings: BakeSettings
    tiles: dict[int, Tile]

    def write(self) -> list[str]:
        """Store the images and let go of them here; returns their files or names. Raises OSError where a file cannot
        be written."""
        names = image_channels(self.settings)
        stored = self._write_files(names, Path(self.folder)) if self.folder else self._pack(names)
        self.tiles.clear()
        return stored

    def replaces(self) -> list[str]:
        """Warnings of files that :meth:`write` is going to replace though the bake of another .blend left them. No
        error: that may be an earlier version of this one."""
        if not self.folder:
            return []
        names = image_channels(self.settings)
        files = [self._of_tile(self._path(name, Path(self.folder)), number) for name in names for number in self.tiles]
        owners = dict.fromkeys(map(map_owner, files))
        return [
            f"Replaced the map of '{name}' in '{blend}': give one of them another output folder"
            for blend, name in owners
            if blend not in ("", blend_name())
        ]

    def _pack(self, names: tuple[str, ...]) -> list[str]:
        with TemporaryDirectory() as folder:
            if self.settings.use_udim:
                return self._write_files(names, Path(folder))
            maps = self._write_files(map_names(self.settings), Path(folder))
        # The others straight from memory to the image, which then is all that has them.
        (tile,) = self.tiles.values()
        return [store_image(self.obj, name, tile.channels.pop(name)) for name in CHANNELS[self.settings.bounces]] + maps

    def _write_files(self, names: tuple[str, ...], folder: Path) -> list[str]:
        # All files before any of them takes its name, and before any image: where one cannot be written, the disk and
        # the .blend stay as they were.
        files = {name: self._path(name, folder) for name in names}
        of_tiles = {(name, number): self._of_tile(files[name], number) for name in names for number in self.tiles}
        with whole_files(*of_tiles.values()) as parts:
            for (name, number), part in zip(of_tiles, parts, strict=True):
                self._write(part, name, self.tiles[number])
        tiles = list(self.tiles) if self.settings.use_udim else []
        return [
            output
            for name in names
            for output in store_file(self.obj, name, files[name], self._colour_space(name), tiles, not self.folder)
        ]

    def _path(self, name: str, folder: Path) -> Path:
        ending = extension(self.settings) if self._is_map(name) else None
        return file_path(self.obj, name, str(folder), ending, self.settings.use_udim)

    def _of_tile(self, path: Path, number: int) -> Path:
        return path.with_name(path.name.replace(UDIM, str(number)))

    def _write(self, path: Path, name: str, tile: Tile) -> None:
        # What is packed has full floats.
        settings = self.settings if self.folder else replace(self.settings, color_depth="32")
        metadata = file_metadata(self.obj, name, self.uv_map, settings)
        if self._is_map(name):
            write_map(path, name, derive(name, tile.channels, tile.albedo), settings, metadata)
            return
        half = settings.color_depth == "16"
        write_exr(path, tile.channels[name], half=half, codec=settings.exr_codec, metadata=metadata)

    def _colour_space(self, name: str) -> str:
        return colour_space(name, self.settings) if self._is_map(name) else "Non-Color"

    def _is_map(self, name: str) -> bool:
        return name in map_names(self.settings)
