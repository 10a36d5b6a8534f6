# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene for rays is built once, and again when anything in it has changed."""

import bpy
import numpy as np
import pytest

from .bakes import bake, f0, operators
from .meshes import box, plate, suzanne


@pytest.fixture
def builds(monkeypatch):
    """A list that grows by one for each scene that is built."""
    cache, made = operators("occluder_cache"), []
    cache.forget()
    build = cache.Occluders
    monkeypatch.setattr(cache, "Occluders", lambda *args: made.append(args) or build(*args))
    return made


def test_a_second_bake_builds_nothing_and_gives_the_same_bits(builds):
    obj = suzanne()
    bake(obj)
    first = f0(obj)
    bake(obj)
    assert len(builds) == 1
    assert f0(obj).tobytes() == first.tobytes()
    bake(obj, target="TEXTURE", resolution=16, samples=4, max_distance=1.0)
    assert len(builds) == 1, "what is asked of the rays does not change what they meet"


@pytest.mark.parametrize(
    "change",
    [
        lambda floor, ceiling: ceiling.data.vertices[0].co.__setitem__(2, 0.7),
        lambda floor, ceiling: setattr(ceiling, "location", (0, 0, 3)),
        lambda floor, ceiling: setattr(ceiling, "hide_render", True),
        lambda floor, ceiling: setattr(bpy.context.scene.multibounce_ao, "use_ground_plane", True),
        lambda floor, ceiling: ceiling.modifiers.new("Solidify", "SOLIDIFY"),
    ],
    ids=["vertex", "moved", "hidden", "ground plane", "modifier"],
)
def test_what_changes_is_built_anew(builds, change):
    floor, ceiling = plate("Floor"), plate("Ceiling", location=(0, 0, 1))
    bake(floor)
    change(floor, ceiling)
    bake(floor)
    assert len(builds) == 2
    kept = f0(floor)
    operators("occluder_cache").forget()
    bake(floor)
    assert len(builds) == 3
    assert np.array_equal(f0(floor), kept)


def test_opening_a_file_frees_the_scene(builds):
    bake(box())
    assert operators("occluder_cache")._kept is not None
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert operators("occluder_cache")._kept is None
