# SPDX-License-Identifier: GPL-3.0-or-later
"""The UV map that a texture bake fills: which one, and whether it can be baked into."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .report import BakeError

# How many tiles UDIM has side by side, and one above the other.
COLUMNS_ROWS = (10, 100)
# A triangle reaches into a tile by more than rounding.
REACH = 1e-5
UNWRAP = "unwrap it first (UV > Smart UV Project), or bake to vertices"


def uv_map_name(mesh: bpy.types.Mesh, wanted: str) -> str:
    """The UV map to bake into: ``wanted``, or the one active for rendering. Raises BakeError where there is none."""
    layers = mesh.uv_layers
    if not layers:
        raise BakeError(f"has no UV map: {UNWRAP}")
    if wanted and wanted not in layers:
        names = ", ".join(f"'{layer.name}'" for layer in layers)
        raise BakeError(f"has no UV map '{wanted}': choose one of {names}")
    return wanted or next(layer.name for layer in layers if layer.active_render)


def touched_tiles(triangle_uv: NDArray[np.float64]) -> list[int]:
    """The UDIM tiles that the boxes of triangles (m, 3, 2) reach into: tile 1001 + u + 10 v is the unit square at u in
    0 to 9 and v in 0 to 99."""
    low, high = _reach(triangle_uv)
    low, high = low + REACH, high - REACH
    some = np.isfinite(low).all(axis=1) & np.isfinite(high).all(axis=1) & (low < high).all(axis=1)
    boxes = np.floor(np.column_stack((low[some], high[some])))
    boxes = np.clip(boxes, -1, [*COLUMNS_ROWS, *COLUMNS_ROWS]).astype(np.intp)
    is_touched = np.zeros(COLUMNS_ROWS[::-1], bool)
    for u0, v0, u1, v1 in np.unique(boxes, axis=0):
        is_touched[max(v0, 0) : v1 + 1, max(u0, 0) : u1 + 1] = True
    v, u = np.nonzero(is_touched)
    return (1001 + u + 10 * v).tolist()


def in_tile(triangle_uv: NDArray, number: int) -> NDArray[np.bool_]:
    """Which of ``triangle_uv`` (m, 3, 2) have their middle in the UDIM tile of that ``number``: (m,)."""
    corner = (number - 1001) % 10, (number - 1001) // 10
    return (np.floor(triangle_uv.mean(axis=1)) == corner).all(axis=1)


def check_layout(triangle_uv: NDArray[np.float64], uv_map: str, has_tiles: bool = False) -> list[str]:
    """Warnings about ``triangle_uv`` (m, 3, 2), which may lie in UDIM tiles. Raises BakeError where no texel could be
    baked."""
    area = _area(triangle_uv)
    # Of the whole 0-1 tile; less than a texel of the largest image.
    if not np.nansum(np.where(np.isfinite(area), area, 0.0)) > 1e-10:
        raise BakeError(f"has no area in UV map '{uv_map}': {UNWRAP}")
    low, high = _reach(triangle_uv)
    end = np.array(COLUMNS_ROWS if has_tiles else (1, 1))
    where = "the UDIM tiles" if has_tiles else "the 0-1 tile"
    remedy = "pack its islands (UV > Pack Islands)" + ("" if has_tiles else ", or bake UDIM tiles")
    outside = ((high <= 0.0) | (low >= end)).any(axis=1)
    if outside.all():
        raise BakeError(f"lies outside {where} in UV map '{uv_map}': {remedy}")
    warnings = []
    crossing = ((low < -REACH) | (high > end + REACH)).any(axis=1)
    if crossing.any():
        warnings.append(
            f"UV map '{uv_map}': {crossing.mean():.1%} of the triangles reach out of {where}, where nothing is "
            f"baked: {remedy}"
        )
    return warnings


def overlaps(triangle_uv: NDArray[np.float64], covered: int, size: int, has_tiles: bool = False) -> bool:
    """Whether the triangles that lie in the 0-1 tile, or in UDIM tiles, have more area than the ``covered`` texels of
    images of ``size``.

    Those are all that the layout touches, so a layout without overlap never has.
    """
    end = COLUMNS_ROWS if has_tiles else (1, 1)
    low, high = _reach(triangle_uv)
    inside = (low >= 0.0).all(axis=1) & (high <= end).all(axis=1)
    return bool(_area(triangle_uv[inside]).sum() * size * size > 1.001 * covered)


def expected_texels(triangle_uv: NDArray[np.float64], size: int, tiles: int = 1) -> int:
    """About how many texels of so many ``tiles`` of ``size`` a layout covers that does not overlap itself."""
    return int(min(float(tiles), np.nansum(_area(triangle_uv))) * size * size)


def _area(triangle_uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area (m,) of triangles (m, 3, 2)."""
    (ax, bx, cx), (ay, by, cy) = np.ascontiguousarray(triangle_uv.T)
    return 0.5 * np.abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))


def _reach(triangle_uv: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest coordinates (m, 2) of triangles (m, 3, 2). Numpy's own min runs along three at a time."""
    a, b, c = np.moveaxis(triangle_uv, 1, 0)
    return np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
