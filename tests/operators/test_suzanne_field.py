# SPDX-License-Identifier: GPL-3.0-or-later
"""The ambient occlusion field of Blender's monkey against rays, as tests/core/test_ao_field.py has it of others."""

import bpy
import numpy as np

from ..core.fields import assert_no_pole, baked, error_around, error_on_floor


def test_receivers_around_suzanne(empty_scene):
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.active_object.data
    mesh.calc_loop_triangles()
    vertices = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", vertices)
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    suzanne = vertices.reshape(-1, 3).astype(float), triangles.reshape(-1, 3)
    field = baked(suzanne)
    assert error_around("Suzanne", suzanne, field, 0.021) < 0.021
    assert error_on_floor("Suzanne", suzanne, field) < 0.025
    assert_no_pole(field)
