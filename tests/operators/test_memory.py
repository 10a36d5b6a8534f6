# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake says of the memory it needs, and that it is refused where there is less."""

import re
import tracemalloc

import bpy
import numpy as np
import pytest

from core.memory import _linux, free_memory

from .bakes import bake, change_settings, operators, reports, select
from .meshes import plate
from .refusals import assert_one_sentence
from .snapshot import differences, snapshot

MADE = {"target": "TEXTURE", "samples": 4, "margin": 0, "use_material_nodes": False}


def test_a_bake_that_cannot_fit_is_refused_with_the_numbers(monkeypatch):
    obj = plate("Bad")
    memory = operators("texture_memory")
    monkeypatch.setattr(memory, "free_memory", lambda: 4_000_000_000)
    change_settings(**MADE, resolution=16384)
    select(obj)
    before = snapshot()
    (report,) = reports(obj, **MADE, resolution=16384)
    assert_one_sentence(report.error)
    needed, free = (float(number) for number in re.findall(r"([\d.]+) GB", report.error))
    assert free == 4.0
    # Two images of four floats, and one more twice over while it is stored.
    assert 16384**2 * 64 / 1e9 <= needed < 1.1 * 16384**2 * 64 / 1e9
    assert differences(before, snapshot()) == []
    # A bent normal map is one more; as OpenEXR it is copied before it is stored.
    for map_format, texel in (("PNG_8", 80), ("OPEN_EXR", 96)):
        (report,) = reports(obj, **MADE, resolution=16384, use_bent_normal_map=True, map_format=map_format)
        assert f"about {16384**2 * texel / 1e9:.1f} GB" in report.error
    change_settings(use_bent_normal_map=False)
    monkeypatch.setattr(memory, "free_memory", lambda: None)  # a system that does not tell
    assert reports(obj, **MADE, resolution=8)[0].error is None


@pytest.mark.parametrize("map_format", ["PNG_8", "PNG_16", "OPEN_EXR"])
def test_what_the_coloured_map_takes(map_format, tmp_path):
    maps, memory, names = operators("derived_maps"), operators("texture_memory"), operators("names")
    change_settings(map_format=map_format, use_colored_ao_map=True)
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    side = 1024
    channels = {names.MULTIBOUNCE_AO: np.full((side, side, 4), 0.3, np.float32)}
    albedo = np.full((side, side, 3), 0.5, np.float32)
    tracemalloc.start()
    pixels = maps.derive(names.COLORED_AO_MAP, channels, albedo)
    maps.write_map(tmp_path / "map", names.COLORED_AO_MAP, pixels, settings, {})
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    print(f"{map_format}: {peak / side**2:.1f} bytes a texel")
    assert peak <= memory.COLOURED * side**2


def test_what_is_much_is_said_at_the_start(monkeypatch, capsys):
    obj = plate()
    monkeypatch.setattr(operators("report"), "MUCH_MEMORY", 1e8)
    bake(obj, **MADE, resolution=8)
    lines = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"Multibounce AO:   0 %  Plate, needs about 0\.6 GB of memory", lines[1])
    assert len([line for line in lines if "  0 %" in line]) == 2


def test_free_memory(tmp_path):
    free = free_memory()
    assert free is None or 1e7 < free < 1e14
    (tmp_path / "proc").mkdir()
    assert _linux(tmp_path) is None
    (tmp_path / "proc" / "meminfo").write_text("MemTotal: 9 kB\nMemAvailable: 5000 kB\nSwapFree: 1000 kB\n")
    assert _linux(tmp_path) == 6000 * 1024
    group = tmp_path / "sys" / "fs" / "cgroup"
    group.mkdir(parents=True)
    (group / "memory.current").write_text("1000\n")
    (group / "memory.max").write_text("max\n")
    assert _linux(tmp_path) == 6000 * 1024
    (group / "memory.max").write_text("5000\n")
    assert _linux(tmp_path) == 4000
