# SPDX-License-Identifier: GPL-3.0-or-later
"""What several objects block together, from the fields of each.

For many, the product of what each leaves open: right on average, were they to hide each other by chance (the notes,
"Combine Occluders"). For few, their caps tell how much of one lies behind another.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .ao_field import AOField, Caps
from .cap import cap_overlap, occlusion


def product(occlusions: ArrayLike) -> NDArray[np.float64]:
    """A (k,) = 1 - the product of (1 - A_i), of ``occlusions`` (f, k)."""
    return 1.0 - np.prod(1.0 - np.asarray(occlusions, np.float64), axis=0)


def less_overlap(occlusions: ArrayLike, caps: Sequence[Caps], normals: ArrayLike) -> NDArray[np.float64]:
    """A (k,) in [0, 1] of a few objects together, for unit ``normals`` (k, 3). ``occlusions`` (f, k) are each one's A,
    from its field or by rays, and ``caps`` what its field says of where it stands; a pair of objects costs an overlap.

    Of two: A_1 + A_2 less what both block. Caps that alone block a_1 and a_2 and both block o tell how far that is from
    chance, A_1 A_2 o / (a_1 a_2), so what a fitted cap has too little or too much of does not count: near a wall as
    much as the overlap. Of more, each pair corrects the product by what it changes in its own:
    (1 - A_ij) / ((1 - A_i)(1 - A_j)).
    """
    occlusions, normals = np.asarray(occlusions, np.float64), np.asarray(normals, np.float64)
    alone = [each.occlusion(normals) for each in caps]
    open_part = np.prod(1.0 - occlusions, axis=0)
    for i, j in combinations(range(len(caps)), 2):
        A_i, A_j = occlusions[i], occlusions[j]
        both = _over(A_i * A_j * overlap(caps[i], caps[j], normals), alone[i] * alone[j])
        both = np.minimum(both, np.minimum(A_i, A_j))
        pair = np.clip(1.0 - A_i - A_j + both, 0.0, 1.0)
        open_part *= _over(pair, (1.0 - A_i) * (1.0 - A_j))
    return np.clip(1.0 - open_part, 0.0, 1.0)


def _over(dividend: NDArray, divisor: NDArray) -> NDArray[np.float64]:
    """Their ratio; 0 where ``divisor`` is not above 0."""
    return np.divide(dividend, divisor, out=np.zeros_like(divisor), where=divisor > 0.0)


def overlap(first: Caps, second: Caps, normals: NDArray) -> NDArray[np.float64]:
    """What two caps both block, (k,), for unit ``normals`` (k, 3).

    Their common region counts as a cap of as large a solid angle, in its middle (Oat and Sander 2007, "Ambient Aperture
    Lighting"; here that is exact). What of caps is blocked in part is taken as scattered over them by chance.
    """
    cosines = [1.0 - each.solid_angle / (2.0 * np.pi) for each in (first, second)]
    between = np.clip(np.einsum("kx,kx->k", first.direction, second.direction), -1.0, 1.0)
    solid_angle = 2.0 * np.pi * cap_overlap(*cosines, between)
    # The common region's ends on the way from the first axis to the second.
    angles, apart = np.arccos(cosines), np.arccos(between)
    start, end = np.maximum(-angles[0], apart - angles[1]), np.minimum(angles[0], apart + angles[1])
    way = 0.5 * (start + end)
    sideways = second.direction - between[:, None] * first.direction
    sideways /= np.maximum(np.linalg.norm(sideways, axis=1, keepdims=True), 1e-9)
    middle = np.cos(way)[:, None] * first.direction + np.sin(way)[:, None] * sideways
    both = occlusion(solid_angle, np.einsum("kx,kx->k", normals, middle))
    return first.part * second.part * both


def corrected(fields: Sequence[AOField], positions: ArrayLike, normals: ArrayLike) -> NDArray[np.float64]:
    """A (k,) of a few ``fields`` together by :func:`less_overlap`, at ``positions`` (k, 3) for unit ``normals`` (k, 3),
    in the space of all. Within a hull, and where a field fades, caps still tell the share that both block."""
    occlusions = [field.occlusion(positions, normals) for field in fields]
    return less_overlap(occlusions, [field.caps(positions) for field in fields], normals)
