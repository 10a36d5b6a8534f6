# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel tells before a bake: as many points and rays as the bake then has, and what to know first."""

import time

import bpy
import numpy as np
import pytest

from .bakes import bake, change_settings, operators, reports
from .meshes import add_uv_map, box, plate, positions


def forecast(*objects):
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    return operators("forecast").forecast(list(objects), settings)


def look_at_layouts():
    """What Blender's timer does in the window."""
    checks = operators("uv_checks")
    until = time.monotonic() + 20.0
    while checks._go_on() is not None:
        assert time.monotonic() < until
        time.sleep(0.01)


@pytest.fixture(autouse=True)
def no_rates(monkeypatch):
    """What this machine learnt from other bakes is not to be seen here."""
    rates = {}
    monkeypatch.setattr(operators("forecast"), "_rates", lambda: rates)
    return rates


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
def test_points_and_rays_are_those_of_the_bake(bounces):
    objects = plate("Smooth"), box("Flat", location=(5, 0, 0))
    change_settings(samples=16, bounces=bounces)
    told, done = forecast(*objects), reports(*objects, samples=16)
    assert (told.objects, told.points, told.rays) == (2, 25 + 24, 16 * 49)
    assert told.points == sum(report.points for report in done)
    assert told.rays == sum(report.rays for report in done)
    assert told.text() == "2 objects, 49 points, 784 rays"


def test_few_vertices_are_told_of_in_one_line():
    dense, floor, boxes = plate("Dense"), plate("Floor", steps=1), [box("Box"), box("Box 2")]
    assert forecast(dense).warnings == []
    lost = "few vertices, and shadows between them are lost: subdivide, or set Target to Texture"
    assert forecast(floor).warnings == [f"'Floor' has {lost}"]
    assert forecast(floor, dense, *boxes).warnings == [f"'Floor' and 2 more have {lost}"]
    change_settings(target="TEXTURE")
    assert not any(lost in warning for warning in forecast(floor).warnings)


def test_texels_are_known_when_the_layout_was_looked_at():
    obj = plate()
    add_uv_map(obj.data, (positions(obj)[:, :2] + 1) / 4, "Quarter")
    change_settings(target="TEXTURE", resolution=64, samples=1, margin=0, uv_map="Quarter")
    (done,) = reports(obj, samples=1)
    assert forecast(obj).points == 64 * 64  # not yet
    look_at_layouts()
    assert forecast(obj).points == 32 * 32
    assert done.points == pytest.approx(32 * 32, rel=0.1)  # and those that the edge touches
    # A mesh that changes is looked at again.
    add_uv_map(obj.data, (positions(obj)[:, :2] + 1) / 2, "Whole")
    obj.data.uv_layers["Quarter"].uv.foreach_set("vector", [0.0] * 2 * len(obj.data.loops))
    obj.data.update()
    bpy.context.view_layer.update()
    assert forecast(obj).points == 64 * 64
    look_at_layouts()
    assert forecast(obj).points == 0


def test_warnings_come_before_the_bake():
    bare, folded, hidden, shared = box("Bare"), plate("Folded"), plate("Hidden"), plate("Shared")
    add_uv_map(folded.data, abs(positions(folded)[:, :2]), "Folded").active_render = True
    shared.data = hidden.data
    hidden.hide_render = True
    change_settings(target="TEXTURE", resolution=64)
    forecast(bare, folded, hidden)
    look_at_layouts()
    assert forecast(bare, folded, hidden).warnings == [
        "'Bare' has no UV map: unwrap it first",
        "'Folded' overlaps itself in UV map 'Folded'",
        "'Hidden' is disabled in renders: it blocks no light on others",
    ]
    change_settings(uv_map="Other")
    assert forecast(hidden).warnings[0] == "'Hidden' has no UV map 'Other'"
    change_settings(target="VERTEX", occluders="SELF")
    assert forecast(hidden, shared).warnings == ["'Shared' shares its mesh with another: one bake serves both"]
    assert forecast(hidden, shared).points == 25


def test_time_by_the_rate_of_earlier_bakes(no_rates):
    obj = plate()
    change_settings(samples=1000, bounces="FITTED")
    report = operators("report").ObjectReport("Plate", "VERTEX", points=10**6, samples=100, rays=10**8, seconds=20.0)
    operators("forecast").remember([report], "FITTED")
    assert no_rates == {"FITTED": 5e6}
    assert forecast(obj).seconds == pytest.approx(25 * 1000 / 5e6)
    assert forecast(obj).text().endswith("25,000 rays, under 1 s")
    change_settings(samples=2**16)
    no_rates["FITTED"] = 1e6
    assert forecast(obj).text().endswith("1.6 M rays, about 2 s")
    change_settings(bounces="BAKED")
    assert forecast(obj).seconds is None


def test_a_bake_too_short_to_measure_teaches_nothing(no_rates):
    bake(plate(), samples=4)
    assert no_rates == {}


def test_selected_to_active_counts_what_is_baked_to():
    low, high = plate("Rock_low"), box("Rock_high", location=(5, 0, 0))
    high.hide_render = True  # as those often are
    change_settings(use_selected_to_active=True, samples=16)
    told = forecast(low, high)
    assert (told.text(), told.warnings) == ("1 object, 25 points, 400 rays", [])
    assert forecast(low).objects == 0
    assert forecast(low).warnings == [
        "Selected to Active needs what to bake onto the active object 'Rock_low': select it too"
    ]
    change_settings(use_match_names=True)
    told = forecast(high, low)
    assert (told.objects, told.points, told.warnings) == (1, 25, [])


def test_texels_of_all_tiles_count():
    obj = plate()
    add_uv_map(obj.data, (positions(obj)[:, :2] + 1) * (1.5, 0.5), "Wide")
    change_settings(target="TEXTURE", resolution=64, samples=1, uv_map="Wide")
    forecast(obj)
    look_at_layouts()
    assert forecast(obj).points == 64 * 64
    change_settings(use_udim=True)
    forecast(obj)
    look_at_layouts()
    assert forecast(obj).points == 3 * 64 * 64
    assert forecast(obj).warnings == []


def test_overlap_in_any_tile():
    """A map that folds back in the second tile: without tiles nothing is baked there, with them it is."""
    obj = plate()
    x, y = (positions(obj)[:, :2].T + 1) / 2
    add_uv_map(obj.data, np.column_stack((1.5 - abs(x - 0.5), y)), "Folded")
    change_settings(target="TEXTURE", resolution=16, samples=1, uv_map="Folded")
    for use_udim, told in ((False, []), (True, ["'Plate' overlaps itself in UV map 'Folded'"])):
        change_settings(use_udim=use_udim)
        forecast(obj)
        look_at_layouts()
        assert forecast(obj).warnings == told
    (done,) = reports(obj, samples=1)
    assert any("overlaps itself" in warning for warning in done.warnings)
