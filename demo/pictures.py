# SPDX-License-Identifier: GPL-3.0-or-later
"""From linear renders to the PNGs, and how far they are from the path-traced reference."""

from pathlib import Path

import bpy
import numpy as np
from captions import render_text

SKY_LIGHT = np.array([0.27, 0.33, 0.44])
BACKDROP_TOP = np.array([0.52, 0.60, 0.68])
BACKDROP_LOW = np.array([0.78, 0.80, 0.80])
HERO_SKY_TOP = np.array([0.10, 0.24, 0.42])
HERO_SKY_LOW = np.array([0.80, 0.70, 0.55])
CAPTION_HEIGHT = 62
GAP = 8
# Left, top, width, height of the detail in the comparison: the niche.
DETAIL = (239, 68, 264, 272)


def over_sky(render: np.ndarray, top: np.ndarray, low: np.ndarray) -> np.ndarray:
    """RGB of a premultiplied RGBA render over a vertical gradient that ends at the horizon, half way down."""
    down = np.clip(np.arange(len(render)) / (0.55 * len(render)), 0, 1)[:, None, None]
    return render[..., :3] + (1 - render[..., 3:]) * (top + (low - top) * down)


def hero(ambient: np.ndarray, sunlight: np.ndarray) -> np.ndarray:
    """What a game engine would show: baked ambient under a bluish sky, plus the sun with its shadows."""
    lit = np.concatenate([ambient[..., :3] * SKY_LIGHT + sunlight[..., :3], ambient[..., 3:]], axis=-1)
    return over_sky(lit, HERO_SKY_TOP, HERO_SKY_LOW)


def against_reference(render: np.ndarray, reference: np.ndarray) -> dict[str, float]:
    """rms and mean of linear RGB differences over the pixels that surfaces cover wholly."""
    covered = (reference[..., 3] > 0.999) & (render[..., 3] > 0.999)
    difference = (render - reference)[covered][:, :3]
    return {"rms": float(np.sqrt(np.mean(difference**2))), "mean": float(difference.mean())}


def save_picture(linear: np.ndarray, path: Path) -> None:
    """Write linear RGB (height, width, 3) through the scene's view transform, as PNG or JPEG by the file's name."""
    height, width, _ = linear.shape
    image = bpy.data.images.new(path.stem, width, height, float_buffer=True)
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = linear[::-1]
    image.pixels.foreach_set(pixels.ravel())
    settings = bpy.context.scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_mode = ("JPEG" if path.suffix == ".jpg" else "PNG"), "RGB"
    settings.color_depth = "8"
    settings.compression, settings.quality = 90, 92
    image.save_render(str(path), scene=bpy.context.scene)
    bpy.data.images.remove(image)


def comparison(columns: list[tuple[str, str, np.ndarray]]) -> np.ndarray:
    """Details of several pictures side by side, each under its title and a line of smaller text."""
    left, top, width, height = DETAIL
    strip_width = len(columns) * (width + GAP) - GAP
    strip = np.full((CAPTION_HEIGHT + height, strip_width, 3), 0.012)
    lines = []
    for i, (title, note, picture) in enumerate(columns):
        x = i * (width + GAP)
        strip[CAPTION_HEIGHT:, x : x + width] = picture[top : top + height, left : left + width]
        lines += [(title, x + 4, 27, 23), (note, x + 4, 51, 16)]
    text = render_text(lines, strip_width, CAPTION_HEIGHT)[..., None]
    strip[:CAPTION_HEIGHT] = strip[:CAPTION_HEIGHT] * (1 - text) + 0.85 * text
    return strip


def save_field(folder: Path, before: np.ndarray, after: np.ndarray) -> None:
    """Write the pictures without the prop's field and with it."""
    for name, render in (("field_before", before), ("field_after", after)):
        save_picture(over_sky(render, BACKDROP_TOP, BACKDROP_LOW), folder / f"{name}.png")


def save_all(
    folder: Path,
    flat: np.ndarray,
    grey: np.ndarray,
    bounced: np.ndarray,
    reference: np.ndarray,
    sunlight: np.ndarray,
) -> dict[str, dict[str, float]]:
    """Write every picture; returns the differences of the first three from the reference, by file stem."""
    renders = {"before": flat, "ao_only": grey, "after": bounced, "path_traced": reference}
    titles = {
        "before": "Flat ambient",
        "ao_only": "Gray AO",
        "after": "Multibounce AO",
        "path_traced": "Path traced",
    }
    differences = {name: against_reference(renders[name], reference) for name in ("before", "ao_only", "after")}
    columns = []
    for name, render in renders.items():
        picture = over_sky(render, BACKDROP_TOP, BACKDROP_LOW)
        save_picture(picture, folder / f"{name}.png")
        note = f"rms difference {differences[name]['rms']:.3f}" if name in differences else "the reference, 12 bounces"
        columns.append((titles[name], note, picture))
    save_picture(comparison(columns), folder / "comparison.png")
    save_picture(hero(bounced, sunlight), folder / "hero.png")
    return differences
