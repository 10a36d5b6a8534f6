# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces and triangles as they are read, against what Blender gives one by one."""

import bpy
import numpy as np
import pytest

from .bakes import operators
from .meshes import add_mesh, suzanne


@pytest.fixture
def reader():
    return operators("mesh_reader")


def fan():
    return add_mesh("Fan", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 0, 0)], [(0, 1, 2), (0, 2, 3), (0, 4, 3)])


def mixed():
    """A quad and a pentagon among triangles."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 0.5, 0), (-1, 1, 0)]
    return add_mesh("Mixed", corners, [(0, 1, 2, 3), (0, 3, 4), (3, 5, 4)])


@pytest.mark.parametrize("make", [fan, mixed, suzanne])
def test_faces_and_triangles(scene, reader, make):
    mesh = make().data
    mesh.calc_loop_triangles()
    np.testing.assert_array_equal(reader.read_face_starts(mesh), [face.loop_start for face in mesh.polygons])
    np.testing.assert_array_equal(reader.read_triangles(mesh), [tuple(each.loops) for each in mesh.loop_triangles])


def test_no_faces(scene, reader):
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata([(0, 0, 0)], [], [])
    assert reader.read_face_starts(mesh).shape == (0,) and reader.read_triangles(mesh).shape == (0, 3)
