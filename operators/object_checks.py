# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether an object can be baked, said before any ray is traced. Messages go on from "Object 'name' "."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from .mesh_reader import linear_inverse, read_positions
from .report import BakeError


def check_object(obj: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> None:
    """Raises BakeError where a bake of ``obj`` has nothing to work on or nowhere to go."""
    if obj.type != "MESH":
        raise BakeError("is not a mesh: convert it first (Object > Convert > Mesh)")
    if obj.library is not None or obj.data.library is not None:
        raise BakeError(
            "is linked from a library, so nothing can be stored on it: make it local (Object > Relations > Make Local)"
        )
    if obj.mode == "EDIT":
        raise BakeError("is in Edit Mode: leave it first")
    if not obj.data.polygons:
        raise BakeError("has no faces: add some, or leave it out of the selection")
    if not obj.visible_get(view_layer=view_layer):
        raise BakeError("is hidden in the viewport: show it first")


def check_evaluated(mesh: bpy.types.Mesh | None, matrix: NDArray) -> None:
    """Raises BakeError where the modified ``mesh``, placed by ``matrix``, is no surface to bake on."""
    if mesh is None or not mesh.polygons:
        raise BakeError("has no faces left after its modifiers: change or turn off the one that removes them")
    if not np.isfinite(matrix).all():
        raise BakeError("has a transform that is not finite: reset its location, rotation and scale")
    linear_inverse(matrix)
    bad = int((~np.isfinite(read_positions(mesh)).all(axis=1)).sum())
    if bad:
        plural = "vertex" if bad == 1 else "vertices"
        raise BakeError(
            f"has {bad} {plural} whose coordinates are not finite numbers: delete or move them, also in shape keys"
        )
