# SPDX-License-Identifier: GPL-3.0-or-later
"""Values for points that have none of their own, because they lie inside of something, from their neighbours.

Nobody sees such points, but what is interpolated between them and those outside is seen: a seam of black where two
meshes intersect.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def fill_texels(images: Sequence[NDArray], covered: NDArray[np.bool_], known: NDArray[np.bool_]) -> None:
    """Give the texels of each of ``images`` (h, w, c) that are ``covered`` (h, w) but not ``known``, in place, the
    value of the nearest known texel of their island. Islands without any stay."""
    from scipy.ndimage import distance_transform_edt, find_objects, label

    if not (covered & ~known).any():
        return
    island, count = label(covered, np.ones((3, 3)))
    wanted = np.bincount(island[covered & ~known], minlength=count + 1) > 0
    found = np.bincount(island[known], minlength=count + 1) > 0
    boxes = find_objects(island)
    for number in np.flatnonzero(wanted & found):
        box = boxes[number - 1]
        own = island[box] == number
        source = own & known[box]
        nearest = distance_transform_edt(~source, return_distances=False, return_indices=True)
        open_texels = np.nonzero(own & ~known[box])
        row, column = nearest[:, *open_texels]
        for image in images:
            part = image[box]
            part[open_texels] = part[row, column]


def fill_points(values: Sequence[NDArray], known: NDArray[np.bool_], edges: NDArray[np.integer]) -> None:
    """Give the points that are not ``known`` (n,) in each of ``values`` (n, c), in place, the mean of their neighbours
    along ``edges`` (e, 2): first those beside known ones, then those beside them. Parts without any known stay."""
    from scipy.sparse import csr_matrix

    known, count = known.copy(), len(known)
    ends = np.concatenate((edges, edges[:, ::-1]))
    ends = ends[~known[ends[:, 0]]]
    unknown, row = np.unique(ends[:, 0], return_inverse=True)
    links = csr_matrix((np.ones(len(ends)), (row.reshape(-1), ends[:, 1])), shape=(len(unknown), count))
    links.data[:] = 1.0  # an edge between two faces comes twice
    while len(unknown):
        beside = links @ known.astype(np.float64)
        now = beside > 0.0
        if not now.any():
            return
        for each in values:
            weighted = links[now] @ np.where(known[:, None], each, 0.0)
            each[unknown[now]] = weighted / beside[now, None]
        known[unknown[now]] = True
        links, unknown = links[~now], unknown[~now]


def straight_cones(f0: NDArray, alpha: NDArray, normals: NDArray) -> NDArray[np.float64]:
    """Bent directions (k, 3) along ``normals`` (k, 3), for points whose F0 and alpha (k,) are those of others: as long
    as it takes for F0 = 2 alpha b.n, which holds at every point that sees for itself."""
    length = np.divide(f0, 2.0 * alpha, out=np.zeros(len(f0)), where=alpha > 0.0)
    return np.minimum(length, 1.0)[:, None] * normals
