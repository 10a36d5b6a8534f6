# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of images as the linear light that a texture node of them gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import bpy
import numpy as np
from numpy.typing import NDArray

from .node_origins import UnreadableError

AlphaUse = Literal["KEEP", "MULTIPLY", "DIVIDE"]

_LINEAR_OR_SRGB = ("Linear Rec.709", "sRGB")  # colour spaces of byte images
# IEC 61966-2-1, for each byte.
_BYTES = np.arange(256) / 255.0
_SRGB_TO_LINEAR = np.where(_BYTES <= 0.04045, _BYTES / 12.92, ((_BYTES + 0.055) / 1.055) ** 2.4).astype(np.float32)


def check_image(node: bpy.types.Node) -> bpy.types.Image:
    """The image of a texture ``node``. Raises UnreadableError where it is not one whose pixels are known."""
    image = node.image
    if image is None:
        raise UnreadableError(f"the node '{node.name}' without an image", "choose its image")
    if image.source not in ("FILE", "GENERATED"):
        raise UnreadableError(f"the image '{image.name}' of tiles or frames", "bake it to a single image")
    if min(image.size) == 0:
        raise UnreadableError(f"the image '{image.name}' without its file", "find the missing file")
    space = image.colorspace_settings
    if not image.is_float and not space.is_data and space.name not in _LINEAR_OR_SRGB:
        raise UnreadableError(f"the image '{image.name}' in {space.name}", "save it as sRGB")
    return image


def alpha_use(node: bpy.types.Node) -> AlphaUse:
    """What the colour of a texture ``node`` is of its image's pixels in Cycles: the pixels as they are, or what their
    alpha is to MULTIPLY or DIVIDE.

    Colours lie premultiplied in Cycles, and it divides them where the material reads alpha. Blender keeps floats
    premultiplied and bytes straight. Where Cycles 5 takes Blender's pixels and not the file, it goes by the alpha mode
    alone, of floats and of bytes.
    """
    image = node.image
    if image.colorspace_settings.is_data or image.alpha_mode not in ("STRAIGHT", "PREMUL"):
        return "KEEP"
    is_premultiplied = image.is_float
    if bpy.app.version >= (5, 0, 0) and (image.source == "GENERATED" or image.packed_file is not None):
        is_premultiplied = image.alpha_mode == "PREMUL"
    alpha = node.outputs.get("Alpha")  # an Environment Texture has none
    is_read = alpha is not None and alpha.is_linked
    if is_premultiplied:
        return "DIVIDE" if is_read else "KEEP"
    return "KEEP" if is_read else "MULTIPLY"


@dataclass(frozen=True)
class Pixels:
    """Pixels of an image as Blender gives them, ``rgba`` (h, w, 4), bottom row first: bytes as they are stored, which
    may be ``is_srgb``, and floats as linear light."""

    rgba: NDArray[np.float32]
    is_srgb: bool
    alpha: AlphaUse

    def linear(self) -> NDArray[np.float32]:
        """Linear RGB (h, w, 3). Needs no Blender."""
        rgb, opacity = np.ascontiguousarray(self.rgba[..., :3]), self.rgba[..., 3:]
        if self.is_srgb:
            for line in rgb:
                line[:] = _SRGB_TO_LINEAR[np.rint(line * 255.0).astype(np.uint8)]
        if self.alpha == "MULTIPLY":
            rgb *= opacity
        elif self.alpha == "DIVIDE":
            np.divide(rgb, opacity, out=rgb, where=opacity > 0.0)
        return rgb


def read_pixels(image: bpy.types.Image, alpha: AlphaUse) -> Pixels:
    width, height = image.size
    rgba = np.empty((height, width, 4), np.float32)
    image.pixels.foreach_get(rgba.reshape(-1))
    return Pixels(rgba, not image.is_float and image.colorspace_settings.name == "sRGB", alpha)
