# SPDX-License-Identifier: GPL-3.0-or-later
"""Fields as files: the very numbers back, cubemaps that other programs can read, nothing half-written."""

import json

import numpy as np
import OpenEXR
import pytest

from core.cubemap import lookup, nodes
from core.field_files import load_field, save_field

from .fields import made, receivers, unit


@pytest.mark.parametrize("volume", [False, True])
def test_loading_gives_the_same_numbers(tmp_path, volume):
    mesh, field = made("table", volume=volume)
    paths = save_field(field, tmp_path, "Table")
    size = sum(path.stat().st_size for path in paths)
    print(f"files of a table{' with its volume' if volume else ''}: {size / 1000:.1f} kB")
    assert size < 100_000
    assert sorted(paths) == sorted(tmp_path.iterdir()) and paths[-1].name == "Table_ao_field.json"
    loaded = load_field(paths[-1])
    for key in ("centre", "a", "b", "c", "d", "r0", "a_m", "b_m", "c_m", "c0", "e"):
        assert getattr(loaded, key).tobytes() == getattr(field, key).tobytes(), key
    for key in ("radius", "r_near", "r_far", "a0", "p", "resolution"):
        assert getattr(loaded, key) == getattr(field, key), key
    positions, normals = receivers(mesh, 500)
    assert (loaded.occlusion(positions, normals) == field.occlusion(positions, normals)).all()
    if volume:
        for key in ("values", "low", "high"):
            assert getattr(loaded.volume, key).tobytes() == getattr(field.volume, key).tobytes(), key
        assert loaded.volume.p == field.volume.p


def test_cubemaps_are_openexrs(tmp_path):
    field = made("table")[1]
    save_field(field, tmp_path, "Table")
    with OpenEXR.File(str(tmp_path / "Table_ao_field_occlusion.exr"), separate_channels=True) as file:
        assert file.header()["envmap"] == OpenEXR.ENVMAP_CUBE
        r0 = file.channels()["A"].pixels
    assert r0.shape == (96, 16) and r0.dtype == np.float32
    # Texel for texel: the hull's distance where ImfEnvmap.h puts that direction (tests/core/test_cubemap.py).
    omega, node = nodes(16)
    expected = np.zeros(len(omega))
    expected[node] = field.r0
    assert (r0.reshape(6, 16, 16) == expected[node]).all()
    # The table is long along x and low along z: so are the faces' middles, +X -X +Y -Y +Z -Z from the top.
    middle = r0.reshape(6, 16, 16)[:, 7:9, 7:9].mean(axis=(1, 2))
    assert middle[0] == pytest.approx(0.9, rel=0.02) and middle[2] == pytest.approx(0.6, rel=0.02)
    told = json.loads((tmp_path / "Table_ao_field.json").read_text())
    assert {"centre", "radius", "r_near", "r_far", "A0", "p", "resolution", "version", "units"} <= set(told)


def test_files_of_the_first_version_load(tmp_path):
    """They had 0 in place of d, and no e, which is 1: Omega and Upsilon of the published model."""
    mesh, field = made("table")
    path = save_field(field, tmp_path, "Table")[-1]
    moment = tmp_path / "Table_ao_field_moment.exr"
    with OpenEXR.File(str(moment), separate_channels=True) as file:
        channels = {name: file.channels()[name].pixels.copy() for name in "RGB"}
    channels["B"][:] = 0.0
    with OpenEXR.File({"type": OpenEXR.scanlineimage, "envmap": OpenEXR.ENVMAP_CUBE}, channels) as file:
        file.write(str(moment))
    path.write_text(json.dumps(json.loads(path.read_text()) | {"version": 1}))
    loaded = load_field(path)
    positions, _ = receivers(mesh, 500)
    r = np.linalg.norm(positions - field.centre, axis=1)
    omega = (positions - field.centre) / r[:, None]
    a, b, c, r0 = lookup(np.stack((field.a, field.b, field.c, field.r0), axis=-1), omega).T
    assert (r > r0).mean() > 0.95
    outside, caps = r > r0, loaded.caps(positions, plain_cap=True)
    assert caps.solid_angle[outside] == pytest.approx(1.0 / ((a * r + b) * r + c)[outside])
    towards = lookup(field.c0, omega) - r[:, None] * omega
    assert caps.direction[outside] == pytest.approx(unit(towards)[outside])


def test_a_field_without_a_volume_takes_an_older_volume_away(tmp_path):
    save_field(made("table", volume=True)[1], tmp_path, "Table")
    path = save_field(made("table")[1], tmp_path, "Table")[-1]
    assert not (tmp_path / "Table_ao_field_volume.exr").exists() and load_field(path).volume is None


def test_what_cannot_be_written_or_read(tmp_path):
    field = made("table")[1]
    with pytest.raises(OSError, match="Table"):
        save_field(field, tmp_path / "missing", "Table")
    path = save_field(field, tmp_path, "Table")[-1]
    before = {each: each.read_bytes() for each in tmp_path.iterdir()}
    # An image cannot take a folder's place: the files that were there stay, and nothing is left over.
    (tmp_path / "Other_ao_field.json").mkdir()
    with pytest.raises(OSError):
        save_field(field, tmp_path, "Other")
    assert not list(tmp_path.glob(".*"))
    assert all(each.read_bytes() == content for each, content in before.items())
    told = json.loads(path.read_text())
    path.write_text(json.dumps(told | {"version": 99}))
    with pytest.raises(ValueError, match="version 99"):
        load_field(path)
    path.write_text(json.dumps({"version": 1}))
    with pytest.raises(ValueError, match="not the JSON file"):
        load_field(path)
    path.write_text(json.dumps(told | {"resolution": 8}))
    with pytest.raises(ValueError, match="pixels"):
        load_field(path)
    path.write_text(json.dumps(told))
    (tmp_path / "Table_ao_field_moment.exr").unlink()
    with pytest.raises(OSError, match="moment"):
        load_field(path)
