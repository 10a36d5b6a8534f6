# SPDX-License-Identifier: GPL-3.0-or-later
"""What may happen in a night: the process is killed, the disk is full, two bakes save the same file."""

import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import bpy
import numpy as np
import pytest
from enable_extension import PACKAGE

from .bakes import attribute, operators
from .commands import run
from .meshes import box, plate

# More of them by hand: KILLS=10 make test ARGS=tests/operators/test_command_night.py
KILLS = int(os.environ.get("KILLS", "2"))
OBJECTS = 12
SETTINGS = ["--set", "samples=64", "--set", "bounces=FITTED"]

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no kill -9 and no limit of file sizes")


@pytest.fixture
def blend(scene, tmp_path):
    for index in range(OBJECTS):
        plate(f"Floor {index}", steps=24, location=(3 * index, 0, 0))
        box(f"Roof {index}", low=(-1, -1, 1), high=(1, 0, 2), location=(3 * index, 0, 0)).hide_render = index % 2 == 0
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def results(blend):
    """The attributes of all objects that are baked in the file."""
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    return {obj.name: attribute(obj) for obj in bpy.data.objects if "multibounce_ao" in obj}


def process(blend, *arguments):
    """The command in a process of its own, as a program or by the bpy module."""
    arguments = ["bake", str(blend), *SETTINGS, *arguments]
    if bpy.app.binary_path:
        return subprocess.Popen([bpy.app.binary_path, "--command", "multibounce_ao", *arguments])
    code = (
        f"import sys; sys.path[:0] = [{str(Path(__file__).parents[1])!r}]; import enable_extension as e, importlib\n"
        f"e.enable_extension(); line = importlib.import_module({PACKAGE + '.operators.command_line'!r})\n"
        f"sys.exit(line.run({arguments!r}))"
    )
    return subprocess.Popen([sys.executable, "-c", code])


def test_killed_at_random_moments_and_resumed(blend):
    """The file can be opened whenever that happens, and in the end all is as if nothing had."""
    whole = blend.with_name("whole.blend")
    assert run("bake", blend, "--quiet", *SETTINGS, "--save", whole) == 0
    expected, moments, done = results(whole), random.Random(8), []
    started = blend.stat().st_mtime_ns
    for _ in range(KILLS):
        bake = process(blend, "--save", "--resume", "--checkpoint", "1e-6")
        until = time.monotonic() + 60.0
        while blend.stat().st_mtime_ns == started and bake.poll() is None:  # until it has saved for the first time
            assert time.monotonic() < until
            time.sleep(0.002)
        time.sleep(moments.uniform(0.0, 0.05))
        bake.kill()
        bake.wait()
        started = blend.stat().st_mtime_ns
        found = results(blend)
        assert all(np.array_equal(found[name], expected[name]) for name in found)
        done.append(len(found))
    assert done[0] > 0 and done == sorted(done)
    report = blend.with_name("report.json")
    assert run("bake", blend, "--quiet", *SETTINGS, "--save", "--resume", "--report", report) == 0
    found = results(blend)
    assert found.keys() == expected.keys()
    assert all(np.array_equal(found[name], expected[name]) for name in expected)
    traced = [entry for entry in json.loads(report.read_text())["objects"] if entry["rays"]]
    assert len(traced) == len(expected) - done[-1]
    print(f"killed {KILLS} times, with {done} of {len(expected)} objects baked, then as many as without")


def test_a_full_disk(blend, run_in_fresh_blender):
    """A limit to the size of files fails as a full disk does: in the middle of writing."""
    before, report = blend.read_bytes(), blend.with_name("report.json")
    run_in_fresh_blender(f"""
import importlib, resource
import enable_extension
enable_extension.enable_extension()
line = importlib.import_module(enable_extension.PACKAGE + ".operators.command_line")
resource.setrlimit(resource.RLIMIT_FSIZE, (2**15, resource.RLIM_INFINITY))
code = line.run(["bake", {str(blend)!r}, "--quiet", "--save", "--report", {str(report)!r}, *{SETTINGS!r}])
assert code == 1, code
""")
    assert blend.read_bytes() == before
    entries = json.loads(report.read_text())["objects"]
    assert len(entries) == OBJECTS + OBJECTS // 2
    assert all(entry["error"] is None and entry["f0"] for entry in entries)
    assert {path.name for path in blend.parent.iterdir()} == {blend.name, report.name}


def test_a_report_that_can_no_longer_be_written(blend, monkeypatch, capsys):
    files = operators("command_files")

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.json, "dumps", full)
    assert run("bake", blend, "--save", "--report", blend.with_name("report.json"), *SETTINGS) == 1
    error = capsys.readouterr().err
    assert "report.json' cannot be written: No space left on device" in error
    assert "18 baked, 0 failed" in error
    assert [path.name for path in blend.parent.iterdir()] == [blend.name]
    assert len(results(blend)) == OBJECTS + OBJECTS // 2


def test_another_program_saves_the_file_meanwhile(blend, monkeypatch, capsys):
    """Neither loses its work."""
    command, other = operators("command_bake"), b"the work of another"
    compute = command.bake
    monkeypatch.setattr(command, "bake", lambda *args, **rest: blend.write_bytes(other) and compute(*args, **rest))
    assert run("bake", blend, "--quiet", "--save", *SETTINGS) == 1
    beside = blend.with_name(f"scene_{os.getpid()}.blend")
    assert f"was saved by another program meanwhile: this is '{beside.name}'" in capsys.readouterr().err
    assert blend.read_bytes() == other
    assert len(results(beside)) == OBJECTS + OBJECTS // 2
