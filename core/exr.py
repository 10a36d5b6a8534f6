# SPDX-License-Identifier: GPL-3.0-or-later
"""Float maps as OpenEXR files.

Channels are called R, G, B and A, whatever they hold. Those are the names by which Blender's Image Texture, game
engines and painting programs find the four channels of a texture; with names such as "F0.V" they see layers, or
nothing. What each holds is said in the file's metadata.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

CODECS = ("NONE", "RLE", "ZIPS", "ZIP", "PIZ")
"""Those of OpenEXR's compressions that keep every bit. The others are made for pictures: what an eye does not see in a
colour is still light when it is multiplied by albedo."""


def write_exr(
    path: str | Path,
    pixels: NDArray[np.float32],
    *,
    half: bool = False,
    codec: str = "ZIP",
    metadata: Mapping[str, str] | None = None,
) -> None:
    """Write ``pixels`` (h, w, 4), bottom row first as Blender keeps them, as channels R, G, B, A.

    half      16-bit floats: 11 significant bits, off by at most 2.5e-4 in [0, 1]. Else 32-bit
    codec     one of :data:`CODECS`
    metadata  attributes of the file's header

    What is there already is written over: see :func:`core.whole_files.whole_files`. Raises OSError where the file
    cannot be written.
    """
    import OpenEXR

    compression = getattr(OpenEXR, "NO_COMPRESSION" if codec == "NONE" else f"{codec}_COMPRESSION")
    header = {**(metadata or {}), "compression": compression, "type": OpenEXR.scanlineimage}
    # Single channels, not one "RGBA" array, which OpenEXR would store under that name.
    kind = np.float16 if half else np.float32
    channels = {name: np.ascontiguousarray(pixels[::-1, :, i], kind) for i, name in enumerate("RGBA")}
    try:
        with OpenEXR.File(header, channels) as file:
            file.write(str(path))
    except RuntimeError as error:
        raise OSError(f"cannot write {path}: {error}") from error


def read_exr(path: str | Path) -> NDArray[np.float32]:
    """Pixels (h, w, 4) float32, bottom row first, of a file that :func:`write_exr` wrote."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels for name in "RGBA"], axis=-1)[::-1].astype(np.float32)


def read_metadata(path: str | Path) -> dict[str, str]:
    """The text attributes of a file's header. Raises OSError where it cannot be read."""
    import OpenEXR

    try:
        with OpenEXR.File(str(path), header_only=True) as file:
            return {name: value for name, value in file.header().items() if isinstance(value, str)}
    except RuntimeError as error:
        raise OSError(f"cannot read {path}: {error}") from error
