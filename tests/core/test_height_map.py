# SPDX-License-Identifier: GPL-3.0-or-later
"""Height maps: grooves of known light, no edges where tiles meet, heights of any range."""

import numpy as np
import pytest

from core.height_map import MOST_PIXELS, HeightMap

from .endless_strips import EndlessStrips, rms
from .height_fields import height_field, waves


def test_grooves_of_a_height_map():
    """Grooves with flat flanks at 45 degrees: each flank sees the other of its groove, both see the sky."""
    width, grooves = 192, 6
    deep = 0.5 / grooves  # at 45 degrees as deep as half a groove is wide
    pixels = width // grooves
    ramp = np.abs(np.arange(pixels) - pixels // 2)
    seen = height_field(np.tile(ramp, (64, grooves)), deep, samples=256)
    truth = EndlessStrips([((0, 1), (1, 0)), ((1, 0), (2, 1))])
    # Pixels of a flank by their distance from the top, without the edges, whose normals are of neither flank.
    pixel = np.arange(2, pixels // 2 - 1)
    expected = np.stack(
        [np.interp(pixel / (pixels // 2), truth.middle[0, :, 0], each) for each in truth.bounces(4)[:, 0]]
    )
    image = seen.bounces.reshape(-1, 64, grooves, pixels)[:5]
    errors = [rms(image[order][:, :, pixel] - expected[order]) for order in range(5)]
    print("grooves: rms of F0 to F4", *(f"{each:.4f}" for each in errors))
    assert max(errors) < 0.01


def test_a_height_map_has_no_edges():
    """Rolled by any number of pixels the map is the same: what it sees rolls along."""
    heights = waves(32)
    seen, rolled = height_field(heights, 0.15, 1024), height_field(np.roll(heights, (5, 11), (0, 1)), 0.15, 1024)
    for order in range(3):
        difference = np.roll(seen.bounces[order].reshape(32, 32), (5, 11), (0, 1)).ravel() - rolled.bounces[order]
        print(f"rolled: F{order} rms {rms(difference):.5f}")
        assert rms(difference) < 0.004


def test_heights_in_any_range():
    seen = height_field(waves(16), 0.2, 32)
    for heights in (7.0 * waves(16) - 300.0, 1e300 * waves(16)):
        assert np.abs(height_field(heights, 0.2, 32).bounces[0] - seen.bounces[0]).mean() < 1e-3
    flat = height_field(np.full((2, 3), 5.0), 0.1, 32)
    assert (flat.bounces[0] == 1.0).all() and (flat.bounces[1:] == 0.0).all()


def test_hits_on_other_tiles_wrap():
    height_map = HeightMap(np.arange(12).reshape(3, 4), 0.1)
    centres = height_map.points().positions
    assert (height_map.pixels_at(centres) == np.arange(12)).all()
    for tile in ((-1, 0, 0), (1, 0, 0), (0, -0.75, 0), (1, 0.75, 0)):
        assert (height_map.pixels_at(centres + tile) == np.arange(12)).all()


@pytest.mark.parametrize(
    ("heights", "amplitude", "message"),
    [
        (np.zeros(9), 0.1, "2 x 2"),
        (np.zeros((4, 4, 3)), 0.1, "one channel"),
        (np.zeros((1, 9)), 0.1, "2 x 2"),
        (np.full((4, 4), np.nan), 0.1, "finite"),
        (np.zeros((4, 4)), -0.1, "amplitude"),
        (np.zeros((4, 4)), np.inf, "amplitude"),
        (np.zeros((2, MOST_PIXELS)), 0.1, "scale it down"),
    ],
)
def test_bad_height_maps(heights, amplitude, message):
    with pytest.raises(ValueError, match=message):
        HeightMap(heights, amplitude)
