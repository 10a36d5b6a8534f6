# SPDX-License-Identifier: GPL-3.0-or-later
"""What a spherical cap of directions blocks: the integral that ambient occlusion fields look up in a table.

A cap about the axis Upsilon has the solid angle Omega = 2pi (1 - c), where c is the cosine of its half angle, and for a
surface of normal n, with k = n . Upsilon, blocks A = (1/pi) * integral over the cap of max(0, n . w) dw (Kontkanen and
Laine 2005, "Ambient Occlusion Fields", eq. 2). No table is needed: A has a closed form. So has what two caps share.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Least square of D below. What it adds to D cancels in A, to the third order; without it shaders would divide 0 by 0.
LEAST_SQUARE = 1e-9
# Keeps caps about one axis, and caps of no width, from dividing by 0: what is divided is then far above 1 or below -1,
# or both are one cap.
LEAST_SINE = 1e-4


def occlusion(solid_angle: ArrayLike, cosine: ArrayLike) -> NDArray[np.float64]:
    """A in [0, 1] of caps of ``solid_angle`` Omega in [0, 4pi] whose axes make ``cosine`` k with the normal.

    The shapes broadcast; float64. Values out of range count as the nearest in it.

    Exact, what the horizon clips included. A cap that the horizon does not cut gives (1 - c^2) k. Otherwise the
    integral runs along the edge of what is left of it, an arc of the cap's circle and one of the horizon (Lambert's
    formula; Snyder 1996, "Area Light Sources for Real-Time Graphics", has the same integral in another form). Written
    with atan2, one expression serves all caps: D = 0 is the case without a cut, and signs choose the branch.
    """
    c = 1.0 - np.clip(solid_angle, 0.0, 4.0 * np.pi) / (2.0 * np.pi)
    k = np.clip(cosine, -1.0, 1.0)
    D = np.sqrt(np.maximum(1.0 - c * c - k * k, LEAST_SQUARE))
    A = ((1.0 - c * c) * k * np.arctan2(D, -c * k) + np.arctan2(D, c) - c * D) / np.pi
    return np.clip(A, 0.0, 1.0)


def moment_of_cap(solid_angle: ArrayLike) -> NDArray[np.float64]:
    """|M| in [0, 1], M = (1/pi) * integral over the cap of w dw, of caps of ``solid_angle`` in [0, 4pi]: 1 - c^2."""
    half = np.asarray(solid_angle, np.float64) / (2.0 * np.pi)
    return half * (2.0 - half)


def cap_of_moment(moment: ArrayLike) -> NDArray[np.float64]:
    """Omega_M in [0, 2pi]: the solid angle of the cap, a hemisphere at most, that has |M| = ``moment`` in [0, 1]."""
    return 2.0 * np.pi * (1.0 - np.sqrt(1.0 - np.clip(moment, 0.0, 1.0)))


def covered_cap(solid_angle: ArrayLike, moment: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Part t in (0, 1] and solid angle of the larger cap that is blocked in part only, evenly: it keeps both Omega,
    ``solid_angle`` > 0, and |M|, ``moment``.

    t 2pi (1 - c) = Omega and t (1 - c^2) = |M| give c = 2pi |M| / Omega - 1. A |M| that no set of directions of that
    Omega reaches gives the plain cap. A = t * occlusion(larger, k): with the moment right it is exact wherever the
    horizon does not cut the object, whatever its shape.
    """
    solid_angle = np.asarray(solid_angle, np.float64)
    larger = np.maximum(4.0 * np.pi * (1.0 - np.pi * np.asarray(moment) / solid_angle), solid_angle)
    return solid_angle / larger, larger


def cap_overlap(first: ArrayLike, second: ArrayLike, between: ArrayLike) -> NDArray[np.float64]:
    """Solid angle that two caps share, over 2pi: in [0, 2]. The arguments are cosines in [-1, 1]: of their half angles
    and of the angle between their axes.

    Tovchigrechko and Vakser 2001, "How common is the funnel-like energy landscape in protein-protein interactions?",
    appendix. Its arc cosines, clamped, also hold for caps that lie within each other or apart, or cover the sphere.
    """
    first, second, between = (np.asarray(each, np.float64) for each in (first, second, between))
    sines = [np.maximum(np.sqrt(np.maximum(1.0 - each * each, 0.0)), LEAST_SINE) for each in (first, second, between)]

    def angle(opposite: NDArray, one: NDArray, other: NDArray, one_sine: NDArray, other_sine: NDArray) -> NDArray:
        """Of a spherical triangle, from the cosines of its sides."""
        return np.arccos(np.clip((opposite - one * other) / (one_sine * other_sine), -1.0, 1.0))

    apart = angle(between, first, second, sines[0], sines[1])
    in_first = angle(second, between, first, sines[2], sines[0])
    in_second = angle(first, between, second, sines[2], sines[1])
    return np.maximum(np.pi - apart - first * in_first - second * in_second, 0.0) / np.pi
