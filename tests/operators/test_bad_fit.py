# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits that are closed half-way or cannot be done: everything stays as it was, and the message says what to do."""

import re
import threading

import bpy
import numpy as np
import pytest

from .bakes import change_settings, operators, select
from .fits import fit_generator, relief, report_of, set_heights, trench
from .meshes import add, add_mesh, plate
from .refusals import assert_one_sentence, error_of
from .snapshot import differences, snapshot
from .threads import assert_others_end


def test_progress_rises():
    fractions = [step.fraction for step in fit_generator(trench())]
    assert fractions == sorted(fractions)
    assert fractions[0] == 0 and fractions[-1] == 1 and len(fractions) > 3


@pytest.mark.parametrize("until", [None, 0.0, 1e-6, 0.3, 0.6, 0.9, 1.0])
def test_closing_on_the_way(until, tmp_path):
    """Not begun, and at the first step that is so far: at 1 all is computed and nothing written."""
    obj = trench()
    threads = set(threading.enumerate())
    work = fit_generator(obj, output_directory=str(tmp_path))
    before = snapshot()
    if until is not None:
        next(step for step in work if step.fraction >= until)
    work.close()
    assert differences(before, snapshot()) == []
    assert list(tmp_path.iterdir()) == []
    assert_others_end(threads)


def no_area():
    return add_mesh("Bad", [(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)])


def no_faces():
    return add_mesh("Bad", [(0, 0, 0)], [])


def plane():
    return plate("Bad")


def hidden():
    obj = trench("Bad")
    obj.hide_viewport = True
    return obj


def lamp():
    return add("Bad", bpy.data.lights.new("Bad", "POINT"))


def image_in_the_way():
    bpy.data.images.new("Bad Bounce Curves", 4, 4).use_fake_user = True
    return trench("Bad")


def text_in_the_way():
    bpy.data.texts.new("Bad Bounce Curves").write("my notes")
    return trench("Bad")


def image_without_pixels():
    image = bpy.data.images.new("Bad", 4, 4)
    image.source, image.filepath = "FILE", "//missing.png"
    return image


def image_of_one_row():
    return bpy.data.images.new("Bad", 8, 1)


def flat_image():
    return bpy.data.images.new("Bad", 8, 8)


def image_with_nan():
    set_heights(image := bpy.data.images.new("Bad", 4, 4, float_buffer=True), np.full((4, 4), np.nan))
    return image


CASES = [
    (no_area, "no faces with an area"),
    (no_faces, "no faces with an area"),
    (plane, "choose one with more relief"),
    (hidden, "show it"),
    (lamp, "is not a mesh"),
    (image_in_the_way, "image 'Bad Bounce Curves'.*: rename"),
    (text_in_the_way, "text 'Bad Bounce Curves'.*: rename"),
    (image_without_pixels, "has no pixels: reload"),
    (image_of_one_row, "8 x 1 pixels: choose"),
    (flat_image, "choose one with more relief"),
    (image_with_nan, "not finite"),
]


@pytest.mark.parametrize(("make", "expected"), CASES, ids=lambda value: getattr(value, "__name__", ""))
def test_what_cannot_be_fitted(make, expected):
    source = make()
    change_settings(samples=16)
    before, texts = snapshot(), [text.as_string() for text in bpy.data.texts]
    with pytest.raises(operators("report").BakeError) as caught:
        report_of(source)
    message = str(caught.value)
    kind = "Image" if isinstance(source, bpy.types.Image) else "Object"
    assert message.startswith(f"{kind} 'Bad' ")
    assert_one_sentence("Object" + message.removeprefix(kind))
    assert re.search(expected, message)
    assert differences(before, snapshot()) == []
    assert [text.as_string() for text in bpy.data.texts] == texts


@pytest.mark.parametrize("active", [None, lamp])
def test_no_mesh_is_active(active):
    select(*([active()] if active else []))
    assert not bpy.ops.multibounce_ao.fit_bounces.poll()
    assert re.search("no mesh: make one active, or choose a height map", error_of(bpy.ops.multibounce_ao.fit_bounces))
    change_settings(height_map=relief(), height_map_amplitude=0.3)
    assert bpy.ops.multibounce_ao.fit_bounces.poll()


def test_output_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    select(trench())
    change_settings(output_directory=str(tmp_path / "file" / "below"))
    assert "choose another folder" in error_of(bpy.ops.multibounce_ao.fit_bounces)
    change_settings(output_directory="//relative")
    assert "not saved yet" in error_of(bpy.ops.multibounce_ao.fit_bounces)


def test_edit_mode():
    select(trench())
    bpy.ops.object.mode_set(mode="EDIT")
    assert "Object Mode" in error_of(bpy.ops.multibounce_ao.fit_bounces)
