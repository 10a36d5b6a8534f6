# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake that is closed half-way leaves everything as it was, and no thread behind."""

import itertools
import threading

import bpy
import pytest

from .bakes import generator
from .materials import textured_material
from .meshes import plate
from .snapshot import differences, snapshot
from .threads import assert_others_end


def begin(target, folder):
    one, two = plate(), plate("Floor", location=(0, 0, -2))
    one.data.materials.append(textured_material())
    # At 16384 samples a block is 8 points, so that each object has several.
    work = generator(one, two, target=target, samples=16384, resolution=6, output_directory=str(folder))
    return work, snapshot()


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_closing_at_every_step(target, tmp_path):
    work, before = begin(target, tmp_path)
    fractions = [step.fraction for step in work]
    steps = len(fractions)
    assert steps > 5
    assert fractions == sorted(fractions)
    assert fractions[0] == 0
    assert 0.9 < fractions[-1] <= 1

    threads = set(threading.enumerate())
    for last in (*range(0, steps, max(1, steps // 6)), steps):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        for file in tmp_path.iterdir():
            file.unlink()
        work, before = begin(target, tmp_path)
        if len(list(itertools.islice(work, last))) < last:
            continue  # done sooner this time: how often a bake reports is a matter of time
        work.close()
        assert differences(before, snapshot()) == [], f"closed after step {last} of {steps}"
        assert list(tmp_path.iterdir()) == []
        assert_others_end(threads)


def test_a_bake_that_was_dropped_unfinished_leaves_no_thread():
    threads = set(threading.enumerate())
    work, _ = begin("VERTEX", "")
    next(work), next(work)
    del work
    assert_others_end(threads)
