# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/ao_field.glsl, run line by line on the files of a field, against the field itself."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from core.cap import occlusion
from core.field_files import load_field, save_field

from .fields import made, receivers, unit
from .glsl import Vector, load

GLSL = Path(__file__).resolve().parents[2] / "docs" / "ao_field.glsl"


def pixels(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        first = channels["R"].pixels
        alpha = channels["A"].pixels if "A" in channels else np.ones_like(first)
        return np.stack([*(channels[name].pixels for name in "RGB"), alpha], axis=-1).astype(float)


@pytest.mark.skipif(not GLSL.exists(), reason="the documents are no part of the built extension")
@pytest.mark.parametrize("name", ["cube", "table"])
def test_shader_gives_the_fields_numbers(tmp_path, name):
    mesh, field = made(name)
    field = load_field(save_field(field, tmp_path, "Thing")[-1])
    maps = {
        f"{key}_map": pixels(tmp_path / f"Thing_ao_field_{key}.exr") for key in ("occlusion", "direction", "moment")
    }
    scalars = {"r_near": field.r_near, "r_far": field.r_far, "A0": field.a0, "p": field.p}
    centre = Vector(field.centre[None])
    shader = load(GLSL, **maps, **scalars, centre=centre, resolution=float(field.resolution))

    random = np.random.default_rng(4)
    outside, normals = receivers(mesh, 3000)
    anywhere = field.centre + random.normal(size=(3000, 3)) * field.radius * random.uniform(0.0, 6.0, (3000, 1))
    # Straight over the cube's edges and corners, where faces meet.
    edges = field.centre + field.radius * np.sign(random.normal(size=(500, 3))) * random.integers(0, 2, (500, 3))
    positions = np.concatenate((outside, anywhere, edges))
    normals = np.concatenate((normals, unit(random.normal(size=(3500, 3)))))
    difference = np.abs(shader["ao_field"](Vector(positions), Vector(normals)) - field.occlusion(positions, normals))
    print(f"{name}: GLSL against numpy, largest difference {difference.max():.1e}")
    assert difference.max() < 1e-9


@pytest.mark.skipif(not GLSL.exists(), reason="the documents are no part of the built extension")
def test_shaders_cap():
    nothing = dict.fromkeys(
        ("occlusion_map", "direction_map", "moment_map", "centre", "r_near", "r_far", "A0", "p", "resolution")
    )
    solid_angle, k = np.random.default_rng(5).uniform((0.0, -1.0), (4.0 * np.pi, 1.0), (2000, 2)).T
    assert np.abs(load(GLSL, **nothing)["cap_occlusion"](solid_angle, k) - occlusion(solid_angle, k)).max() < 1e-12
