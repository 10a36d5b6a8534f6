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
from .cap import occlusion


def product(occlusions: ArrayLike) -> NDArray[np.float64]:
    """A (k,) = 1 - the product of (1 - A_i), of ``occlusions`` (f, k)."""
    return 1.0 - np.prod(1.0 - np.asarray(occlusions, np.float64), axis=0)


def overlap(first: Caps, second: Caps, normals: NDArray) -> NDArray[np.float64]:
    """What two caps both block, (k,), for unit ``normals`` (k, 3).

    Their common region counts as a cap of as large a solid angle, in its middle (Oat and Sander 2007, "Ambient Aperture
    Lighting"). What of caps is blocked in part is taken as scattered over them by chance.
    """
    angles = [np.arccos(1.0 - each.solid_angle / (2.0 * np.pi)) for each in (first, second)]
    cosine = np.clip(np.einsum("kx,kx->k", first.direction, second.direction), -1.0, 1.0)
    apart = np.arccos(cosine)
    solid_angle = common_solid_angle(*angles, apart)
    # The common region's ends on the way from the first axis to the second.
    start, end = np.maximum(-angles[0], apart - angles[1]), np.minimum(angles[0], apart + angles[1])
    way = 0.5 * (start + end)
    sideways = second.direction - cosine[:, None] * first.direction
    sideways /= np.maximum(np.linalg.norm(sideways, axis=1, keepdims=True), 1e-9)
    middle = np.cos(way)[:, None] * first.direction + np.sin(way)[:, None] * sideways
    both = occlusion(solid_angle, np.einsum("kx,kx->k", normals, middle))
    return first.part * second.part * both


def common_solid_angle(first: NDArray, second: NDArray, apart: NDArray) -> NDArray[np.float64]:
    """What two caps of half angles ``first`` and ``second`` have in common, their axes ``apart``, all in [0, pi].

    Exact, from the two circles' common points (Oat and Sander 2007; the smoothstep that they put in its place in
    shaders errs by several times as much as all else here).
    """
    a, b, d = np.broadcast_arrays(first, second, apart)
    smaller = 2.0 * np.pi * (1.0 - np.cos(np.minimum(a, b)))
    # Where they cover the sphere between them, their circles do not cross and their areas overlap by the rest.
    around = np.where(a + b + d > 2.0 * np.pi, 2.0 * np.pi * (1.0 - np.cos(a) + 1.0 - np.cos(b)) - 4.0 * np.pi, smaller)
    crossing = (d > np.abs(a - b)) & (d < a + b) & (a + b + d < 2.0 * np.pi)
    a, b, d = (np.where(crossing, each, 0.5 * np.pi) for each in (a, b, d))
    cos_a, cos_b, cos_d = np.cos(a), np.cos(b), np.cos(d)
    sin_a, sin_b, sin_d = np.sin(a), np.sin(b), np.sin(d)
    at_crossing, at_first, at_second = (
        np.arccos(np.clip(each, -1.0, 1.0))
        for each in (
            (cos_d - cos_a * cos_b) / (sin_a * sin_b),
            (cos_b - cos_d * cos_a) / (sin_d * sin_a),
            (cos_a - cos_d * cos_b) / (sin_d * sin_b),
        )
    )
    lens = 2.0 * (np.pi - at_crossing - cos_a * at_first - cos_b * at_second)
    return np.where(crossing, lens, np.where(apart >= first + second, 0.0, around))


def corrected(fields: Sequence[AOField], positions: ArrayLike, normals: ArrayLike) -> NDArray[np.float64]:
    """A (k,) of a few ``fields`` together, at ``positions`` (k, 3) for unit ``normals`` (k, 3), in the space of all.

    Of two: A_1 + A_2 less what both block. Of more, each pair corrects the product by what it changes in its own:
    (1 - A_ij) / ((1 - A_i)(1 - A_j)), which leaves A within [0, 1] and costs a pair each. Within a hull, and where a
    field fades, the overlap is that of caps as faint.
    """
    normals = np.asarray(normals, np.float64)
    occlusions = [field.occlusion(positions, normals) for field in fields]
    caps = [field.caps(positions) for field in fields]
    alone = [each.occlusion(normals) for each in caps]
    open_part = np.prod([1.0 - A for A in occlusions], axis=0)
    for i, j in combinations(range(len(fields)), 2):
        faint = [np.divide(occlusions[e], alone[e], out=np.zeros_like(open_part), where=alone[e] > 0.0) for e in (i, j)]
        both = overlap(caps[i], caps[j], normals) * np.minimum(faint[0] * faint[1], 1.0)
        both = np.clip(both, 0.0, np.minimum(occlusions[i], occlusions[j]))
        apart = (1.0 - occlusions[i]) * (1.0 - occlusions[j])
        pair = np.clip(1.0 - occlusions[i] - occlusions[j] + both, 0.0, 1.0)
        open_part *= np.divide(pair, apart, out=np.zeros_like(apart), where=apart > 0.0)
    return np.clip(1.0 - open_part, 0.0, 1.0)
