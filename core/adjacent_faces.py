# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies beyond the border of a UV island: the face on the other side of the seam.

A texel outside of an island shows what the surface goes on with there, so that a lookup close to a seam finds the same
values from either side (Blender's margin type "Adjacent Faces").
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .scan_conversion import in_boxes, summed_area

# UV coordinates that differ by less are one place.
SAME_UV = 1e-6
# Part of the length of a seam, and of the way to the middle of its triangle.
HAIR = 1e-3
# At most so many points, in all, stand for seams: one a texel, or fewer.
MOST_POINTS = 2**23


class AdjacentFaces:
    """The seams of a layout, in texels.

    triangle_uv       (m, 3, 2) float, UV coordinates of the triangles' corners; those not finite have no seams
    vertex_triangles  (m, 3) int, their vertices
    covered           (h, w) bool, texels of the image that are inside of islands
    margin            how far from islands the places may be that :meth:`beyond` is asked for
    """

    def __init__(
        self, triangle_uv: NDArray, vertex_triangles: NDArray[np.integer], covered: NDArray[np.bool_], margin: int
    ):
        from scipy.spatial import cKDTree

        scale = np.array(covered.shape[::-1], np.float64)
        near, far = _seams(triangle_uv, vertex_triangles)
        # What is further from all texels that are not covered than these may be from an island is near none of them.
        reach = margin + 2.0
        wanted = _near_open(near * scale, covered, reach)
        # Each (s, 3 corners, 2): the two ends, and the corner that lies inside.
        near, far = near[wanted] * scale, far[wanted] * scale
        length = np.linalg.norm(near[:, 1] - near[:, 0], axis=1)
        first, last = _within(near[:, 0], near[:, 1], -reach, scale + reach)
        step = max(1.0, (np.maximum(last - first, 0.0) * length).sum() / MOST_POINTS)
        steps = np.ceil(length / step)
        start = np.floor(first * steps).astype(np.intp)
        count = np.where(first <= last, np.ceil(last * steps).astype(np.intp) - start + 1, 0)
        self._seam = np.repeat(np.arange(len(length)), count)
        along = np.arange(len(self._seam)) + np.repeat(start - (np.cumsum(count) - count), count)
        # Where seams meet, the points of each lie a hair away from there: of two, the one that is faced is nearer.
        along = np.clip(along / np.maximum(steps, 1.0)[self._seam], HAIR, 1.0 - HAIR)
        start, end = near[self._seam, 0], near[self._seam, 1]
        # A hair inwards: of two seams that meet at one place, the one that is faced.
        points = start + along[:, None] * (end - start)
        points += HAIR * (near.mean(axis=1)[self._seam] - points)
        # Built fast: it is asked for little more than the texels next to islands.
        self._tree = cKDTree(points, balanced_tree=False, compact_nodes=False) if len(points) else None
        self._across = _across(near, far)

    def nearest(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.intp]:
        """The seam (k,), or border of the surface itself, that is nearest to the places ``x``, ``y`` (k,), in texels,
        outside of islands; -1 where there is none at all."""
        if self._tree is None:
            return np.full(len(x), -1)
        return self._seam[self._tree.query(np.column_stack((x, y)))[1]]

    def beyond(self, seam: NDArray[np.intp], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where in the image (2, k), in texels, the surface goes on at the places ``x``, ``y`` (k,) beyond each
        ``seam`` (k,); NaN beyond borders of the surface itself."""
        if self._tree is None:
            return np.full((2, len(x)), np.nan)
        return np.stack([row[0].take(seam) * x + row[1].take(seam) * y + row[2].take(seam) for row in self._across])


def bilinear(
    images: Sequence[NDArray[np.float32]], covered: NDArray[np.bool_], at: NDArray[np.float64]
) -> tuple[list[NDArray[np.float32]], NDArray[np.float32]]:
    """Values (k, c) of each of ``images`` (h, w, c) at the places ``at`` (2, k), texels, between the centres of those
    texels that are ``covered`` (h, w); and how much of the weight (k,) these have."""
    height, width = covered.shape
    # What is further outside has no covered texel around it either.
    x, y = (np.clip(each, -1.0, size + 1.0) - 0.5 for each, size in zip(at, (width, height), strict=True))
    left, below = np.floor(x), np.floor(y)
    across, up = ((each - low).astype(np.float32) for each, low in ((x, left), (y, below)))
    left, below = left.astype(np.intp), below.astype(np.intp)
    pixels, covered = [image.reshape(width * height, -1) for image in images], covered.reshape(-1)
    total, values = np.zeros(len(x), np.float32), [np.zeros((len(x), each.shape[1]), np.float32) for each in pixels]
    for row, vertical in ((below, 1.0 - up), (below + 1, up)):
        for column, horizontal in ((left, 1.0 - across), (left + 1, across)):
            is_in = (column >= 0) & (column < width) & (row >= 0) & (row < height)
            texel = np.where(is_in, row * width + column, 0)
            weight = horizontal * vertical * (is_in & covered.take(texel))
            total += weight
            for value, image in zip(values, pixels, strict=True):
                value += weight[:, None] * image.take(texel, axis=0)
    for value in values:
        value /= np.maximum(total, np.finfo(np.float32).tiny)[:, None]
    return values, total


def _across(near: NDArray[np.float64], far: NDArray[np.float64]) -> NDArray[np.float64]:
    """For each seam, of which one side is ``near`` and the other ``far`` (s, 3 corners, 2), the map (2, 3, s) from
    (x, y, 1) beyond the one to what lies there inside of the other."""
    start, end, inside = np.moveaxis(near, 1, 0)
    along, out = _frame(start, end, inside, outwards=True)
    square = np.maximum(np.einsum("sx,sx->s", along, along), 1e-300)[:, None]
    far_start, far_end, far_inside = np.moveaxis(far, 1, 0)
    far_along, far_in = _frame(far_start, far_end, far_inside, outwards=False)
    turned = np.einsum("sa,sb->abs", far_along, along / square) + np.einsum("sa,sb->abs", far_in, out / square)
    moved = far_start.T - np.einsum("abs,sb->as", turned, start)
    return np.concatenate((turned, moved[:, None]), axis=1)


def _seams(triangle_uv: NDArray, vertex_triangles: NDArray[np.integer]) -> tuple[NDArray, NDArray]:
    """For each side of each seam, UVs (s, 3, 2) of the edge's ends and of its triangle's third corner, and the same of
    the triangle across; those of the borders of the surface, where there is none, are NaN."""
    uv, vertex = np.asarray(triangle_uv, np.float64).reshape(-1, 2), vertex_triangles.reshape(-1).astype(np.int64)

    def corners(edge: NDArray) -> NDArray:
        """The two ends (3, ...) of edges, which begin at corners (...), and the triangle's third corner. From the lower
        vertex to the higher, so that both sides agree."""
        following = _following(edge)
        turned = vertex[edge] > vertex[following]
        return np.stack((np.where(turned, following, edge), np.where(turned, edge, following), _following(following)))

    start, end, _ = corners(np.arange(len(vertex)))
    key = vertex[start] * (vertex.max(initial=0) + 1) + vertex[end]
    order = np.argsort(key, kind="stable")
    first = np.flatnonzero(np.diff(key[order], prepend=-1))
    count = np.diff(first, append=len(key))
    one, other = order[first[count == 2]], order[first[count == 2] + 1]
    gap = np.abs(uv.take(corners(one)[:2], axis=0) - uv.take(corners(other)[:2], axis=0)).max(axis=0)
    split = np.flatnonzero(np.maximum(gap[:, 0], gap[:, 1]) > SAME_UV)
    one, other = one[split], other[split]
    # An edge of one face has nothing across, and one of many has no one thing.
    border = order[np.repeat(count != 2, count)]
    near, far, alone = (uv.take(corners(edge).T, axis=0) for edge in (one, other, border))
    return np.concatenate((near, far, alone)), np.concatenate((far, near, np.full_like(alone, np.nan)))


def _near_open(near: NDArray, covered: NDArray[np.bool_], reach: float) -> NDArray[np.intp]:
    """Those of the seams ``near`` (s, 3 corners, 2) that are finite and whose ends' box, ``reach`` larger, holds a
    texel not ``covered``."""
    size = covered.shape[::-1]
    finite = np.flatnonzero(np.isfinite(near).all(axis=(1, 2)))
    one, other = near[finite, 0], near[finite, 1]
    low = np.clip(np.floor(np.minimum(one, other) - reach), 0, size).astype(np.intp)
    high = np.clip(np.ceil(np.maximum(one, other) + reach), 0, size).astype(np.intp)
    return finite[in_boxes(summed_area(~covered), low[:, 1], high[:, 1], low[:, 0], high[:, 0]) > 0]


def _within(start: NDArray, end: NDArray, low: float, high: NDArray) -> tuple[NDArray, NDArray]:
    """First and last part (s,), in [0, 1], of the ways from ``start`` to ``end`` (s, 2) that lie in the box from
    ``low`` to ``high`` (2,); the first is greater where none does.

    Liang and Barsky 1984, "A New Concept and Method for Line Clipping".
    """
    way = end - start
    still = np.abs(way) < 1e-300
    slope = np.where(still, 1.0, way)
    ends = (low - start) / slope, (high - start) / slope
    out = still & ((start < low) | (start > high))
    enter = np.where(still, np.where(out, np.inf, 0.0), np.minimum(*ends))
    leave = np.where(still, 1.0, np.maximum(*ends))
    first, last = np.maximum(enter[:, 0], enter[:, 1]), np.minimum(leave[:, 0], leave[:, 1])
    out = (first > 1.0) | (last < 0.0) | (first > last)
    return np.where(out, 1.0, np.maximum(first, 0.0)), np.where(out, 0.0, np.minimum(last, 1.0))


def _following(corner: NDArray) -> NDArray:
    """The next corner of the same triangle, of corners that are numbered through."""
    return np.where(corner % 3 == 2, corner - 2, corner + 1)


def _frame(start: NDArray, end: NDArray, inside: NDArray, outwards: bool) -> tuple[NDArray, NDArray]:
    """Vectors (k, 2) along an edge, and as long at right angles to it, away from the corner ``inside`` or to it."""
    along = end - start
    across = np.stack((-along[:, 1], along[:, 0]), axis=1)
    points_in = np.einsum("kx,kx->k", across, inside - start) > 0.0
    return along, np.where((points_in != outwards)[:, None], across, -across)
