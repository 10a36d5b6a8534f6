# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of many bounces between endless strips, without a ray: truth for simulations of it."""

import numpy as np

from core.surface import unit

from .shapes import quad

LENGTH = 60.0  # of what is endless: what its ends let in is below 1 / LENGTH^2


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def strip(start, end):
    """An endless strip over the segment from ``start`` to ``end`` in the xz plane, its front on the segment's left."""
    (x0, z0), (x1, z1) = start, end
    half = 0.5 * LENGTH
    return quad((x0, half, z0), (x0, -half, z0), (x1, -half, z1), (x1, half, z1))


class EndlessStrips:
    """The same bounces by an integral equation over the segments' cross-section, for strips that see each other wholly.

    What a point sees of an endless strip is (sin b - sin a) / 2, with the angles of its edges from the point's normal:
    the exact view factor, so only light within each of the ``pieces`` of a segment is taken to be even.
    """

    def __init__(self, segments, pieces=200):
        ends = np.asarray(segments, float)
        step = np.linspace(0.0, 1.0, pieces + 1)[:, None]
        edges = np.stack([start + step * (end - start) for start, end in ends])
        self.segments = ends
        self.middle = 0.5 * (edges[:, 1:] + edges[:, :-1])
        along = unit(np.pad(ends[:, 1] - ends[:, 0], ((0, 0), (0, 1))))[:, :2]
        factor = np.zeros((len(ends), pieces, len(ends), pieces))
        for own in range(len(ends)):
            for other in range(len(ends)):
                if own != other:
                    to = edges[other][None] - self.middle[own][:, None]
                    sine = (to @ along[own]) / np.sqrt(np.square(to).sum(axis=-1))
                    factor[own, :, other] = 0.5 * np.abs(np.diff(sine, axis=1))
        self.factor = factor.reshape(len(ends) * pieces, -1)

    def bounces(self, count):
        """(count + 1, segments, pieces)."""
        light = [1.0 - self.factor.sum(axis=1)]
        for _ in range(count):
            light.append(self.factor @ light[-1])
        return np.array(light).reshape(count + 1, *self.middle.shape[:2])

    def at(self, segment, positions, count):
        """Bounces (count + 1, k) at ``positions`` (k, 3) on a segment, and which of them lie there, (k,)."""
        (start, end), xz = self.segments[segment], positions[:, (0, 2)]
        along = (end - start) / np.linalg.norm(end - start)
        off = xz - start
        on = np.abs(off[:, 0] * along[1] - off[:, 1] * along[0]) < 1e-6
        on &= np.abs(positions[:, 1]) < 0.1 * LENGTH
        distance, places = off @ along, (self.middle[segment] - start) @ along
        light = self.bounces(count)[:, segment]
        return np.stack([np.interp(distance[on], places, each) for each in light]), on
