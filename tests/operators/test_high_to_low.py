# SPDX-License-Identifier: GPL-3.0-or-later
"""Selected to Active: what a high mesh sees, on a low one."""

import bpy
import numpy as np
import pytest

from .bakes import bake, change_settings, f0, pixels, reports, rms, select
from .meshes import add_mesh, box, plate, positions
from .refusals import error_of

STEPS = 64


def image_f0(obj):
    return pixels(bpy.data.images[f"{obj.name} Multibounce AO"])[..., 0].astype(float)


def hills(name="High", **where):
    """A displaced plate, 64 x 64 quads."""
    obj = plate(name, steps=STEPS, **where)
    x, y, _ = positions(obj).T
    z = 0.12 * np.sin(7 * x) * np.cos(5 * y)
    obj.data.vertices.foreach_set("co", np.column_stack((x, y, z)).astype(np.float32).ravel())
    obj.data.update()
    return obj


def onto(low, *high, **settings):
    """Bake ``high`` onto ``low``; its report."""
    change_settings(use_selected_to_active=True)
    (report,) = reports(low, *high, **{"use_material_nodes": False, **settings})
    return report


@pytest.mark.usefixtures("fitted")
def test_a_displaced_plane_onto_a_flat_one():
    """Each vertex of the high mesh in the centre of a texel. The low plate blocks nothing."""
    high = hills()
    bake(high, samples=1024)
    truth = f0(high).reshape(STEPS + 1, STEPS + 1)
    low = plate("Low", half=(STEPS + 1) / STEPS, steps=1)
    report = onto(low, high, target="TEXTURE", samples=256, resolution=STEPS + 1, margin=0, cage_extrusion=0.2)
    assert (report.name, report.error) == ("Low", None)
    difference = image_f0(low)[1:-1, 1:-1] - truth[1:-1, 1:-1]
    print(f"rms {rms(difference):.4f} of {np.std(truth):.3f}, most {np.abs(difference).max():.3f}")
    assert np.std(truth) > 0.05
    assert rms(difference) < 0.02
    # To vertices, the same.
    bpy.data.objects.remove(low)
    low = hills("Low")
    low.data.vertices.foreach_set("co", (positions(low) * (1, 1, 0)).astype(np.float32).ravel())
    onto(low, high, target="VERTEX", samples=1024, cage_extrusion=0.2)
    inner = np.abs(positions(low)[:, :2]).max(axis=1) < 0.99
    assert rms((f0(low) - f0(high))[inner]) < 0.01


@pytest.mark.usefixtures("fitted")
def test_extrusion_and_ray_distance():
    """Boards above and below the low plate, a quarter of it each. A board sees all; what no ray meets has no value of
    its own."""
    low = plate("Low", half=2.0, steps=1)
    upper = plate("Upper", steps=1, location=(-1, -1, 0.5))
    lower = plate("Lower", steps=1, location=(1, 1, -0.5))
    settings = {"target": "TEXTURE", "resolution": 16, "margin": 0, "samples": 16}

    def met(**chosen):
        report = onto(low, upper, lower, **(settings | {"cage_extrusion": 0.0, "max_ray_distance": 0.0} | chosen))
        return report.error or report.warnings

    def share(told):
        return int(told[0].split()[0]) / 256

    assert share(met()) == 0.75  # inwards only
    assert share(met(cage_extrusion=0.6)) == 0.5
    assert share(met(cage_extrusion=0.6, max_ray_distance=0.2)) == 0.75  # the upper one alone
    assert "Cage Extrusion" in met(cage_extrusion=0.4, max_ray_distance=0.2)  # none


@pytest.mark.usefixtures("fitted")
def test_cage_object():
    """Rays go from the cage to the low plate: a cage moved aside slants them. The high plate lies half way, so that
    what they meet is half a unit aside; there it has a dark half, under a box whose inner side it lies in."""
    low, cage = plate("Low", steps=1), plate("Cage", steps=1, location=(1, 0, 2))
    high = plate("High", half=4.0, steps=32, location=(0, 0, 1))
    box("Box", low=(0, -5, 0.9), high=(5, 5, 1.1), inward=True)
    cage.hide_render = True
    settings = {"target": "TEXTURE", "resolution": 16, "margin": 0, "samples": 16, "ignore_backfaces": True}
    onto(low, high, cage_object=cage, **settings)
    np.testing.assert_array_equal(image_f0(low) == 0, np.tile(np.arange(16) >= 4, (16, 1)))
    onto(low, high, cage_object=None, cage_extrusion=2.0, **settings)
    np.testing.assert_array_equal(image_f0(low) == 0, np.tile(np.arange(16) >= 8, (16, 1)))
    wrong = plate("Wrong", steps=2)
    assert "'Wrong'" in onto(low, high, cage_object=wrong, **settings).error


@pytest.mark.usefixtures("fitted")
def test_four_pairs_in_one_bake_do_not_darken_each_other():
    """All in one place. Alone, each plate sees all; together, and asked for, they darken each other."""
    lows = [plate(f"Part{i}_low", steps=1, location=(0, 0, 0.1 * i)) for i in range(4)]
    highs = [plate(f"part{i}_HIGH{s}", steps=2, location=(0, 0, 0.1 * i)) for i in range(4) for s in ("", "_bolts")]
    for obj in highs[1::2]:
        obj.location.x = 0.5
    change_settings(use_selected_to_active=True, use_match_names=True, cage_extrusion=0.01)
    made = {"target": "TEXTURE", "resolution": 8, "margin": 0, "samples": 64}
    told = reports(*highs, *lows, **made)
    assert [(report.name, report.error) for report in told] == [(low.name, None) for low in lows]
    for low in lows:
        assert image_f0(low).min() == 1.0
    change_settings(**made, occluders="SELECTED")
    select(*lows, *highs)
    bpy.ops.multibounce_ao.bake()
    assert max(image_f0(low)[:, 4].max() for low in lows[:3]) < 0.4
    change_settings(occluders="VISIBLE")
    box("Room", inward=True)  # what is in no pair blocks
    reports(*highs, *lows, **made)
    assert max(image_f0(low).max() for low in lows) == 0.0


def test_what_is_missing_is_told():
    low = plate("Low")
    change_settings(use_selected_to_active=True, target="TEXTURE", resolution=8)
    select(low)
    assert "'Low': select it too" in error_of(bpy.ops.multibounce_ao.bake)
    select(plate("High"))
    bpy.context.view_layer.objects.active = low
    assert "select it last" in error_of(bpy.ops.multibounce_ao.bake)
    select(low)
    change_settings(use_match_names=True)
    assert "'Name_low'" in error_of(bpy.ops.multibounce_ao.bake)
    low.name = "Low_low"
    assert "'Low_high'" in error_of(bpy.ops.multibounce_ao.bake)
    high = add_mesh("Low_high", [(0, 0, 0)], [])
    select(low, high)
    assert "has no faces" in error_of(bpy.ops.multibounce_ao.bake)
    assert not bpy.data.images
