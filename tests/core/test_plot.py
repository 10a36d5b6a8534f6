# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots: what is drawn lies where it should and covers as much as it should, whatever else is in the picture."""

import string

import numpy as np
import pytest

from core.bounce_curves import BounceCurves, BounceFit
from core.canvas import Canvas
from core.curve_plot import SHOWN, draw_curves
from core.plot import BLACK, BLUE, GREEN, GREY, ORANGE, PURPLE, SKY_BLUE, VERMILION, Axis, Series, draw_plot
from core.stroke_font import CAP_HEIGHT, text_strokes

RED = "#ff0000"


def darkness(canvas):
    """How much of each pixel is covered by black, the top row first."""
    return 1.0 - canvas.rgba()[::-1, :, 0].astype(float)


def plot(*series, x_axis=None, y_axis=None, **options):
    return draw_plot(series, x_axis or Axis("x"), y_axis or Axis("y"), title="Title", **options)


def reds(image):
    """Rows from the bottom and columns of what is purely red."""
    return np.nonzero((image[..., 0] > 0.99) & (image[..., 1:3] < 0.01).all(axis=-1))


# Lines are as long as they are plus two round ends, and cover what their stadium does, at any slope.
@pytest.mark.parametrize("end", [(90.0, 20.3), (20.7, 90.0), (85.0, 77.7), (20.7, 20.3)])
@pytest.mark.parametrize("width", [1.0, 2.5, 7.0])
def test_line_covers_its_area(end, width):
    start = np.array((20.7, 20.3))
    canvas = Canvas(120, 110)
    canvas.draw(np.array([[start, end]]), BLACK, width)
    length = np.hypot(*(end - start))
    expected = length * width + np.pi * width**2 / 4
    covered = darkness(canvas).sum()
    print(f"width {width}: {covered:.2f} pixels for {expected:.2f}")
    # A pixel's distance stands for its area: exact along the axes, and for round ends within a twelfth of a pixel.
    assert covered == pytest.approx(expected, rel=0.03, abs=0.35)


def test_line_is_where_its_formula_says():
    """The centre of what is covered, column by column, on a steep and a flat line."""
    canvas = Canvas(200, 200)
    canvas.draw(np.array([[(10.0, 30.0), (190.0, 120.0)]]), BLACK, 4.0)
    dark = darkness(canvas)[:, 20:180]
    rows = np.arange(200) + 0.5
    centre = (dark * rows[:, None]).sum(axis=0) / dark.sum(axis=0)
    error = np.abs(centre - (30.0 + 0.5 * (np.arange(20, 180) + 0.5 - 10.0))).max()
    print(f"largest distance from the line: {error:.4f} pixels")
    assert error < 0.05


def test_line_has_no_seams_where_pieces_meet():
    whole, cut = Canvas(300, 60), Canvas(300, 60)
    ends = np.array((7.0, 11.0)), np.array((291.0, 43.0))
    whole.draw(np.array([ends]), BLUE, 5.0, opacity=0.5)
    between = [ends[0] + t * (ends[1] - ends[0]) for t in np.sort(np.random.default_rng(0).random(40))]
    points = np.array([ends[0], *between, ends[1]])
    cut.draw(np.stack((points[:-1], points[1:]), axis=1), BLUE, 5.0, opacity=0.5)
    np.testing.assert_allclose(cut.rgba(), whole.rgba(), atol=1e-6)


def test_opacity_mixes_colours():
    canvas = Canvas(30, 30)
    canvas.draw(np.array([[(5.0, 15.0), (25.0, 15.0)]]), "#204060", 10.0, opacity=0.25)
    expected = 0.75 + 0.25 * np.array((0x20, 0x40, 0x60)) / 255
    np.testing.assert_allclose(canvas.rgba()[15, 15, :3], expected, atol=1e-6)


def test_frame_cuts_off():
    canvas = Canvas(60, 50)
    canvas.draw(np.array([[(-500.0, 25.0), (900.0, 25.0)]]), BLACK, 9.0, frame=(10, 5, 40, 27))
    rows, columns = np.nonzero(darkness(canvas))
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (20, 26, 10, 39)


def test_area_covers_its_integral():
    canvas = Canvas(100, 100)
    x, y = np.array((10.25, 30.5, 41.0, 77.7)), np.array((20.5, 60.25, 80.0, 33.3))
    canvas.area(np.column_stack((x, y)), 90.0, BLACK, 1.0)
    edges = np.array((10.25, 20.375, 35.75, 59.35, 77.7))
    assert darkness(canvas).sum() == pytest.approx(((90.0 - y) * np.diff(edges)).sum(), rel=1e-5)


def test_every_printable_letter_has_a_glyph_of_its_own():
    letters = string.ascii_letters + string.digits + string.punctuation
    glyphs = {letter: text_strokes(letter)[0].round(3).tobytes() for letter in letters}
    assert text_strokes("\u65e5")[0].tobytes() not in glyphs.values()
    assert len(set(glyphs.values())) == len(letters)
    capitals = np.concatenate([text_strokes(letter)[0] for letter in string.ascii_uppercase + string.digits])
    assert (capitals[..., 1].min(), capitals[..., 1].max()) == (0, CAP_HEIGHT)


def test_text_without_accents():
    np.testing.assert_array_equal(text_strokes("Ångström é")[0], text_strokes("Angstrom e")[0])
    segments, width = text_strokes("")
    assert segments.shape == (0, 2, 2) and width == 0


@pytest.mark.parametrize("align", [0.0, 0.5, 1.0])
def test_text_is_aligned(align):
    size, at = 3.0, (200.0, 60.0)
    canvas = Canvas(400, 100)
    canvas.text("HIM", at, size, align)
    rows, columns = np.nonzero(darkness(canvas) > 0.5)
    width = text_strokes("HIM")[1] * size
    assert columns.min() == pytest.approx(at[0] - align * width, abs=2)
    assert columns.max() == pytest.approx(at[0] + (1 - align) * width, abs=2)
    assert rows.max() == pytest.approx(at[1], abs=2)
    assert rows.min() == pytest.approx(at[1] - CAP_HEIGHT * size, abs=2)


def test_text_upwards_is_the_same_turned_to_the_left():
    flat, turned = Canvas(200, 200), Canvas(200, 200)
    flat.text("Fig. 1", (100.0, 100.0), 3.0, 0.5)
    turned.text("Fig. 1", (100.0, 100.0), 3.0, 0.5, upwards=True)
    np.testing.assert_allclose(np.rot90(darkness(flat)), darkness(turned), atol=1e-6)


def test_image_is_what_blender_takes():
    image = plot(Series("a", (0, 1), (0, 1), RED))
    assert image.shape == (960, 1280, 4) and image.dtype == np.float32
    assert image.min() >= 0 and image.max() <= 1
    np.testing.assert_array_equal(image[..., 3], 1)
    rows, columns = reds(image)
    rising = columns < 900  # without the legend
    assert np.corrcoef(rows[rising], columns[rising])[0, 1] > 0.999  # the bottom row first


@pytest.mark.parametrize("size", [(640, 480), (1280, 960), (1000, 400)])
def test_points_lie_where_the_axes_say(size):
    """Four dots, whose distances are as their values: linear, the same for any range of the axes."""
    x, y = np.array((2.5, 3.0, 4.0, 5.5)), np.array((-7.0, -1.0, 2.0, 4.0))
    image = draw_plot(
        [Series("", x, y, RED, "DOTS", width=16)],
        Axis("x", 2.0, 6.0),
        Axis("y", -10.0, 5.0),
        title="",
        width=size[0],
        height=size[1],
    )
    rows, columns = reds(image)
    nearest = np.abs(columns[:, None] - np.interp(x, x[[0, -1]], (columns.min(), columns.max()))).argmin(axis=1)
    centres = np.array([(columns[nearest == i].mean(), rows[nearest == i].mean()) for i in range(4)])
    for place, value in zip(centres.T, (x, y), strict=True):
        line = np.polyfit(value, place, 1)
        assert line[0] > 0
        np.testing.assert_allclose(place, np.polyval(line, value), atol=0.6)


def test_what_is_not_finite_parts_a_line():
    y = np.array((0.5, 0.5, np.nan, 0.5, np.inf, 0.5, 0.5))
    columns = reds(plot(Series("", np.linspace(0, 1, 7), y, RED)))[1]
    gaps = np.diff(np.unique(columns)).max()
    assert gaps > 0.4 * np.ptp(columns)


def test_curves_stay_within_the_axes():
    inside = reds(plot(Series("", (0, 1), (0, 1), RED, width=9)))
    image = plot(Series("", (-0.5, 1.5), (-0.5, 1.5), RED, width=9))
    rows, columns = reds(image)
    assert (rows.min(), columns.min()) >= (inside[0].min() - 1, inside[1].min() - 1)
    assert (rows.max(), columns.max()) <= (inside[0].max() + 1, inside[1].max() + 1)


def test_legend_has_what_is_labelled():
    bare, labelled = (plot(Series(label, (), (), RED, width=9)) for label in ("", "Something"))
    assert len(reds(bare)[0]) == 0
    rows, columns = reds(labelled)
    assert len(rows) and columns.min() > 900


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [
        (0, 1, ("0.0", "0.2", "0.4", "0.6", "0.8", "1.0")),
        (0, 1.1, ("0.0", "0.2", "0.4", "0.6", "0.8", "1.0")),
        (0, 30, ("0", "5", "10", "15", "20", "25", "30")),
        (-2e-3, 2e-3, ("-0.0020", "-0.0015", "-0.0010", "-0.0005", "0.0000", "0.0005", "0.0010", "0.0015", "0.0020")),
        (7, 8.3, ("7.0", "7.2", "7.4", "7.6", "7.8", "8.0", "8.2")),
    ],
)
def test_ticks_are_round(low, high, expected, monkeypatch):
    written = []
    monkeypatch.setattr(Canvas, "text", lambda self, text, *where, **how: written.append(text))
    plot(x_axis=Axis("", low, high), y_axis=Axis("", 0, 30))
    assert tuple(written[: len(expected)]) == expected


def test_a_long_title_stays_in_the_picture():
    title = "W" * 120
    image = draw_plot([], Axis(""), Axis(""), title=title)
    margin = image[-80:, -4:, :3]
    np.testing.assert_array_equal(margin, 1)


@pytest.mark.parametrize(
    ("options", "remedy"),
    [
        ({"width": 200, "height": 960}, "wider"),
        ({"x_axis": Axis("", 1, 1)}, "rise"),
        ({"y_axis": Axis("", 0, float("nan"))}, "rise"),
    ],
)
def test_no_room(options, remedy):
    with pytest.raises(ValueError, match=remedy):
        plot(**options)


def test_colours_differ_in_lightness_or_hue():
    """Told apart in greyscale from paper, and from each other in some channel."""
    colours = np.array(
        [[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in (BLACK, BLUE, VERMILION, GREEN, ORANGE, SKY_BLUE, PURPLE)]
    )
    luma = colours @ (0.2126, 0.7152, 0.0722)
    assert luma.max() < 0.75 * 255
    distances = np.abs(colours[:, None] - colours[None]).max(axis=-1)[~np.eye(len(colours), dtype=bool)]
    assert distances.min() > 60


def test_plot_of_bounce_curves():
    """Each shown bounce is there in its colour; a bin that stands alone too; and the fit's numbers are written."""
    ao = (np.arange(20) + 0.5) / 20
    mean = np.array([0.9 * ao * 0.8**n for n in range(21)])
    count = np.full(20, 9)
    count[[3, 5]] = 0
    mean[:, [3, 5]] = np.nan
    image = draw_curves(BounceCurves(ao, count, mean), BounceFit(a=12.5, b=2.5, f0_rms=0.01, f1_rms=0.02), "Wall")
    assert image.shape == (960, 1280, 4)
    for colour in SHOWN.values():
        paint = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
        found = np.nonzero((np.abs(image[:, :900, :3] - paint) < 0.01).all(axis=-1))[1]
        assert len(found) > 500
    assert GREY not in SHOWN.values()
    few = draw_curves(BounceCurves(ao, count, mean[:3]), BounceFit(), "Wall")
    orange = np.array((0xE6, 0x9F, 0)) / 255
    assert not (np.abs(few[..., :3] - orange) < 0.01).all(axis=-1).any()  # bounce 3 was not simulated
