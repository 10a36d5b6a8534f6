# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects block the rays of which bake, each such set built into one Embree scene, once."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.rays import Occluders
from .mesh_reader import evaluated_mesh, read_positions, to_world
from .occluder_reader import read_occluders, rendered_objects
from .settings import BakeSettings


class OccluderScenes:
    """The occluders of every object of a bake, read from the evaluated scene when first asked for."""

    def __init__(self, context: bpy.types.Context, objects: list[bpy.types.Object], settings: BakeSettings):
        self._depsgraph = context.evaluated_depsgraph_get()
        self._settings = settings
        self._rendered = rendered_objects(context.view_layer)
        self._selected = {*context.selected_objects, *objects}
        self._ground = self._lowest(objects) if settings.use_ground_plane else None
        self._scenes: dict[frozenset[bpy.types.Object], tuple[Occluders, list[str]]] = {}

    def scene_for(self, obj: bpy.types.Object, warnings: list[str]) -> Occluders:
        """What blocks the rays of ``obj``, always with itself; appends to ``warnings`` what its artist should know."""
        if self._settings.occluders == "VISIBLE" and obj not in self._rendered:
            warnings.append("Disabled in renders: it was baked, and blocks no light on other objects")
        others = {"SELF": set(), "SELECTED": self._selected, "VISIBLE": self._rendered}[self._settings.occluders]
        owners = frozenset({obj, *others})
        if owners not in self._scenes:
            vertices, triangles, found = read_occluders(self._depsgraph, owners)
            self._scenes[owners] = Occluders(vertices, triangles, self._ground), found
        occluders, found = self._scenes[owners]
        warnings += found
        return occluders

    def _lowest(self, objects: list[bpy.types.Object]) -> float | None:
        """World z of the lowest finite vertex of ``objects``, or None."""
        heights = [np.empty(0)]
        for obj in objects:
            evaluated = obj.evaluated_get(self._depsgraph)
            with evaluated_mesh(evaluated) as mesh:
                if mesh is not None:
                    heights.append(to_world(read_positions(mesh), np.array(evaluated.matrix_world, np.float64))[:, 2])
        heights = np.concatenate(heights)
        heights = heights[np.isfinite(heights)]
        return float(heights.min()) if len(heights) else None
