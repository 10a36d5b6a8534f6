# SPDX-License-Identifier: GPL-3.0-or-later
"""What is told of progress: how long it will still take, how fast the rays are, and a bar that keeps its pace."""

from dataclasses import replace

import bpy
import pytest

from .bakes import generator, operators
from .meshes import box, plate


@pytest.fixture
def progress():
    return operators("progress")


def pace_after(progress, steps):
    """The pace when steps (seconds, fraction, rays) have been."""
    times = iter([0.0, *(time for time, _, _ in steps)])
    pace = progress.Pace(now=lambda: next(times))
    for _, fraction, rays in steps:
        pace(progress.Progress(fraction, "Suzanne", rays))
    return pace


def test_time_left_and_rays_a_second(progress):
    # Reading takes 7 s. From then on 4 % a second.
    pace = pace_after(progress, [(7, 0, 0), (8, 0.04, 0), (9, 0.08, 0), (10, 0.12, 1000), (12, 0.2, 5000)])
    assert pace.left == pytest.approx(0.8 / 0.04)
    assert pace.rate == pytest.approx(5000 / 2)
    assert pace.text() == "2,500 rays/s, 20 s left"


def test_nothing_is_said_too_early(progress):
    assert pace_after(progress, [(0, 0, 0), (9, 0, 0)]).text() == ""
    assert pace_after(progress, [(1, 0, 0), (3, 0.01, 0)]).left is None  # hardly begun
    assert pace_after(progress, [(1, 0, 0), (1.1, 0.5, 0)]).left is None  # no time to measure
    assert pace_after(progress, [(1, 0, 0), (5, 0.01, 0)]).left == pytest.approx(4 * 99)  # it is going to be long
    assert pace_after(progress, [(1, 0, 0), (9, progress.STARTED, 0)]).left is None


def test_time_counts_from_the_start_of_the_work_itself(progress):
    """Three seconds of getting ready belong to it, as they come again for every part of it."""
    pace = pace_after(progress, [(7, 0, 0), (7, progress.STARTED, 0), (10, progress.STARTED, 0), (11, 0.1, 0)])
    assert pace.left == pytest.approx(9 * 4)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0 s"), (4.2, "4 s"), (59.6, "1 min 0 s"), (130, "2 min 10 s"), (3599, "59 min 59 s"), (3905, "1 h 5 min")],
)
def test_times_as_people_say_them(progress, seconds, text):
    assert progress.duration_text(seconds) == text


def test_objects_count_by_their_size(fitted):
    """One quad and a plate of 1024: the bar is not half full after the quad. Shared meshes are baked once."""
    small, large, empty = plate("Small", steps=1), plate("Large", steps=32), box("Lamp")
    shared = plate("Shared")
    shared.data = large.data
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    ends = operators("bake_job")._ends([small, large, shared, empty], [settings] * 4)
    whole = 4 + 4 * 32**2 + 24
    assert ends == pytest.approx([4 / whole, (whole - 24) / whole, (whole - 24) / whole, 1.0])
    textures = replace(settings, target="TEXTURE")
    assert operators("bake_job")._ends([small, large], [textures] * 2) == pytest.approx([0.5, 1.0])
    finer = replace(textures, resolution=2 * textures.resolution)
    assert operators("bake_job")._ends([small, large], [textures, finer]) == pytest.approx([0.2, 1.0])


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
def test_rays_are_counted(bounces):
    steps = list(generator(plate(), bounces=bounces, samples=8))
    assert steps[0].rays == 0
    assert steps[-1].rays == 25 * 8
    assert steps[-1].ready and not any(step.ready for step in steps[:-1])
