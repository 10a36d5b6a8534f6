# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist may do while a bake goes on in the window: the rest is done, and the message says what happened."""

import bpy
import numpy as np
import pytest

from .bakes import RADIOSITY, attribute, f0, generator, operators, select
from .fits import fit_generator, trench
from .meshes import box, plate
from .props import field_generator
from .snapshot import differences, snapshot


@pytest.fixture
def scene_of_three(fitted):
    """The two that are baked and what hangs over one of them."""
    return plate("Bad"), plate("Good", location=(9, 0, 0)), box("Roof", low=(8, -1, 1), high=(10, 1, 2))


def finish(work):
    return operators("progress").drive(work, lambda step: None)


def until_ready(work):
    return next(step for step in work if step.ready)


def delete(obj):
    bpy.data.objects.remove(obj)


def edit(obj):
    select(obj)  # Blender takes all that is selected along
    assert bpy.ops.object.mode_set(mode="EDIT") == {"FINISHED"}


def subdivide(obj):
    edit(obj)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    bpy.ops.object.mode_set(mode="OBJECT")


def reverse(obj):
    """As many vertices and faces, and yet another mesh."""
    edit(obj)
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.flip_normals()
    bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
@pytest.mark.parametrize("when", ["at first", "when all is computed"])
def test_an_object_is_deleted(scene_of_three, target, when):
    bad, good, _ = scene_of_three
    work = generator(bad, good, target=target, resolution=8)
    next(work) if when == "at first" else until_ready(work)
    delete(bad)
    lost, done = finish(work)
    assert lost.error.startswith("Object 'Bad' was deleted while the bake was running: ")
    assert done.error is None
    assert good["multibounce_ao"]["points"] == done.points > 0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (edit, "is in Edit Mode: leave it, and bake again"),
        (subdivide, "was edited while it was baked: bake it again"),
        (reverse, "was edited while it was baked: bake it again"),
    ],
)
def test_an_object_is_edited(scene_of_three, change, says):
    bad, good, _ = scene_of_three
    work = generator(bad, good)
    until_ready(work)
    change(bad)
    refused, done = finish(work)
    assert refused.error == f"Object 'Bad' {says}"
    assert done.error is None
    if bad.mode == "EDIT":
        bpy.ops.object.mode_set(mode="OBJECT")
    assert "multibounce_ao" not in bad and "Multibounce AO" not in bad.data.attributes
    assert f0(good).min() < 0.9


def test_what_blocks_light_is_deleted(scene_of_three):
    bad, good, roof = scene_of_three
    expected = finish(generator(good))[0].f0
    work = generator(bad, good)
    next(step for step in work if step.name == "Good")
    delete(roof)
    assert [report.error for report in finish(work)] == [None, None]
    assert good["multibounce_ao"]["f0"].to_dict() == expected  # it was read when the bake began


@pytest.mark.parametrize("bounces", ["BAKED", "RADIOSITY"])
def test_what_reflects_light_is_deleted(scene_of_three, bounces):
    """Colours and triangles are of the same moment."""
    _, good, roof = scene_of_three
    reports = []
    for deleted in (False, True):
        work = generator(good, bounces=bounces, samples=16)
        next(work), next(work)
        if deleted:
            delete(roof)
        reports += finish(work)
    assert [report.error for report in reports] == [None, None]
    if bounces == "RADIOSITY":
        assert 0.0 < attribute(good, RADIOSITY)[:, :3].min() < attribute(good, RADIOSITY)[:, :3].max() <= 1.0


def test_a_mode_other_than_object_mode_that_can_be_stored_in(scene_of_three):
    bad, _, _ = scene_of_three
    expected = finish(generator(bad)) and f0(bad)
    work = generator(bad, seed=0)
    until_ready(work)
    bpy.context.view_layer.objects.active = bad
    bpy.ops.object.mode_set(mode="VERTEX_PAINT")
    assert finish(work)[0].error is None
    np.testing.assert_array_equal(f0(bad), expected)


@pytest.mark.parametrize("begin", [field_generator, fit_generator])
def test_the_source_of_a_field_or_a_fit_is_deleted(begin):
    obj = trench()
    obj.name = "Bad"
    work = begin(obj)
    until_ready(work)
    delete(obj)
    before = snapshot()
    with pytest.raises(operators("report").BakeError, match=r"^Object 'Bad' was deleted while .* undo"):
        finish(work)
    assert differences(before, snapshot()) == []
