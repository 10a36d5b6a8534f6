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
        rest = np.ones(len(row), bool)
        if faces is not None and len(row):
            seam = _nearest_seam(faces, row, column, from_row, from_column, covered.shape[1])
            at = faces.beyond(seam, column + 0.5, row + 0.5)
            goes_on = np.flatnonzero(np.isfinite(at).all(axis=0))
            values, share = bilinear(images, covered, at[:, goes_on])
            found = share > ENOUGH
            goes_on = goes_on[found]
            rest[goes_on] = False
            for image, value in zip(images, values, strict=True):
                image[row[goes_on], column[goes_on]] = value[found]
        row, column, from_row, from_column = row[rest], column[rest], from_row[rest], from_column[rest]
        for image in images:
            image[row, column] = image[from_row, from_column]

    with Workers(threads) as workers:
        workers.map(extend, range(0, len(covered), rows))


def _nearest_seam(
    faces: AdjacentFaces, row: NDArray, column: NDArray, from_row: NDArray, from_column: NDArray, width: int
) -> NDArray[np.intp]:
    """The seam (k,) that texels (k,) of an image lie beyond, with the nearest covered one to each given. The nearest
    seam of those next to islands, which filters read; those further out take that of the one that lies between."""
    up, right = row - from_row, column - from_column
    half = 0.5 * np.maximum(np.abs(up), np.abs(right))
    beside = (from_row + np.sign(up) * (np.abs(up) >= half)) * width
    beside += from_column + np.sign(right) * (np.abs(right) >= half)
    lowest = beside.min()
    is_asked = np.zeros(beside.max() - lowest + 1, bool)
    is_asked[beside - lowest] = True
    asked = np.flatnonzero(is_asked)
    number = np.empty(len(is_asked), np.intp)
    number[asked] = np.arange(len(asked))
    at = np.divmod(asked + lowest, width)
    return faces.nearest(at[1] + 0.5, at[0] + 0.5)[number[beside - lowest]]
