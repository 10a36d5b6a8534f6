# SPDX-License-Identifier: GPL-3.0-or-later
"""The mean k_A over the area of texels: a ray each from thousands of places that jitter over the covered part of it.

Which triangle a place belongs to is looked up here, by barycentric coordinates against every triangle whose bounds
meet the texel, and by nothing of the extension's.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import bpy
import numpy as np
from numpy.typing import NDArray
from truth import Geometry, hemisphere

STRATA = 48  # squared: places, and rays, of each of the two estimates
FEWEST = 100  # places inside a triangle, below which a texel is barely touched and has no truth here


class TexelTruth:
    """Texels of the active UV map of ``obj``, whose images have ``resolution`` pixels a side."""

    def __init__(self, obj: bpy.types.Object, resolution: int):
        self.geometry = Geometry.of(obj)
        self.resolution = resolution
        data = obj.data.uv_layers.active.data
        uv = np.empty(2 * len(data), np.float32)
        data.foreach_get("uv", uv)
        self._uv = uv.reshape(-1, 2).astype(np.float64)[self.geometry.corners] * resolution
        self._low, self._high = self._uv.min(axis=1), self._uv.max(axis=1)

    def covered(self, count: int, seed: int = 0) -> NDArray[np.intp]:
        """Up to ``count`` random texels (k, 2), column and row, whose centre lies in a triangle; by rows."""
        random = np.random.default_rng(seed)
        texels = random.integers(self.resolution, size=(4 * count, 2))
        texels = texels[np.argsort(texels[:, 1])]
        found = []
        for chunk in _chunks(texels, 32):
            triangle, _, _ = self._lookup(chunk, chunk[:, None, :] + 0.5)
            found.append(chunk[triangle[:, 0] >= 0])
        found = np.concatenate(found)
        return found[np.sort(random.permutation(len(found))[:count])]

    def visibility(self, texels: NDArray[np.intp], seed: int = 0) -> NDArray[np.float64]:
        """Two independent estimates (2, k) of the mean k_A over the covered part of each of ``texels`` (k, 2), NaN
        where that is hardly anything, or where the layout overlaps itself and a bake may take either face."""

        def estimate(part, number, half):
            random = np.random.default_rng((seed, half, number))
            # Strata of the texel's square in another order than those of the hemisphere.
            cell = np.argsort(random.random((len(part), STRATA**2)), axis=1)
            places = np.stack((cell % STRATA, cell // STRATA), axis=-1) + random.random((len(part), STRATA**2, 2))
            triangle, weights, claims = self._lookup(part, part[:, None, :] + places / STRATA)
            inside = triangle >= 0
            corners = self.geometry.triangles[triangle[inside]]
            points = np.einsum("rc,rcx->rx", weights[inside], self.geometry.vertices[corners])
            normals = self.geometry.corner_normals[self.geometry.corners[triangle[inside]]]
            normals = np.einsum("rc,rcx->rx", weights[inside], normals)
            normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            about_z = np.broadcast_to((0.0, 0.0, 1.0), (len(part), 3))
            local = hemisphere(about_z, STRATA, "cosine", (seed, half, number, 1))[inside]
            blocked = np.zeros(inside.shape, bool)
            blocked[inside] = self.geometry.blocked(points, normals, _turned(local, normals))
            is_clear = (inside.sum(axis=1) >= FEWEST) & (claims <= 1).all(axis=1)
            return np.where(is_clear, 1.0 - blocked.sum(axis=1) / np.maximum(inside.sum(axis=1), 1), np.nan)

        parts = list(_chunks(texels, 16))
        self.geometry.blocked(*np.zeros((2, 1, 3)), np.ones((1, 3), np.float32))  # the tree, before threads ask for it
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            halves = [pool.map(estimate, parts, range(len(parts)), [half] * len(parts)) for half in (0, 1)]
            return np.array([np.concatenate(list(half)) for half in halves])

    def _lookup(self, texels: NDArray, places: NDArray) -> tuple[NDArray[np.intp], NDArray, NDArray[np.intp]]:
        """The triangle (k, p) of each of ``places`` (k, p, 2) within ``texels`` (k, 2), -1 for none; its barycentric
        coordinates (k, p, 3); and how many triangles claim the place (k, p)."""
        # Texels that come by rows share few triangles: those first.
        first, last = texels[:, 1].min(), texels[:, 1].max() + 1
        near = np.flatnonzero((self._low[:, 1] < last) & (self._high[:, 1] > first))
        meets = ((self._low[near] < texels[:, None] + 1) & (self._high[near] > texels[:, None])).all(axis=2)
        texel, candidate = np.nonzero(meets)
        candidate = near[candidate]
        a, b, c = np.moveaxis(self._uv[candidate], 1, 0)[:, :, None]
        at = places[texel]
        twice = _cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = np.stack((_cross(b - at, c - at), _cross(c - at, a - at), _cross(a - at, b - at)), -1)
            weights = weights / twice[..., None]
        pair, place = np.nonzero((weights >= 0.0).all(axis=2))
        claims = np.bincount(texel[pair] * places.shape[1] + place, minlength=places.size // 2)
        triangle = np.full(places.shape[:2], -1)
        barycentric = np.zeros((*places.shape[:2], 3))
        triangle[texel[pair], place] = candidate[pair]
        barycentric[texel[pair], place] = weights[pair, place]
        return triangle, barycentric, claims.reshape(places.shape[:2])


def _cross(a: NDArray, b: NDArray) -> NDArray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _turned(local: NDArray, normals: NDArray) -> NDArray[np.float32]:
    """Directions (r, 3) about +z turned to be about ``normals`` (r, 3): by half a turn about what lies between."""
    between = normals + np.array((0.0, 0.0, 1.0))
    length = (between**2).sum(axis=1, keepdims=True)
    # Straight down there is nothing between: any horizontal axis.
    between = np.where(length > 1e-12, between, (1.0, 0.0, 0.0))
    length = np.where(length > 1e-12, length, 1.0)
    along = (local * between).sum(axis=1, keepdims=True)
    return (2.0 * along / length * between - local).astype(np.float32)


def _chunks(array: NDArray, size: int) -> Iterator[NDArray]:
    return (array[start : start + size] for start in range(0, len(array), size))
