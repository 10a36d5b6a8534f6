# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of what a surface reflects is sky: the overlap of two cones, what it sees and what it reflects.

Cones on cones after Oat and Sander 2007, "Ambient Aperture Lighting", whose smoothstep stands for the area that two
caps share; here that area is exact. The reflection's cone after Jimenez et al. 2016, "Practical Realtime Strategies for
Accurate Indirect Occlusion", cos(half-angle) = 10^(-r^2), with r the alpha of GGX: the square of Blender's Roughness.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Keeps cones about one axis, and cones of no width, from dividing by 0: what is divided is then far above 1 or below
# -1, or both are one cone.
LEAST_SINE = 1e-4
# A mirror's cone has no area to share: one of 2.6 degrees stands for it, which float32 still resolves.
MOST_LOBE = 0.999


def lobe_cosine(roughness: ArrayLike) -> NDArray[np.float64]:
    """Cosine of the half-angle of the cone that stands for the GGX lobe of ``roughness`` in [0, 1], as in Blender."""
    return np.minimum(10.0 ** -(np.clip(np.asarray(roughness, np.float64), 0.0, 1.0) ** 4), MOST_LOBE)


def cap_overlap(first: ArrayLike, second: ArrayLike, between: ArrayLike) -> NDArray[np.float64]:
    """Solid angle that two caps share, over 2pi. The arguments are cosines: of their half-angles, which are at most 90
    degrees, and of the angle between their axes.

    Tovchigrechko and Vakser 2001, "How common is the funnel-like energy landscape in protein-protein interactions?",
    appendix. Its arc cosines, clamped, also hold for caps that lie within each other or apart.
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
