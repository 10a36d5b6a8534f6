# SPDX-License-Identifier: GPL-3.0-or-later
"""Where bounce curves go: a CSV file and a PNG, or a text and a packed image in the .blend."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.whole_files import whole_files
from .images import as_blender_shows_it, image_name
from .names import PROPERTY
from .report import BakeError

BOUNCE_CURVES = "Bounce Curves"
"""Image ``<source> Bounce Curves``: the plot; a text of the same name: the curves as CSV."""

FILE_SUFFIX = "_bounce_curves"


def check_names(source: bpy.types.ID, folder: str) -> None:
    """Raises BakeError where an image, or without a ``folder`` a text, that is not ours has the name that the curves of
    ``source`` need: it may be the artist's work. Messages go on from "Object 'name' "."""
    name = image_name(source, BOUNCE_CURVES)
    for kind, blocks in (("image", bpy.data.images), ("text", bpy.data.texts)):
        block = blocks.get((name, None))
        if block is not None and PROPERTY not in block and (kind == "image" or not folder):
            raise BakeError(f"would replace the {kind} '{name}', which is no plot: rename or remove that {kind}")


def store_curves(
    source: bpy.types.ID, csv: str, plot: NDArray[np.float32], folder: str
) -> tuple[bpy.types.Image, list[str]]:
    """Keep the curves of ``source``: ``csv`` and ``plot`` (h, w, 4) in [0, 1], sRGB, bottom row first.

    Returns the plot's image, and what was written: paths where there is a ``folder``, else names of data-blocks. What
    earlier curves of ``source`` left is replaced. Raises BakeError where files cannot be written.
    """
    name = image_name(source, BOUNCE_CURVES)
    image = _image(name, plot)
    if folder:
        stem = Path(folder) / (bpy.path.clean_name(source.name) + FILE_SUFFIX)
        paths = [stem.with_name(stem.name + suffix) for suffix in (".csv", ".png")]
        try:
            _write_files(image, csv, *paths)
        except (OSError, RuntimeError) as error:
            reason = (getattr(error, "strerror", None) or str(error)).strip().lower()
            raise BakeError(
                f"Bounce curves cannot be stored in '{folder}' ({reason}): choose another output folder"
            ) from None
        finally:
            bpy.data.images.remove(image)
        image = bpy.data.images.load(as_blender_shows_it(paths[1]), check_existing=False)
        outputs = [str(path) for path in paths]
    else:
        image.pack()
        outputs = [_store_text(name, csv).name, name]
    image[PROPERTY] = True
    previous = bpy.data.images.get((name, None))
    if previous is not None:
        previous.user_remap(image)
        bpy.data.images.remove(previous)
    image.name = name
    _show_in_editor(image)
    return image, outputs


def _image(name: str, plot: NDArray[np.float32]) -> bpy.types.Image:
    """The plot under some name of its own; Blender shows 8-bit images in sRGB as they are."""
    height, width = plot.shape[:2]
    image = bpy.data.images.new(f"{name} (new)", width, height, alpha=False, float_buffer=False)
    image.colorspace_settings.name = "sRGB"
    image.file_format = "PNG"
    image.pixels.foreach_set(np.ascontiguousarray(plot, np.float32).ravel())
    return image


def _write_files(image: bpy.types.Image, csv: str, csv_path: Path, png_path: Path) -> None:
    with whole_files(png_path, csv_path) as (png_part, csv_part):
        csv_part.write_text(csv, encoding="utf-8")
        image.filepath_raw = str(png_part)
        image.save()


def _store_text(name: str, csv: str) -> bpy.types.Text:
    text = bpy.data.texts.get((name, None)) or bpy.data.texts.new(name)
    text.clear()
    text.write(csv)
    text[PROPERTY] = True
    return text


def _show_in_editor(image: bpy.types.Image) -> None:
    """Show ``image`` in the first open Image Editor, if there is one that is not pinned to another."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.ui_type == "IMAGE_EDITOR" and not area.spaces.active.use_image_pin:
                area.spaces.active.image = image
                return
