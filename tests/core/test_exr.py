# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR files: every bit, or half as many; and files that are whole at every moment."""

import os
import subprocess
import sys
import time
from functools import partial

import numpy as np
import OpenEXR
import pytest
from enable_extension import source_folder

from core.exr import CODECS, read_exr, read_metadata, write_exr
from core.whole_files import ABANDONED, whole_files

PIXELS = np.random.default_rng(0).random((5, 7, 4)).astype(np.float32)


@pytest.mark.parametrize("codec", CODECS)
def test_every_bit_is_kept(codec, tmp_path):
    path = tmp_path / "map.exr"
    write_exr(path, PIXELS, codec=codec)
    np.testing.assert_array_equal(read_exr(path), PIXELS)
    with OpenEXR.File(str(path), header_only=True) as file:
        names = {"NONE": "NO_COMPRESSION"}
        assert file.header()["compression"] == getattr(OpenEXR, names.get(codec, f"{codec}_COMPRESSION"))


def test_half_floats_are_the_nearest(tmp_path):
    """Half a step of numbers with 11 significant bits below 1 is 2^-12."""
    write_exr(tmp_path / "map.exr", PIXELS, half=True)
    with OpenEXR.File(str(tmp_path / "map.exr"), separate_channels=True) as file:
        assert {name: channel.pixels.dtype for name, channel in file.channels().items()} == dict.fromkeys(
            "RGBA", np.float16
        )
    assert np.abs(read_exr(tmp_path / "map.exr") - PIXELS).max() <= 2.0**-12


def test_metadata(tmp_path):
    told = {"software": "ours", "settings": '{"samples": 64, "uv": "Ü"}'}
    write_exr(tmp_path / "map.exr", PIXELS, metadata=told)
    assert read_metadata(tmp_path / "map.exr").items() >= told.items()


def test_a_file_that_cannot_be_written(tmp_path):
    with pytest.raises(OSError, match="cannot write"):
        write_exr(tmp_path / "missing" / "map.exr", PIXELS)


def test_files_take_their_names_together_or_not_at_all(tmp_path):
    one, two = tmp_path / "one.txt", tmp_path / "two.txt"
    one.write_text("old")
    with pytest.raises(ZeroDivisionError), whole_files(one, two) as parts:
        parts[0].write_text("new")
        assert parts[0].suffix == ".txt"  # programs choose the format by it
        raise ZeroDivisionError
    assert [path.name for path in tmp_path.iterdir()] == ["one.txt"]
    assert one.read_text() == "old"
    with whole_files(one, two) as parts:
        for part in parts:
            part.write_text("new")
        assert one.read_text() == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.txt", "two.txt"]
    assert one.read_text() == two.read_text() == "new"


def test_what_a_killed_process_left_is_taken_away_later(tmp_path):
    left, fresh, other = (tmp_path / name for name in (".map.1.part.exr", ".map.2.part.exr", ".maps.1.part.exr"))
    for path in (left, fresh, other):
        path.write_text("half")
    past = time.time() - 2 * ABANDONED
    os.utime(left, (past, past))
    os.utime(other, (past, past))
    with whole_files(tmp_path / "map.exr") as (part,):
        part.write_text("whole")
    assert {path.name for path in tmp_path.iterdir()} == {"map.exr", fresh.name, other.name}


# Writes maps of 1, 2, 3, ... all over, each pair of them together, until it is killed.
WRITER = """
import itertools, pathlib, sys
import numpy as np
sys.path.insert(0, sys.argv[1])
from core.exr import write_exr
from core.whole_files import whole_files
paths = [pathlib.Path(sys.argv[2]) / name for name in ("one.exr", "two.exr")]
for count in itertools.count(1):
    with whole_files(*paths) as parts:
        for part in parts:
            write_exr(part, np.full((256, 256, 4), count, np.float32), codec="NONE")
    print("written", flush=True)
"""


def test_killed_at_ten_random_moments(tmp_path):
    random = np.random.default_rng(0)
    for number in range(10):
        folder = tmp_path / str(number)
        folder.mkdir()
        for name in ("one.exr", "two.exr"):
            write_exr(folder / name, np.zeros((256, 256, 4), np.float32))
    command = [sys.executable, "-c", WRITER, str(source_folder())]
    # In Blender the wheels' folder is on its own path only.
    run = partial(subprocess.Popen, stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)})
    writers = [run([*command, str(tmp_path / str(n))]) for n in range(10)]
    for number, writer in enumerate(writers):
        with writer:
            assert writer.stdout.readline() == b"written\n"
            time.sleep(0.05 * random.random())
            writer.kill()
        first = []
        for name in ("one.exr", "two.exr"):
            pixels = read_exr(tmp_path / str(number) / name)
            assert (pixels == pixels[0, 0, 0]).all()
            first.append(pixels[0, 0, 0])
        assert 0 <= first[0] - first[1] <= 1
        assert first[0] >= 1
