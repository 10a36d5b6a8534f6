# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of many bounces between points that link to what their rays see.

Under a white sky, with albedo 1, the irradiance of bounce n at a point is what its blocked rays see of bounce n - 1:

    F_0(x) = (1/pi) * integral of V cos(theta) dw
    F_n(x) = (1/pi) * integral of (1 - V) F_{n-1}(y(x, w)) cos(theta) dw

(Patapom, "Improved Ambient Occlusion", eq. 8; the rendering equation's Neumann series, Kajiya 1986). Over n points with
R rays each the second integral is a sum, F_n = L F_{n-1}, where row i of the sparse L holds the cosine weights of the
rays of point i at the points that they end on. F_0 and L's row sum to 1, so all bounces together do, unless light is
caught where no ray finds the sky.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .multibounce import MOST_TAIL, TAIL_ALBEDO

# Of a sum, where nearly all light stays in the scene.
MOST_BOUNCES = 1000


class Links:
    """The matrix L above. Memory: 12 bytes a link that is not -1, and 12 more while it is made.

    target  (n, R) int, the point that each ray ends on; -1: the sky, or nothing known
    weight  (n, R) float64, what light from there adds to the irradiance
    """

    def __init__(self, target: NDArray[np.integer], weight: NDArray[np.float64]):
        from scipy.sparse import csr_matrix

        linked = target >= 0
        starts = np.concatenate(([0], np.cumsum(linked.sum(axis=1))))
        self._matrix = csr_matrix((weight[linked], target[linked], starts), shape=(len(target), len(target)))

    def __matmul__(self, light: NDArray[np.float64]) -> NDArray[np.float64]:
        """The next bounce (n,) or (n, k) of ``light``, at albedo 1."""
        return self._matrix @ light

    def series(self, direct: NDArray[np.float64], bounces: int) -> NDArray[np.float64]:
        """F_0 = ``direct`` (n,) and the bounces after it, (bounces + 1, n)."""
        result = np.empty((bounces + 1, len(direct)))
        result[0] = direct
        for order in range(bounces):
            result[order + 1] = self @ result[order]
        return result

    def total(self, direct: NDArray[np.float64], albedo: float | NDArray, tolerance: float = 2.0**-14) -> NDArray:
        """Light of all bounces, the fixed point of E = direct + L (albedo E); as ``direct``, (n,) or (n, k).

        albedo     in [0, 1], one number or as ``direct``
        tolerance  about the most that may be missing of any value: bounces are added until the rest, were each to be
                   to the next as this one is to the last, is less; MOST_BOUNCES at most
        """
        light = np.array(direct, np.float64)
        bounce, brightest = light, light.max(initial=0.0)
        for _ in range(MOST_BOUNCES):
            bounce = self @ (albedo * bounce)
            light += bounce
            before, brightest = brightest, bounce.max(initial=0.0)
            if brightest**2 <= tolerance * (before - brightest):
                break
        return light


def decay(
    f0: NDArray[np.float64], f1: NDArray[np.float64], f2: NDArray[np.float64], total: NDArray[np.float64]
) -> NDArray[np.float64]:
    """T (n,) in [0, MOST_TAIL]: with it F0 + rho F1 + rho^2 F2 / (1 - rho T) is the ``total`` light at rho =
    TAIL_ALBEDO."""
    rho = TAIL_ALBEDO
    rest = (total - f0 - rho * f1) / rho**2
    ratio = np.divide(f2, rest, out=np.ones_like(rest), where=rest > 0.0)
    return np.clip((1.0 - ratio) / rho, 0.0, MOST_TAIL)
