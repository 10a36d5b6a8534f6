# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what a surface reflects is sky: the overlap of two cones, what it sees and what it reflects.

Cones on cones after Oat and Sander 2007, "Ambient Aperture Lighting", whose smoothstep stands for the area that two
caps share; here that area is exact. The reflection's cone after Jimenez et al. 2016, "Practical Realtime Strategies for
Accurate Indirect Occlusion", cos(half-angle) = 10^(-r^2), with r the alpha of GGX: the square of Blender's Roughness.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .cap import cap_overlap

# A mirror's cone has no area to share: one of 2.6 degrees stands for it, which float32 still resolves.
MOST_LOBE = 0.999


def lobe_cosine(roughness: ArrayLike) -> NDArray[np.float64]:
    """Cosine of the half-angle of the cone that stands for the GGX lobe of ``roughness`` in [0, 1], as in Blender."""
    return np.minimum(10.0 ** -(np.clip(np.asarray(roughness, np.float64), 0.0, 1.0) ** 4), MOST_LOBE)


def specular_occlusion(
    axes: ArrayLike, alpha: ArrayLike, normals: ArrayLike, views: ArrayLike, roughness: ArrayLike
) -> NDArray[np.float64]:
    """Share (n,) in [0, 1] of the reflection's cone above the horizon that lies in the bent cone; 1 on open surfaces.

    axes       (n, 3) unit, the bent cones'
    alpha      (n,) uniform visibility in [0, 1]: the cone of that solid angle has the half-angle arccos(1 - alpha)
    normals    (n, 3) unit
    views      (n, 3) unit, towards the eye
    roughness  (n,) in [0, 1]
    """
    axes, normals, views = (np.asarray(each, np.float64) for each in (axes, normals, views))
    alpha = np.clip(np.asarray(alpha, np.float64), 0.0, 1.0)
    reflection = 2.0 * (normals * views).sum(axis=-1, keepdims=True) * normals - views
    lobe = lobe_cosine(roughness)
    seen = cap_overlap(1.0 - alpha, lobe, (axes * reflection).sum(axis=-1))
    above = cap_overlap(np.zeros_like(lobe), lobe, (normals * reflection).sum(axis=-1))
    return np.minimum(np.divide(seen, above, out=np.zeros_like(seen), where=above > 0.0), 1.0)
