# SPDX-License-Identifier: GPL-3.0-or-later
"""The margin around UV islands: texels outside take the value of the nearest texel inside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def extend_margin(images: Sequence[NDArray], covered: NDArray[np.bool_], margin: int) -> None:
    """Fill each of ``images`` (h, w, c) in place up to ``margin`` texels past ``covered`` (h, w), Blender's
    "Extend"."""
    from scipy.ndimage import distance_transform_edt

    if margin <= 0 or covered.all() or not covered.any():
        return
    distance, (row, column) = distance_transform_edt(~covered, return_indices=True)
    rim = (distance > 0) & (distance <= margin)
    for image in images:
        image[rim] = image[row[rim], column[rim]]
