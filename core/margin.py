# SPDX-License-Identifier: GPL-3.0-or-later
"""The margin around UV islands: texels outside take the value of the nearest texel inside, or of the face across the
seam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .adjacent_faces import AdjacentFaces, bilinear
from .workers import Workers

ROWS_PER_PART = 128  # of the image, what a thread works on at least
# Of a lookup across a seam so much must fall on texels that are covered.
ENOUGH = 0.5


def extend_margin(
    images: Sequence[NDArray],
    covered: NDArray[np.bool_],
    margin: int,
    threads: int | None = None,
    faces: AdjacentFaces | None = None,
) -> None:
    """Fill each of ``images`` (h, w, c) in place up to ``margin`` texels past ``covered`` (h, w): Blender's "Extend".
    With ``faces`` it is "Adjacent Faces", where there is one. ``threads``, default one a core, change nothing of the
    result."""
    from scipy.ndimage import distance_transform_edt

    if not images or margin <= 0 or covered.all() or not covered.any():
        return
    rows = max(ROWS_PER_PART, 2 * margin)

    def extend(first: int) -> None:
        # The nearest texel of a row within the margin lies among these rows.
        last, low = min(first + rows, len(covered)), max(first - margin, 0)
        near = covered[low : last + margin]
        inner = slice(first - low, last - low)
        if near[inner].all() or not near.any():
            return
        nearest = distance_transform_edt(~near, return_distances=False, return_indices=True)
        row, column = np.nonzero(~near[inner])
        from_row, from_column = nearest[:, inner][:, row, column]
        away = np.square(from_row - (row + inner.start)) + np.square(from_column - column)
        rim = away <= margin * margin
        row, column, from_row, from_column = row[rim] + first, column[rim], from_row[rim] + low, from_column[rim]
        for image in images:
            image[row, column] = image[from_row, from_column]
        if faces is not None:
            values, share = bilinear(images, covered, faces.beyond(column + 0.5, row + 0.5))
            found = np.flatnonzero(share > ENOUGH)
            for image, value in zip(images, values, strict=True):
                image[row[found], column[found]] = value[found]

    with Workers(threads) as workers:
        workers.map(extend, range(0, len(covered), rows))
