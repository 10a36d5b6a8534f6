# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion fields as files: OpenEXR cubemaps, and a JSON file that names and explains them.

    <name>_ao_field_occlusion.exr   R, G, B, A = a, b, c, r0
    <name>_ao_field_direction.exr   R, G, B, A = C0 x, y, z, and a'
    <name>_ao_field_moment.exr      R, G, B, A = b', c', d, e: a', b', c' are a, b, c of Omega_M
    <name>_ao_field_volume.exr      R, G, B, A = M x, y, z, and Omega; not always there
    <name>_ao_field.json

Cubemaps are n wide and 6n high with the attribute ``envmap`` = cube; OpenEXR's order of the faces and their orientation
is that of :mod:`core.cubemap`. Their numbers are 32-bit. The volume is no
cubemap but 16 slices of 16 x 16 below each other, its numbers 16-bit: columns are x, rows y within z, each from its
least.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .ao_field import AOField, FieldVolume
from .whole_files import whole_files

# Of the files' layout: a reader refuses what it does not know. The first had 0 in place of d, and no e, which was 1.
VERSION = 2
READ_VERSIONS = (1, 2)
MODEL = (
    "Omega = 1/(a r^2 + b r + c + d r sqrt(r^2 - r0^2)) at max(r, r0) from the centre, "
    "Upsilon = normalize((r0/r)^e C0 - r0 omega); Omega_M as Omega with a', b', c'; see docs/ao_fields.md"
)


def save_field(field: AOField, folder: str | Path, name: str) -> list[Path]:
    """Write ``field`` into ``folder`` as files that begin with ``name``; returns their paths, the JSON file last.

    All are written under other names first and then renamed, the JSON file last, so that a crash leaves no half of
    one. A volume of an earlier field goes. Raises OSError where the folder cannot be written.
    """
    folder = Path(folder)
    images = {
        "occlusion": _tall(field.a, field.b, field.c, field.r0),
        "direction": _tall(*np.moveaxis(field.c0, -1, 0), field.a_m),
        "moment": _tall(field.b_m, field.c_m, field.d, field.e),
    }
    if field.volume is not None:
        # z, y, x: the slices below each other.
        slices = field.volume.values.transpose(2, 1, 0, 3).astype(np.float16)
        images["volume"] = slices.reshape(-1, *slices.shape[2:])
    files = {key: f"{name}_ao_field_{key}.exr" for key in images}
    finals = [folder / each for each in (*files.values(), f"{name}_ao_field.json")]
    try:
        with whole_files(*finals) as parts:
            for part, (key, pixels) in zip(parts, images.items(), strict=False):
                _write(part, pixels, is_cube=key != "volume")
            parts[-1].write_text(json.dumps(_described(field, files), indent=2) + "\n", encoding="utf-8")
    except RuntimeError as error:
        raise OSError(f"cannot write the AO field {name} into {folder}: {error}") from error
    if field.volume is None:
        (folder / f"{name}_ao_field_volume.exr").unlink(missing_ok=True)
    return finals


def load_field(path: str | Path) -> AOField:
    """The field of the JSON file ``path``, with the very numbers that were saved.

    Raises OSError where a file is missing or is no image, ValueError where it is not of this version or not whole.
    """
    path = Path(path)
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
        if told["version"] not in READ_VERSIONS:
            raise ValueError(f"{path} is an AO field of version {told['version']}; this reads {READ_VERSIONS}")
        n, files = told["resolution"], {key: path.with_name(name) for key, name in told["files"].items()}
        a, b, c, r0 = _faces(_read(files["occlusion"], "RGBA", (6 * n, n)), n)
        *c0, a_m = _faces(_read(files["direction"], "RGBA", (6 * n, n)), n)
        b_m, c_m, d, *e = _faces(_read(files["moment"], "RGB" if told["version"] == 1 else "RGBA", (6 * n, n)), n)
        volume = None
        if "volume" in told:
            m = told["volume"]["resolution"]
            slices = _read(files["volume"], "RGBA", (m * m, m)).reshape(m, m, m, 4)
            ends = (np.array(told["volume"][end], np.float64) for end in ("low", "high"))
            volume = FieldVolume(slices.transpose(2, 1, 0, 3).copy(), *ends, told["volume"]["p"])
        return AOField(
            centre=np.array(told["centre"], np.float64),
            **{key: told[key] for key in ("radius", "r_near", "r_far")},
            **{"a": a, "b": b, "c": c, "d": d, "r0": r0, "a_m": a_m, "b_m": b_m, "c_m": c_m},
            **{"c0": np.stack(c0, axis=-1), "e": e[0] if e else np.ones_like(r0)},
            **{"a0": told["A0"], "p": told["p"], "volume": volume},
        )
    except (KeyError, TypeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path} is not the JSON file of an AO field: {error!r}") from error


def _described(field: AOField, files: dict[str, str]) -> dict:
    """What the JSON file says."""
    told = {
        "version": VERSION,
        "model": MODEL,
        "units": "object-space metres, steradians",
        "resolution": field.resolution,
        "centre": field.centre.tolist(),
        **{"radius": field.radius, "r_near": field.r_near, "r_far": field.r_far, "A0": field.a0, "p": field.p},
        "files": files,
    }
    if field.volume is not None:
        volume = field.volume
        told["volume"] = {"resolution": len(volume.values), "low": volume.low.tolist(), "high": volume.high.tolist()}
        told["volume"]["p"] = volume.p
    return told


def _tall(*maps: NDArray) -> NDArray[np.float32]:
    """Maps (6, n, n), one a channel, as an image (6n, n, channels)."""
    image = np.stack(maps, axis=-1).astype(np.float32)
    return image.reshape(-1, *image.shape[2:])


def _faces(image: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    """The channels (channels, 6, n, n) of an image (6n, n, channels)."""
    return np.moveaxis(image.reshape(6, n, n, -1), -1, 0).copy()


def _write(path: Path, pixels: NDArray, is_cube: bool) -> None:
    """``pixels`` (h, w, 4), top row first, as channels R, G, B, A of their own type."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if is_cube:
        header["envmap"] = OpenEXR.ENVMAP_CUBE
    # Single channels: core/exr.py says why.
    channels = {name: np.ascontiguousarray(each) for name, each in zip("RGBA", np.moveaxis(pixels, -1, 0), strict=True)}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))


def _read(path: Path, names: str, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Channels ``names`` of the file, (*shape, channels), top row first."""
    import OpenEXR

    try:
        with OpenEXR.File(str(path), separate_channels=True) as file:
            channels = file.channels()
            pixels = np.stack([channels[name].pixels for name in names], axis=-1).astype(np.float64)
    except RuntimeError as error:
        raise OSError(f"cannot read {path}: {error}") from error
    if pixels.shape[:2] != shape:
        raise ValueError(f"{path} has {pixels.shape[1]} x {pixels.shape[0]} pixels, not {shape[1]} x {shape[0]}")
    return pixels
