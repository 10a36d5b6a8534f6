# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture a comparison: the shade by every model and by path tracing, and below, what each is off."""

from pathlib import Path

import numpy as np
from captions import render_text
from pictures import BACKDROP_LOW, BACKDROP_TOP, over_sky, save_picture

from .measure import Comparison
from .models import MODELS

HEADER, GAP = 46, 4
DARK, LIGHT = 0.012, 0.85
# What differences are multiplied by, about the middle grey of the screen.
ENLARGED = 5


def _to_linear(shown: np.ndarray) -> np.ndarray:
    """Linear light of values in [0, 1] as an sRGB screen takes them (IEC 61966-2-1)."""
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def _difference(render: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """The difference about grey, and grey where there is no surface."""
    off = np.where(truth[..., 3:] > 0.999, (render - truth)[..., :3], 0)
    return _to_linear(np.clip(0.5 + ENLARGED * off, 0, 1))


def save_strip(comparison: Comparison, folder: Path) -> Path:
    """Write `<folder>/bounces_<name>.jpg`; returns its path."""
    subject, truth = comparison.subject, comparison.truth
    left, top, width, height = subject.detail
    columns = len(MODELS) + 1
    strip = np.full((HEADER + 2 * height + GAP, columns * (width + GAP) - GAP, 3), DARK)

    def place(column: int, y: int, picture: np.ndarray) -> None:
        x = column * (width + GAP)
        strip[y : y + height, x : x + width] = picture[top : top + height, left : left + width]

    def shown(render: np.ndarray) -> np.ndarray:
        lit = np.concatenate([subject.gain * render[..., :3], render[..., 3:]], axis=-1)
        return over_sky(lit, BACKDROP_TOP, BACKDROP_LOW)

    lines = []
    for i, model in enumerate(MODELS):
        render = comparison.renders[model.name]
        place(i, HEADER, shown(render))
        place(i, HEADER + height + GAP, _difference(render, truth))
        x = i * (width + GAP) + 3
        off = f"mean |difference| {comparison.difference(model.name).absolute:.4f}"
        lines += [(model.title, x, 20, 18), (off, x, 38, 14)]
    place(len(MODELS), HEADER, shown(truth))
    x = len(MODELS) * (width + GAP) + 3
    lines += [("Path traced", x, 20, 18), (f"its noise {comparison.noise:.4f}", x, 38, 14)]
    below = HEADER + height + GAP + 34
    notes = ("Below each: its difference", f"from this, {ENLARGED} times enlarged.", "Gray: none. Lighter: too bright.")
    lines += [(note, x + 6, below + 22 * i, 15) for i, note in enumerate(notes)]
    text = render_text(lines, strip.shape[1], strip.shape[0])[..., None]
    path = folder / f"bounces_{comparison.name}.jpg"
    save_picture(strip * (1 - text) + LIGHT * text, path)
    return path
