# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps that bakes of two .blend files write into one folder."""

import json
import shutil

import bpy
import pytest

from core.exr import read_metadata

from .commands import reported
from .meshes import plate

SETTINGS = ["--set", "target=TEXTURE", "--set", "resolution=8", "--set", "samples=4", "--set", "bounces=FITTED"]
SETTINGS += ["--set", "output_directory=//maps", "--save"]


@pytest.fixture
def blend(scene, tmp_path):
    plate("Floor")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    return tmp_path / "shot.blend"


def baked(blend, *arguments):
    """The entry of the floor."""
    (entry,) = reported(blend, *SETTINGS, *arguments)["objects"]
    return entry


def test_a_map_of_another_blend(blend):
    other = blend.with_name("other.blend")
    shutil.copy(blend, other)
    replaced = "Replaced the map of 'Floor' in 'shot.blend': give one of them another output folder"
    assert baked(blend)["warnings"] == []
    told = json.loads(read_metadata(blend.parent / "maps" / "Floor_multibounce_ao.exr")["multibounce_ao"])
    assert (told["blend"], told["object"]) == ("shot.blend", "Floor")
    assert baked(blend, "--resume")["rays"] == 0
    assert baked(other)["warnings"] == [replaced]
    assert baked(other)["warnings"] == []  # it is its own by now
    again = baked(blend, "--resume")
    assert again["rays"] and again["warnings"] == [replaced.replace("shot", "other")]


def test_a_blend_that_was_saved_under_another_name(blend):
    """It shows the maps of its earlier version, which are those that it would bake."""
    baked(blend)
    later = blend.with_name("shot_v002.blend")
    shutil.copy(blend, later)
    assert baked(later, "--resume")["rays"] == 0
    assert len(baked(later)["warnings"]) == 1
    assert baked(blend, "--resume")["rays"]


def test_a_map_that_cannot_be_read(blend):
    for content in (b"no picture", b""):
        (blend.parent / "maps").mkdir(exist_ok=True)
        (blend.parent / "maps" / "Floor_multibounce_ao.exr").write_bytes(content)
        assert baked(blend)["warnings"] == []
