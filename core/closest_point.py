# SPDX-License-Identifier: GPL-3.0-or-later
"""The nearest point of a triangle mesh to each of many points, exactly, by scipy's k-d tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def closest_point(
    queries: NDArray, vertices: NDArray, triangles: NDArray
) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """Nearest triangle (q,) and barycentric coordinates (q, 3) of the nearest point on it.

    queries (q, 3), vertices (n, 3) float; triangles (m, 3) int, at least one.

    A triangle lies within its radius of its centroid. Among triangles of one size class, a candidate found is therefore
    final once the k-th nearest centroid is further than the best distance plus the class's radius; until then k grows.
    """
    from scipy.spatial import cKDTree

    queries = np.asarray(queries, np.float64)
    corners = np.asarray(vertices, np.float64)[triangles]
    centroid = corners.mean(axis=1)
    radius = np.linalg.norm(corners - centroid[:, None], axis=2).max(axis=1)
    best = np.full(len(queries), np.inf)
    nearest = np.zeros(len(queries), np.intp)
    weights = np.zeros((len(queries), 3))
    size_class = np.floor(np.log2(np.maximum(radius, 1e-300)))
    for size in np.unique(size_class):
        members = np.flatnonzero(size_class == size)
        reach = radius[members].max()
        tree = cKDTree(centroid[members])
        open_, k = np.arange(len(queries)), 8
        while len(open_):
            k = min(k, len(members))
            distance, index = tree.query(queries[open_], k=np.arange(1, k + 1))
            candidate = members[index]
            found, at = _closest_on_triangles(queries[open_, None], corners[candidate])
            column = found.argmin(axis=1)
            row = np.arange(len(open_))
            better = found[row, column] < best[open_]
            winners = open_[better]
            best[winners] = found[row, column][better]
            nearest[winners] = candidate[row, column][better]
            weights[winners] = at[row, column][better]
            if k == len(members):
                break
            open_ = open_[distance[:, -1] - reach < best[open_]]
            k *= 4
    return nearest, weights


def _closest_on_triangles(points: NDArray, triangles: NDArray) -> tuple[NDArray, NDArray]:
    """Distance (...) and barycentric coordinates (..., 3) of the nearest point of each triangle (..., 3, 3).

    The projection onto the plane where it falls inside, else the nearest of the three edges.
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    ab, ac, ap = b - a, c - a, points - a
    d00, d01, d11 = _dot(ab, ab), _dot(ab, ac), _dot(ac, ac)
    d20, d21 = _dot(ap, ab), _dot(ap, ac)
    area = d00 * d11 - d01 * d01
    flat = area <= 1e-14 * d00 * d11
    safe = np.where(flat, 1.0, area)
    v, w = (d11 * d20 - d01 * d21) / safe, (d00 * d21 - d01 * d20) / safe
    at = np.stack((1.0 - v - w, v, w), axis=-1)
    distance = np.linalg.norm(np.einsum("...c,...cx->...x", at, triangles) - points, axis=-1)
    distance[flat | (at.min(axis=-1) < 0.0)] = np.inf
    for i, j in ((0, 1), (1, 2), (2, 0)):
        start, along = triangles[..., i, :], triangles[..., j, :] - triangles[..., i, :]
        length = np.maximum(_dot(along, along), 1e-300)
        t = np.clip(_dot(points - start, along) / length, 0.0, 1.0)
        on_edge = np.linalg.norm(start + t[..., None] * along - points, axis=-1)
        closer = on_edge < distance
        distance[closer] = on_edge[closer]
        at[closer] = 0.0
        at[..., i][closer] = 1.0 - t[closer]
        at[..., j][closer] = t[closer]
    return distance, at


def _dot(a: NDArray, b: NDArray) -> NDArray:
    return np.einsum("...x,...x->...", a, b)
