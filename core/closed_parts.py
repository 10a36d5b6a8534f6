# SPDX-License-Identifier: GPL-3.0-or-later
"""Which triangles bound a volume: only of those can a point be inside."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def in_closed_parts(triangles: NDArray[np.integer], vertices: int) -> NDArray[np.bool_]:
    """Whether each of ``triangles`` (m, 3), which index so many ``vertices``, is of a part without a border: one whose
    edges all have an even number of triangles. Vertices that only lie at one place do not join."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    start, end = triangles.reshape(-1), np.roll(triangles, -1, axis=1).reshape(-1)
    ends = np.minimum(start, end), np.maximum(start, end)
    # One entry an edge, the number of its triangles.
    edges = coo_matrix((np.ones(len(start), np.int32), ends), (vertices, vertices)).tocsr()
    _, part = connected_components(edges, directed=False)
    has_border = np.zeros(vertices, bool)
    has_border[part[edges.indices[edges.data % 2 > 0]]] = True
    return ~has_border[part[triangles[:, 0]]]
