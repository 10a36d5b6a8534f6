# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance through a cone: spherical-harmonic light against a cosine lobe that is cut off outside a cone.

A cone of half-angle theta about the axis d, c = cos(theta) >= 0, shows light to a surface with normal n:

    E = integral over w . d > c of L(w) (n . w) dw

**About the normal** (d = n) the lobe is zonal and each band is multiplied by 2pi * integral from c to 1 of z P_l(z) dz:

    l = 0   2pi * [z^2/2]                  = pi (1 - c^2)
    l = 1   2pi * [z^3/3]                  = (2pi/3) (1 - c^3)
    l = 2   2pi * [3z^4/8 - z^2/4]         = (pi/4) (1 - c^2) (1 + 3c^2)

At c = 0 these are the cosine lobe's pi, 2pi/3, pi/4 (Ramamoorthi and Hanrahan 2001, eq. (8)).

**About another axis** the lobe is not zonal, but L(w) (n . w) is a polynomial of the direction, and moments of a cone
are closed forms: with S_k = 2pi * integral from c to 1 of z^k dz and sums over the ways to choose indices,

    integral of w       = S_1 d
    integral of w w     = (S_0 - S_2)/2 I  +  (3 S_2 - S_0)/2 d d
    integral of w w w   = (S_1 - S_3)/2 (sum of I d)  +  (5 S_3 - 3 S_1)/2 d d d

by symmetry about d; the factors follow from the traces and from the components along d. Divided by S_1 = pi (1 - c^2),
the share of a cone that lies wholly above the horizon,

    E/S_1 = mean k  +  (1-c)(2+c) / (3 (1+c)) n . slope  +  c k (d . slope)
            +  (1-c^2)/2 n . curve d  +  (5c^2-1)/4 k (d . curve d)

with k = n . d and the polynomial of :mod:`.spherical_harmonics`; d = n gives the bands above. It is exact where the
cone does not dip below the surface's horizon (angle of d and n at most 90 degrees - theta). Where it does, (n . w) is
negative there and the formula subtracts that part. That is wanted: a cone made from moments that were measured over
what a point sees, which lies above its horizon, then keeps those (:mod:`.bent_cone`).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .spherical_harmonics import polynomial


def zonal(cosine: ArrayLike) -> NDArray[np.float64]:
    """Factors (3, ...) of the bands l = 0, 1, 2 for a cosine lobe about the normal, cut off outside the cone about it
    whose half-angle has this ``cosine`` (...) in [0, 1]; lower ones count as 0."""
    c = np.clip(np.asarray(cosine, np.float64), 0.0, 1.0)
    square = c * c
    return np.pi * np.stack(
        (1.0 - square, 2.0 / 3.0 * (1.0 - square * c), 0.25 * (1.0 - square) * (1.0 + 3.0 * square))
    )


def mean_light(coefficients: ArrayLike, normals: ArrayLike, axes: ArrayLike, cosines: ArrayLike) -> NDArray[np.float64]:
    """E/S_1 (n, channels), as above: k for radiance 1 all around.

    coefficients  (9, channels) of the light
    normals, axes (n, 3) unit vectors
    cosines       (n,) cosines c of the cones' half-angles, in [0, 1]
    """
    normals, axes, c = (np.asarray(each, np.float64) for each in (normals, axes, cosines))
    light = polynomial(coefficients)
    k = (normals * axes).sum(axis=-1)
    along_normal = np.einsum("ni,ij...,nj->n...", normals, light.curve, axes)
    along_axis = np.einsum("ni,ij...,nj->n...", axes, light.curve, axes)

    def each(factor: NDArray) -> NDArray[np.float64]:
        return factor[:, None]

    return (
        each(k) * light.mean
        + each((1.0 - c) * (2.0 + c) / (3.0 * (1.0 + c))) * (normals @ light.slope)
        + each(c * k) * (axes @ light.slope)
        + each((1.0 - c * c) / 2.0) * along_normal
        + each((5.0 * c * c - 1.0) / 4.0 * k) * along_axis
    )
