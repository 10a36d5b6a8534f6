# SPDX-License-Identifier: GPL-3.0-or-later
"""Float maps as OpenEXR files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


def write_exr(path: str | Path, pixels: NDArray[np.float32]) -> None:
    """Write ``pixels`` (h, w, 4), bottom row first as Blender keeps them, as 32-bit R, G, B, A, ZIP compressed.

    The file is written beside its final name and then renamed, so a crash leaves the old one. Raises OSError where the
    folder cannot be written.
    """
    import OpenEXR

    path = Path(path)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    image = np.ascontiguousarray(pixels[::-1], np.float32)
    # Single channels, not one "RGBA" array: programs that look for R, G, B, A by name find them.
    channels = {name: np.ascontiguousarray(image[..., i]) for i, name in enumerate("RGBA")}
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.part.exr")
    try:
        with OpenEXR.File(header, channels) as file:
            file.write(str(unfinished))
        os.replace(unfinished, path)
    except RuntimeError as error:
        raise OSError(f"cannot write {path}: {error}") from error
    finally:
        unfinished.unlink(missing_ok=True)


def read_exr(path: str | Path) -> NDArray[np.float32]:
    """Pixels (h, w, 4) float32, bottom row first, of a file that :func:`write_exr` wrote."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels for name in "RGBA"], axis=-1)[::-1].copy()
