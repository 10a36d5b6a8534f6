# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots as pixels: curves, dots and areas on axes, with a legend, for programs that have no plotting library."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .canvas import INK, Canvas
from .stroke_font import CAP_HEIGHT, LINE_HEIGHT, text_strokes

# Okabe and Ito 2008, "Color Universal Design": told apart with every kind of colour vision. Its yellow is left out,
# which is too light for lines on white.
BLACK, ORANGE, SKY_BLUE, GREEN, BLUE, VERMILION, PURPLE = (
    "#000000", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7",
)  # fmt: skip
GREY = "#8c8c8c"
_GRID = "#e4e4e4"

# All sizes are in pixels of an image of this height, and grow with it.
_HEIGHT = 960.0
_LETTER, _TITLE = 2.2, 2.8  # a grid unit of the font
_LEFT, _RIGHT, _TOP, _BOTTOM = 118.0, 300.0, 92.0, 108.0  # around the axes; the legend is to the right of them
_TICK, _PAD = 8.0, 14.0


@dataclass(frozen=True)
class Series:
    """One thing that a plot shows; without a ``label`` it is not in the legend, without points only there.

    x, y     (n,) float; points that are not finite part a line in two
    colour   "#rrggbb"
    style    LINE; DOTS; AREA, filled down to the x axis, with a step at each point
    width    of the line, or diameter of the dots, in pixels of a plot 960 high
    opacity  in [0, 1]
    """

    label: str
    x: ArrayLike = ()
    y: ArrayLike = ()
    colour: str = BLACK
    style: Literal["LINE", "DOTS", "AREA"] = "LINE"
    width: float = 4.0
    opacity: float = 1.0


@dataclass(frozen=True)
class Axis:
    """What is along an axis, and its first and last value."""

    label: str
    low: float = 0.0
    high: float = 1.0


def draw_plot(
    series: Sequence[Series],
    x_axis: Axis,
    y_axis: Axis,
    *,
    title: str,
    notes: Sequence[str] = (),
    width: int = 1280,
    height: int = 960,
) -> NDArray[np.float32]:
    """The ``series`` on axes, areas first, as RGBA (height, width, 4) in [0, 1]: sRGB values, the bottom row first as
    Blender keeps images. ``notes`` are lines of text below the legend.

    Memory: some 100 bytes a pixel. Raises ValueError where an axis has no length or the image has no room for the axes.
    """
    unit = height / _HEIGHT
    left, top, right, bottom = _LEFT * unit, _TOP * unit, width - _RIGHT * unit, height - _BOTTOM * unit
    if right - left < 1.0:
        raise ValueError(f"an image of {width} x {height} has no room for a plot: make it wider")
    if not (x_axis.low < x_axis.high and y_axis.low < y_axis.high):
        raise ValueError("an axis must rise from low to high")
    canvas = Canvas(width, height)

    def place(x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Pixels (n, 2), from the image's top left corner, of points (n,) of the plot."""
        across = (np.asarray(x, np.float64) - x_axis.low) / (x_axis.high - x_axis.low)
        up = (np.asarray(y, np.float64) - y_axis.low) / (y_axis.high - y_axis.low)
        return np.stack(np.broadcast_arrays(left + (right - left) * across, bottom - (bottom - top) * up), axis=-1)

    for each in series:
        if each.style == "AREA":
            canvas.area(place(each.x, each.y), bottom, each.colour, each.opacity)
    _axes(canvas, x_axis, y_axis, place, unit)
    frame = (left, top, right, bottom)
    for each in series:
        if each.style != "AREA":
            canvas.draw(_segments(each, place), each.colour, each.width * unit, each.opacity, frame)
    # A title that is too long is written smaller.
    room = (width - left - _PAD * unit) / max(text_strokes(title)[1], 1.0)
    canvas.text(title, (left, top - 34.0 * unit), min(_TITLE * unit, room))
    _legend(canvas, series, notes, (right + 32.0 * unit, top + 10.0 * unit), unit)
    return canvas.rgba()


def _axes(canvas: Canvas, x_axis: Axis, y_axis: Axis, place, unit: float) -> None:
    """Grid, ticks with their numbers, frame and labels."""
    (left, bottom), (right, top) = place((x_axis.low, x_axis.high), (y_axis.low, y_axis.high))
    ticks_x, ticks_y = _ticks(x_axis), _ticks(y_axis)
    across, up = place(ticks_x, y_axis.low)[:, 0], place(x_axis.low, ticks_y)[:, 1]
    canvas.draw(_lines(across, top, across, bottom), _GRID, 1.5 * unit)
    canvas.draw(_lines(left, up, right, up), _GRID, 1.5 * unit)
    tick = _TICK * unit
    canvas.draw(_lines(across, bottom, across, bottom + tick), INK, 1.5 * unit)
    canvas.draw(_lines(left - tick, up, left, up), INK, 1.5 * unit)
    x, y = np.array((left, right, right, left, left)), np.array((top, top, bottom, bottom, top))
    canvas.draw(_lines(x[:-1], y[:-1], x[1:], y[1:]), INK, 1.5 * unit)
    size = _LETTER * unit
    half = 0.5 * CAP_HEIGHT * size
    for x, text in zip(across, _numbers(ticks_x), strict=True):
        canvas.text(text, (x, bottom + tick + _PAD * unit + 2.0 * half), size, align=0.5)
    for y, text in zip(up, _numbers(ticks_y), strict=True):
        canvas.text(text, (left - tick - _PAD * unit, y + half), size, align=1.0)
    canvas.text(x_axis.label, (0.5 * (left + right), bottom + 82.0 * unit), size, align=0.5)
    canvas.text(y_axis.label, (left - 78.0 * unit, 0.5 * (top + bottom)), size, align=0.5, upwards=True)


def _legend(canvas: Canvas, series: Sequence[Series], notes: Sequence[str], corner, unit: float) -> None:
    """A row a labelled series, its sample and then its label, from the top left ``corner`` down; then the notes."""
    x, y = corner
    size, sample, row = _LETTER * unit, 34.0 * unit, 1.35 * LINE_HEIGHT * _LETTER * unit
    middle = 0.5 * CAP_HEIGHT * size
    for each in series:
        if not each.label:
            continue
        y += row
        if each.style == "AREA":
            block = np.array(((x, y - 2.0 * middle), (x + sample, y - 2.0 * middle)))
            canvas.area(block, y, each.colour, each.opacity)
        else:
            inset = 0.5 * sample if each.style == "DOTS" else 0.0
            line = _lines(x + inset, y - middle, x + sample - inset, y - middle)
            canvas.draw(line, each.colour, each.width * unit, each.opacity)
        canvas.text(each.label, (x + sample + _PAD * unit, y), size)
    y += row
    for note in notes:
        y += LINE_HEIGHT * size
        canvas.text(note, (x, y), size)


def _segments(series: Series, place) -> NDArray[np.float64]:
    """Of a line the segments between its points, of dots one without length each."""
    points = place(series.x, series.y)
    if series.style == "DOTS":
        segments = np.stack((points, points), axis=1)
    else:
        segments = np.stack((points[:-1], points[1:]), axis=1)
    return segments[np.isfinite(segments).all(axis=(1, 2))]


def _lines(left, top, right, bottom) -> NDArray[np.float64]:
    """Segments (n, 2, 2) from (``left``, ``top``) to (``right``, ``bottom``), of which some may be (n,)."""
    return np.stack(np.broadcast_arrays(left, top, right, bottom), axis=-1).reshape(-1, 2, 2)


def _ticks(axis: Axis) -> NDArray[np.float64]:
    """Round values on ``axis``, four to ten of them: steps of 1, 2 or 5 times a power of ten."""
    rough = (axis.high - axis.low) / 9.0
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(factor * power for factor in (1, 2, 5, 10) if factor * power >= rough * (1.0 - 1e-9))
    return step * np.arange(math.ceil(axis.low / step - 1e-9), math.floor(axis.high / step + 1e-9) + 1)


def _numbers(ticks: NDArray[np.float64]) -> list[str]:
    """``ticks`` with as many decimals as their step needs."""
    step = ticks[1] - ticks[0] if len(ticks) > 1 else 1.0
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return [f"{0.0 if abs(tick) < 1e-9 * step else tick:.{decimals}f}" for tick in ticks]
