# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake does not depend on where the mesh is, how large it is and how it is turned.

Noise is the only difference allowed: below .01 rms at 256 samples, and no speckle, no vertex off by more than .2.
"""

import numpy as np
import pytest

from .bakes import BENT_CONE, attribute, bake, f0, rms
from .meshes import plate, positions, suzanne


def assert_same(one, other):
    difference = one - other
    print(f"rms {rms(difference):.4f}, worst {abs(difference).max():.3f}")
    assert rms(difference) < 0.01
    assert abs(difference).max() < 0.2


def visible_cone(obj):
    """(1/2pi) * integral of V w, object space. The mean direction alone is noise where hardly a ray gets out."""
    cone = attribute(obj, BENT_CONE)
    return cone[:, :3] * cone[:, 3:]


def set_positions(obj, values):
    obj.data.vertices.foreach_set("co", np.asarray(values, np.float32).ravel())
    obj.data.update()


@pytest.mark.parametrize(
    "transform",
    [
        {"location": (1e5, -1e5, 1e5)},
        {"scale": (1e-3,) * 3},
        {"scale": (1e4,) * 3},
        {"rotation_euler": (0.9, -2.1, 0.4)},
        {"location": (-1e5, 0, 0), "scale": (1e-3,) * 3, "rotation_euler": (0, 1, 2)},
        {"scale": (-1, 1, 1)},
        {"scale": (-2, -2, -2), "rotation_euler": (0.3, 0.2, 0.1)},
    ],
    ids=str,
)
def test_object_transform(transform):
    obj = suzanne(levels=1)
    bake(obj, samples=256)
    expected, expected_cone = f0(obj), visible_cone(obj)
    assert np.ptp(expected) > 0.7
    for name, value in transform.items():
        setattr(obj, name, value)
    bake(obj, samples=256)
    assert_same(f0(obj), expected)
    assert_same(visible_cone(obj), expected_cone)


def test_mesh_far_from_its_origin():
    """Float32 has steps of 1/128 at 1e5: the mesh is large, and compared with what those steps leave of it."""
    obj = suzanne(levels=1)
    far = np.float32(positions(obj) * 1000) + np.float32(1e5)
    set_positions(obj, far - np.float32(1e5))  # exact
    bake(obj, samples=256)
    expected = f0(obj)
    set_positions(obj, far)
    bake(obj, samples=256)
    assert_same(f0(obj), expected)


def test_object_in_a_wide_landscape():
    """Contacts of a head of 2.7 m stay dark a kilometre off the centre of a landscape of four kilometres."""
    obj = suzanne(levels=1, location=(1e3, 1e3, 0))
    bake(obj, samples=256)
    expected = f0(obj)
    for corner in (-2e3, 2e3):  # they hide nothing worth mentioning of the sky
        plate("Edge of the land", half=0.1, location=(corner, corner, 0))
    bake(obj, samples=256)
    assert_same(f0(obj), expected)
