# SPDX-License-Identifier: GPL-3.0-or-later
"""What a spherical cap of directions blocks: the integral that ambient occlusion fields look up in a table.

A cap about the axis Upsilon has the solid angle Omega = 2pi (1 - c), where c is the cosine of its half angle, and for a
surface of normal n, with k = n . Upsilon, blocks A = (1/pi) * integral over the cap of max(0, n . w) dw (Kontkanen and
Laine 2005, "Ambient Occlusion Fields", eq. 2). No table is needed: A has a closed form.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Least square of D below. What it adds to D cancels in A, to the third order; without it shaders would divide 0 by 0.
LEAST_SQUARE = 1e-9


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
