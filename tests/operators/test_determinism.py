# SPDX-License-Identifier: GPL-3.0-or-later
"""The same seed and settings give the same bits, whatever the number of threads."""

import bpy
import numpy as np
import pytest

from .bakes import BENT_CONE, MULTIBOUNCE_AO, bake, pixels, reports
from .meshes import suzanne


def bits(obj, target):
    if target == "TEXTURE":
        arrays = [pixels(bpy.data.images[f"{obj.name} {name}"]).ravel() for name in (MULTIBOUNCE_AO, BENT_CONE)]
    else:
        arrays = []
        for name in (MULTIBOUNCE_AO, BENT_CONE):
            data = obj.data.attributes[name].data
            arrays.append(np.empty(len(data) * 4, np.float32))
            data.foreach_get("color", arrays[-1])
    return np.concatenate(arrays).view(np.uint32)


# 2,012 vertices and some 3,000 texels at 512 samples: 8 to 12 blocks of 131,072 rays for the threads to share.
@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_threads_and_seeds(target):
    obj = suzanne(levels=1)
    options = {"target": target, "samples": 512, "resolution": 64}
    bake(obj, **options)
    first = bits(obj, target)
    for threads in (1, 2, 7):
        reports(obj, threads=threads, **options)
        np.testing.assert_array_equal(bits(obj, target), first)
    bake(obj, seed=1, **options)
    assert (bits(obj, target) != first).mean() > 0.2
    bake(obj, seed=0, **options)
    np.testing.assert_array_equal(bits(obj, target), first)


def test_other_objects_in_the_bake_change_no_bit():
    obj, other = suzanne(), suzanne("Other", location=(100, 0, 0))
    bake(obj, occluders="SELF")
    alone = bits(obj, "VERTEX")
    bake(other, obj, occluders="SELF")
    np.testing.assert_array_equal(bits(obj, "VERTEX"), alone)


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_obscurance_that_reaches_past_the_scene_is_ambient_occlusion(target):
    obj = suzanne(levels=1)
    options = {"target": target, "samples": 128, "resolution": 32}
    bake(obj, **options)
    plain = bits(obj, target)
    bake(obj, max_distance=10.0, **options)  # Suzanne is 2.7 m wide
    np.testing.assert_array_equal(bits(obj, target), plain)
    bake(obj, max_distance=0.1, **options)
    assert (bits(obj, target) != plain).any()
