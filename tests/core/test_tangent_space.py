# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions go into tangent space and come back."""

import numpy as np

from core.rasterise import rasterise
from core.tangent_space import Tangents, as_colours, at_texels, to_tangent_space


def test_decoding_gives_the_direction_back():
    """n = x T + y B + z N, in frames that are neither orthogonal nor of unit length, also left-handed ones."""
    rng = np.random.default_rng(0)
    frames, directions = rng.normal(size=(1000, 3, 3)), rng.normal(size=(1000, 3))
    local = to_tangent_space(directions, frames)
    np.testing.assert_allclose(np.linalg.norm(local, axis=1), 1.0, atol=1e-12)
    decoded = np.einsum("ni,nix->nx", local, frames)
    decoded /= np.linalg.norm(decoded, axis=1, keepdims=True)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    np.testing.assert_allclose(decoded, directions, atol=1e-8)


def test_what_has_no_direction_or_no_frame_is_the_normal():
    flat = np.array([[(1.0, 0, 0), (1.0, 0, 0), (0, 0, 1.0)], [(0, 0, 0), (0, 0, 0), (0, 0, 1.0)]])
    local = to_tangent_space([(0, 0, 0), (0, 1, 0), (0, 1, 0)], np.concatenate((np.eye(3)[None], flat)))
    np.testing.assert_array_equal(local, [(0, 0, 1)] * 3)


def test_colours():
    np.testing.assert_allclose(as_colours([(0, 0, 1), (1, -1, 0)]), [(0.5, 0.5, 1, 1), (1, 0, 0.5, 1)])
    np.testing.assert_allclose(as_colours([(0, 0, 1), (1, -1, 0)], flip_y=True), [(0.5, 0.5, 1, 1), (1, 1, 0.5, 1)])


def test_frames_are_those_of_the_texels_middle():
    """On a triangle whose corners differ, whatever the number of places: linear in the texel's middle."""
    uv = np.array([[(0, 0), (2, 0), (0, 2)]], float)  # covers all of the tile
    rng = np.random.default_rng(1)
    normals, vectors = rng.normal(size=(2, 3, 3))
    triangles, signs = np.array([(0, 1, 2)]), np.full(3, -1.0)
    for places in (1, 5, 8):
        texels = rasterise(uv, 8, 8, places)
        row, column = np.divmod(texels.texel, 8)
        v, w = (column + 0.5) / 16, (row + 0.5) / 16
        weights = np.column_stack((1 - v - w, v, w))
        tangent, bitangent, normal = np.moveaxis(at_texels(texels, triangles, normals, Tangents(vectors, signs)), 1, 0)
        np.testing.assert_allclose(normal, weights @ normals, atol=1e-6)
        np.testing.assert_allclose(tangent, weights @ vectors, atol=1e-6)
        np.testing.assert_allclose(bitangent, -np.cross(normal, tangent), atol=1e-6)
        np.testing.assert_allclose(at_texels(texels, triangles, normals, None)[:, 0], normal, atol=1e-6)


def test_one_texel_has_one_sign():
    """Two halves of a texel, one mirrored: the frame is of one of them, not their mean."""
    uv = np.array([[(0, 0), (0.5, 0), (0.5, 1)], [(0, 0), (0.5, 1), (0, 1)], [(1, 0), (0.5, 0), (0.5, 1)]], float)
    vectors = np.repeat(np.array([(1.0, 0, 0), (1.0, 0, 0), (-1.0, 0, 0)]), 3, axis=0)
    signs = np.repeat((1.0, 1.0, -1.0), 3)
    normals = np.tile((0.0, 0.0, 1.0), (9, 1))
    frames = at_texels(rasterise(uv, 1, 1, 8), np.arange(9).reshape(3, 3), normals, Tangents(vectors, signs))
    np.testing.assert_allclose(np.abs(frames[0]), np.eye(3), atol=1e-6)
