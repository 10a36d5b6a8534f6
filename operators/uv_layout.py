# SPDX-License-Identifier: GPL-3.0-or-later
"""The UV map that a texture bake fills: which one, and whether it can be baked into."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .report import BakeError

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


def check_layout(triangle_uv: NDArray[np.float64], uv_map: str) -> list[str]:
    """Warnings about ``triangle_uv`` (m, 3, 2). Raises BakeError where no texel could be baked."""
    area = _area(triangle_uv)
    # Of the whole 0-1 tile; less than a texel of the largest image.
    if not np.nansum(np.where(np.isfinite(area), area, 0.0)) > 1e-10:
        raise BakeError(f"has no area in UV map '{uv_map}': {UNWRAP}")
    low, high = triangle_uv.min(axis=1), triangle_uv.max(axis=1)
    outside = ((high <= 0.0) | (low >= 1.0)).any(axis=1)
    if outside.all():
        raise BakeError(f"lies outside the 0-1 tile in UV map '{uv_map}': pack its islands (UV > Pack Islands)")
    warnings = []
    crossing = ((low < -1e-5) | (high > 1.0 + 1e-5)).any(axis=1)
    if crossing.any():
        warnings.append(
            f"UV map '{uv_map}': {crossing.mean():.1%} of the triangles reach out of the 0-1 tile, where nothing is "
            "baked: pack its islands (UV > Pack Islands)"
        )
    return warnings


def overlaps(triangle_uv: NDArray[np.float64], covered: int, size: int) -> bool:
    """Whether the triangles that lie in the 0-1 tile have more area than the ``covered`` texels of a ``size`` image.

    Those are all that the layout touches, so a layout without overlap never has.
    """
    inside = (triangle_uv.min(axis=(1, 2)) >= 0.0) & (triangle_uv.max(axis=(1, 2)) <= 1.0)
    return bool(_area(triangle_uv[inside]).sum() * size * size > 1.001 * covered)


def expected_texels(triangle_uv: NDArray[np.float64], size: int) -> int:
    """About how many texels of a ``size`` image a layout covers that does not overlap itself."""
    return int(min(1.0, np.nansum(_area(triangle_uv))) * size * size)


def _area(triangle_uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Area (m,) of triangles (m, 3, 2)."""
    a, b, c = np.moveaxis(triangle_uv, 1, 0)
    return 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
