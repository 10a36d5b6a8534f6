# SPDX-License-Identifier: GPL-3.0-or-later
"""`blender --command multibounce_ao bake A.blend B.blend --jobs N`: the bits of one by one, one report, one table; and
what becomes of children that fail, crash, or are interrupted."""

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from enable_extension import PACKAGE

from .bakes import attribute, operators
from .commands import run
from .meshes import add_mesh, box, plate

TESTS = Path(__file__).resolve().parents[1]
# What stands for Blender's program where there is only its module.
MODULE = f"""
import importlib, sys
sys.path[:0] = [{str(TESTS)!r}]
import enable_extension
enable_extension.enable_extension()
sys.exit(importlib.import_module({PACKAGE + ".operators.command_line"!r}).run(sys.argv[1:]))
"""
# Does what the name of its file says, and notes when, with how many threads.
FAKE = """
import json, os, signal, sys, time
arguments = dict(each.lstrip("-").split("=", 1) for each in sys.argv[3:] if "=" in each)
name = os.path.basename(sys.argv[2]).partition(".")[0]
log = os.path.join(os.path.dirname(sys.argv[2]), name)
def note(what):
    with open(log + "." + what, "w") as file:
        json.dump([time.time(), int(arguments["threads"]), sys.argv[1:]], file)
note("begun")
print("A line for nobody", file=sys.stderr)
if name.startswith("usage"):
    sys.exit(print("multibounce_ao: 'usage.blend' cannot be opened: bad magic", file=sys.stderr) or 2)
if name.startswith("crash"):
    print("Segmentation fault in the modifier", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
if name.startswith("slow"):
    open(os.path.join(os.path.dirname(log), f".slow.blend.{os.getpid()}.part.blend"), "w").close()
    time.sleep(60.0)
time.sleep(0.2)
one = {"name": name, "target": "VERTEX", "points": 4, "samples": 8, "rays": 32, "seconds": 0.5,
       "f0": {"min": 0.5, "mean": 0.75, "max": 1.0}, "outputs": [], "warnings": ["Odd"], "error": None}
if name.startswith("same"):
    one["outputs"] = ["Packed", os.path.join(os.path.dirname(log), "same.exr")]
if name.startswith("object"):
    one["error"] = "Object 'object' has no faces"
    print("Error: " + one["error"], file=sys.stderr)
with open(arguments["report"], "w") as file:
    json.dump({"objects": [one]}, file)
note("ended")
if name.startswith("unsaved"):
    print("Error: 'unsaved.blend' cannot be saved: no space left", file=sys.stderr)
sys.exit(name.startswith(("unsaved", "object")))
"""

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no kill -9 and no SIGINT for one process")


@pytest.fixture
def real(monkeypatch):
    if not bpy.app.binary_path:
        monkeypatch.setattr(operators("command_jobs"), "_program", lambda: [sys.executable, "-c", MODULE])


@pytest.fixture
def fake(monkeypatch, tmp_path):
    """Files of these names, and children that do as they say."""
    monkeypatch.setattr(operators("command_jobs"), "_program", lambda: [sys.executable, "-c", FAKE])

    def make(*names):
        files = [tmp_path / f"{name}.blend" for name in names]
        for file in files:
            file.touch()
        return files

    return make


def noted(file, what):
    """When, with how many threads, and how the fake child was called."""
    return json.loads(file.with_suffix(f".{what}").read_text())


def gathered(tmp_path, *arguments, code):
    report = tmp_path / "report.json"
    assert run("bake", *arguments, "--report", report) == code
    return json.loads(report.read_text(encoding="utf-8"))


def test_the_bits_of_one_by_one(real, scene, tmp_path, capsys):
    files = []
    for index in range(2):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        plate("Floor", half=1.0 + index)
        box("Crate", low=(-0.5, -0.5, 0.1), high=(0.5, 0.5, 0.5 + index))
        files.append(tmp_path / f"shot {index}.blend")
        bpy.ops.wm.save_as_mainfile(filepath=str(files[-1]))
    add_mesh("Broken", [(0, 0, 0)], [])
    bpy.ops.wm.save_mainfile()

    def baked(path):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        return [attribute(bpy.data.objects[name]) for name in ("Floor", "Crate")]

    settings = ["--object", "*", "--set", "samples=8"]
    expected = []
    for index, file in enumerate(files):
        alone = tmp_path / f"alone {index}.blend"
        assert run("bake", file, *settings, "--quiet", "--save", alone) == index
        expected += baked(alone)
    capsys.readouterr()
    pattern = tmp_path / "shot *.blend"
    report = gathered(tmp_path, pattern, *settings, "--jobs", 2, "--threads", 2, "--save", code=1)
    assert set(report) == {"version", "seconds", "files", "objects"}
    assert [(each["file"], each["error"]) for each in report["files"]] == [(str(file), None) for file in files]
    assert all(0 < each["seconds"] <= report["seconds"] for each in report["files"])
    told = {(entry["file"], entry["name"]): entry for entry in report["objects"]}
    assert len(told) == 5
    assert told.pop((str(files[1]), "Broken"))["error"].startswith("Object 'Broken' has no faces")
    assert all(entry["error"] is None and entry["samples"] == 8 for entry in told.values())
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.splitlines()[0].startswith(f"Error: '{files[1]}': Object 'Broken' has no faces")
    assert output.err.splitlines()[-1].startswith("4 baked, 1 failed, 0 of 2 files failed, in ")
    together = [values for file in files for values in baked(file)]
    assert all(np.array_equal(one, other) for one, other in zip(together, expected, strict=True))
    assert not np.array_equal(expected[1], expected[3])


def test_each_way_to_fail_is_named(fake, tmp_path, capsys):
    files = fake("good", "usage", "crash", "unsaved", "object", "good2")
    report = gathered(tmp_path, *files, "--jobs", 3, "--save", code=1)
    errors = {Path(each["file"]).stem: each["error"] for each in report["files"]}
    assert errors == {
        "good": None,
        "usage": "cannot be baked: 'usage.blend' cannot be opened: bad magic",
        "crash": "crashed (SIGKILL: Segmentation fault in the modifier): bake it alone to see more",
        "unsaved": "is not done: 'unsaved.blend' cannot be saved: no space left",
        "object": None,
        "good2": None,
    }
    assert [entry["name"] for entry in report["objects"]] == ["good", "unsaved", "object", "good2"]
    lines = capsys.readouterr().err.splitlines()
    for name in ("usage", "crash", "unsaved"):
        assert f"Error: '{tmp_path / name}.blend' {errors[name]}" in lines
    assert f"Warning: '{files[0]}': 'good': Odd" in lines
    head = next(index for index, line in enumerate(lines) if line.startswith("file "))
    table = [line.split() for line in lines[head : head + 8]]
    assert table[0] == ["file", "object", "points", "rays", "seconds", "mean", "AO"]
    assert table[1] == [str(files[0]), "good", "4", "32", "0.50", "0.7500"]
    assert table[3][1:] == ["object", "4", "32", "0.50", "failed"]
    assert [str(tmp_path / "crash.blend"), "-", "-", "-", "-", "failed"] in table
    assert lines[-1].startswith("3 baked, 1 failed, 3 of 6 files failed, in ")


def test_two_files_that_write_one_map(fake, tmp_path, capsys):
    """What they pack may have one name."""
    files = fake("same", "good", "same2")
    report = gathered(tmp_path, *files, code=1)
    first, _, later = [entry["error"] for entry in report["objects"]]
    assert first is None
    assert later == (
        f"Object 'same2' of '{files[2]}' and 'same' of '{files[0]}' both wrote '{tmp_path / 'same.exr'}': choose "
        "another Output in one of the files, or bake each in a call of its own with another --set "
        "output_directory=FOLDER"
    )
    assert "2 baked, 1 failed, 0 of 3 files failed" in capsys.readouterr().err


def test_jobs_run_side_by_side_and_share_the_threads(fake, tmp_path):
    files = fake("a", "b", "c", "d", "e")
    passed_on = ["--share", "1/2", "--scene", "S", "--resume"]
    assert run("bake", *files, "--jobs", 2, "--threads", 5, "--quiet", *passed_on) == 0
    begun, ended = ([noted(file, what)[0] for file in files] for what in ("begun", "ended"))
    events = sorted([(at, 1) for at in begun] + [(at, -1) for at in ended])
    at_work = np.cumsum([change for _, change in events])
    assert at_work.max() == 2
    threads = [noted(file, "begun")[1] for file in files]
    assert sorted(threads[:2]) == [2, 3] and set(threads) == {2, 3}
    command = noted(files[0], "begun")[2]
    assert command[:2] == ["bake", str(files[0])]
    assert {"--share=1/2", "--scene=S", "--resume", "--quiet", "--checkpoint=5.0"} < set(command)
    assert "--save" not in command
    # More jobs than files or threads: a thread each.
    assert run("bake", *files[:2], "--jobs", 9, "--threads", 1, "--quiet") == 0
    assert [noted(file, "begun")[1] for file in files[:2]] == [1, 1]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interruption_ends_the_children(fake, tmp_path, number, capsys):
    files = fake("good", "slow", "never")
    began = time.monotonic()
    slow = files[1].with_suffix(".begun")

    def interrupt():
        while not (slow.exists() and slow.stat().st_size) and time.monotonic() < began + 30.0:
            time.sleep(0.01)
        os.kill(os.getpid(), number)

    before = signal.getsignal(number)
    thread = threading.Thread(target=interrupt)
    thread.start()
    report = gathered(tmp_path, *files, code=1)
    thread.join()
    assert time.monotonic() - began < 30.0
    assert signal.getsignal(number) == before
    assert [each["error"] for each in report["files"]] == [None, "was interrupted", "was not begun"]
    assert not files[2].with_suffix(".begun").exists()
    assert not list(tmp_path.glob(".*"))  # no unfinished .blend
    assert "1 baked, 0 failed, 2 of 3 files failed" in capsys.readouterr().err


def test_progress_goes_to_a_terminal_alone(fake, tmp_path, capsys, monkeypatch):
    files = fake("good", "usage")
    for terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda terminal=terminal: terminal)
        assert run("bake", *files) == 1
        assert ("Multibounce AO: 2 of 2" in capsys.readouterr().err) == terminal
    assert run("bake", *files, "--quiet") == 1
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_patterns_in_every_part_of_a_path(scene, tmp_path, monkeypatch):
    found = operators("command_files").blend_files
    wrong = operators("command_files").UsageError
    for name in ("n1/a.blend", "n1/b.txt", "n2/a.blend", "n2/below/c.blend", "shots [v1]/n1/d.blend"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()

    for start in ("", f"{tmp_path}/"):
        monkeypatch.chdir(tmp_path)

        def names(*patterns, start=start):
            files = found([start + pattern for pattern in patterns])
            return [str(file).removeprefix(start) for file in files]

        assert names("n?/*.blend") == ["n1/a.blend", "n2/a.blend"]
        assert names("n2/a.blend", "n*/a.blend") == ["n2/a.blend", "n1/a.blend"]
        assert names("n?/**/*.blend") == ["n1/a.blend", "n2/a.blend", "n2/below/c.blend"]
        assert names("shots [v1]/n?/*.blend") == names("shots [v1]/n1/d.blend") == ["shots [v1]/n1/d.blend"]
        for folder in ("n1", "n?", "shots [v1]"):
            with pytest.raises(wrong) as told:
                names(folder)
            assert str(told.value) == f"'{start}{folder}' is a folder: write '{start}{folder}/*.blend'"
        for nothing in ("n3/*.blend", "n3", "n1/a.blend/*"):
            with pytest.raises(wrong, match="there is no file"):
                names(nothing)


def test_wrong_usage(fake, tmp_path, capsys):
    files = fake("a", "b")
    for arguments, told in (
        ([*files, "--save", tmp_path / "c.blend"], "several files are saved each in its place"),
        ([*files, tmp_path / "missing.blend"], "there is no file"),
        ([*files, "--report", files[0] / "below" / "a.json"], "cannot be written"),
        ([*files, "--jobs", "0"], "whole number from 1"),
        ([*files, "--threads", "many"], "whole number from 1"),
    ):
        assert run("bake", *arguments) == 2
        assert told in capsys.readouterr().err
    assert not list(tmp_path.glob("*.begun"))


def test_this_same_blender_is_called_as_it_was(monkeypatch):
    jobs = operators("command_jobs")
    app = SimpleNamespace(binary_path="/opt/blender")
    monkeypatch.setattr(jobs, "bpy", SimpleNamespace(app=app))
    monkeypatch.setattr(sys, "argv", ["blender", "--factory-startup", "-c", "multibounce_ao", "bake", "-c"])
    assert jobs._program() == ["/opt/blender", "--factory-startup", "--command", "multibounce_ao"]
    app.binary_path = ""
    with pytest.raises(operators("command_files").UsageError, match="need Blender's program"):
        jobs._program()
