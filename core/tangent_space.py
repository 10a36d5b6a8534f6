# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions in the tangent space of a UV map, as normal maps hold them.

The common convention of Blender, glTF and game engines is MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces
Revisited"): a corner has a normal N, a tangent T along u, and a sign. A shader interpolates N and T over the triangle,
leaves them at the length that comes out, and decodes

    n = x T + y B + z N        B = sign N x T

Here a direction n is solved for x, y, z in that same frame, so that decoding gives it back exactly, wherever the
interpolated vectors are not orthogonal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .rasterise import Texels


@dataclass(frozen=True)
class Tangents:
    """Of the face corners of a mesh: unit ``vectors`` (c, 3) in object space, ``signs`` (c,) -1 where the UVs are
    mirrored, else 1."""

    vectors: NDArray[np.floating]
    signs: NDArray[np.floating]


def at_texels(
    texels: Texels, triangles: NDArray[np.integer], normals: NDArray, tangents: Tangents | None
) -> NDArray[np.float64]:
    """Frames (k, 3, 3) in the middles of ``texels``, rows T, B, N, at the length that interpolation gives them; without
    ``tangents`` (k, 1, 3), N alone.

    triangles  (m, 3) corners of the triangles
    normals    (c, 3) unit normals of the corners

    The middle is the mean of a texel's places, of those whose UVs are mirrored as the first one's are.
    """
    corners = triangles[texels.triangle]
    weights = np.concatenate((1.0 - texels.weights.sum(axis=2, keepdims=True), texels.weights), axis=2)
    if tangents is None:
        return np.einsum("kpc,kpcx->kx", weights / weights.shape[1], normals[corners])[:, None]
    signs = tangents.signs[corners[..., 0]]
    alike = signs == signs[:, :1]
    weights = weights * (alike / alike.sum(axis=1, keepdims=True))[..., None]
    normal, tangent = (np.einsum("kpc,kpcx->kx", weights, each[corners]) for each in (normals, tangents.vectors))
    return np.stack((tangent, signs[:, :1] * np.cross(normal, tangent), normal), axis=1)


def to_tangent_space(directions: ArrayLike, frames: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit x, y, z (n, 3) of ``directions`` (n, 3) in ``frames`` (n, 3, 3), rows T, B, N.

    (0, 0, 1), the normal, for directions of no length and where the frame is flat, as on faces without UV area.
    """
    directions = np.asarray(directions, np.float64)
    tangent, bitangent, normal = np.moveaxis(frames, 1, 0)
    # Cramer's rule; the determinant is common to all three.
    across = np.cross(bitangent, normal), np.cross(normal, tangent), np.cross(tangent, bitangent)
    volume = np.einsum("nx,nx->n", tangent, across[0])
    local = np.column_stack([np.einsum("nx,nx->n", directions, each) for each in across])
    local *= np.sign(volume)[:, None]
    length = np.sqrt(np.square(local).sum(axis=1))
    is_known = (length > 1e-12) & (np.abs(volume) > 1e-9)
    local[~is_known] = 0.0, 0.0, 1.0
    return local / np.where(is_known, length, 1.0)[:, None]


def as_colours(directions: ArrayLike, flip_y: bool = False) -> NDArray[np.float32]:
    """Unit ``directions`` (n, 3) as colours (n, 4), 0.5 + 0.5 n and alpha 1; with ``flip_y`` DirectX', whose y goes
    down the image."""
    sign = np.array((1.0, -1.0 if flip_y else 1.0, 1.0))
    colours = 0.5 + 0.5 * sign * np.asarray(directions, np.float64)
    return np.column_stack((colours, np.ones(len(colours)))).astype(np.float32)
