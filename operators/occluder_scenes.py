# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects block the rays of which bake, each such set built into one Embree scene for all that share it."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from typing import Protocol

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.albedo import Albedo
from ..core.rays import Occluders
from ..core.workers import calling, in_thread
from .base_color import read_albedo
from .mesh_reader import evaluated_mesh, read_corner_vertices, read_positions, to_world
from .occluder_cache import occluders_of
from .occluder_reader import read_occluders, rendered_objects

# An object further than this many of its own sizes from the middle of the scene gets a scene centred on itself: there
# single precision, and the ray offset with it, would become coarser than a few ten-thousandths of the object.
FAR = 300.0


class OccluderSettings(Protocol):
    """The settings that say who blocks light, of a bake or of a fit."""

    occluders: str
    use_ground_plane: bool


class OccluderScenes:
    """The occluders of every object of a bake, read from the evaluated scene when first asked for. Which objects these
    are is settled at the start.

    What an object gets depends on nothing that is baked beside it, but for the ground plane.
    """

    def __init__(
        self,
        context: bpy.types.Context,
        objects: list[bpy.types.Object],
        selected: Collection[bpy.types.Object],
        settings: OccluderSettings,
        sources: Mapping[bpy.types.Object, Collection[bpy.types.Object]] | None = None,
        *,
        colours: bool = False,
        own: Mapping[bpy.types.Object, OccluderSettings] | None = None,
    ):
        """``colours``: read the base colours of what blocks light, too, for :meth:`albedo`; ``own`` settings of those
        objects that do not follow ``settings``."""
        self._colours = colours
        self._own = own or {}
        self._context = context
        self._settings = settings
        self._rendered = rendered_objects(context.view_layer)
        # Cycles' ray visibility, which its own AO follows too.
        self._shadowing = {obj for obj in self._rendered if obj.visible_shadow}
        self._selected = {*selected, *objects}
        self._bounds: dict[bpy.types.Object, tuple[NDArray[np.float64], NDArray[np.float64]]] = {}
        # With Selected to Active, what blocks light for an object are those that are baked onto it, never such an
        # object itself; with several, the partners of the others do not either, unless all that is selected should.
        self._sources = {obj: frozenset(each) for obj, each in (sources or {}).items()}
        baked = objects if sources is None else frozenset().union(*self._sources.values())
        heights = [self._bounds_of(obj)[0][2] for obj in baked] if settings.use_ground_plane else []
        lowest = min(heights, default=np.inf)
        self.ground_height = float(lowest) if np.isfinite(lowest) else None
        # The last one only: objects that share it follow one another, and each may be as large as the scene.
        self._owners: frozenset[bpy.types.Object] = frozenset()
        self._scene: Occluders | None = None
        self.key = b""
        """Fingerprint of the last scene that was given out, without its colours."""
        self._albedo: Albedo | None = None
        self._warnings: list[str] = []
        self._unread: list[str] = []

    def owners_for(self, obj: bpy.types.Object) -> frozenset[bpy.types.Object]:
        """Who blocks the rays of ``obj``: itself always, or what is baked onto it."""
        which = self._which(obj)
        others = {"SELF": set(), "SELECTED": self._selected, "VISIBLE": self._shadowing}[which]
        if not self._sources:
            return frozenset({obj, *others})
        if which == "VISIBLE":
            others = others.difference(*self._sources.values())
        return (self._sources[obj] | others) - self._sources.keys()

    def scene_for(self, obj: bpy.types.Object, warnings: list[str]) -> Generator[float, None, Occluders]:
        """What blocks the rays of ``obj``, always with itself; appends to ``warnings`` what its artist should know.
        Reads it in the first step; yields 0 while a scene is built."""
        low, high = self._bounds_of(obj)
        if self._which(obj) == "VISIBLE" and not self._sources and obj not in self._rendered:
            warnings.append("Disabled in renders: it was baked, and blocks no light on other objects")
        owners = self.owners_for(obj)
        if self._scene is None or owners != self._owners:
            yield from self._build(owners)
        if np.isfinite(low).all():
            centre = 0.5 * (low + high)
            if np.abs(centre - self._scene.centre).max() > FAR * (high - low).max():
                yield from self._build(owners, centre)
        warnings += self._warnings
        return self._scene

    def albedo(self, warnings: list[str]) -> Albedo | None:
        """Base colours of the last scene that was given out, None where they are not read; appends to ``warnings`` what
        could not be read."""
        warnings += self._unread
        return self._albedo

    def _which(self, obj: bpy.types.Object) -> str:
        return self._own.get(obj, self._settings).occluders

    def _build(
        self, owners: frozenset[bpy.types.Object], centre: NDArray | None = None
    ) -> Generator[float, None, None]:
        self._scene = self._albedo = None  # freed before the next is built
        depsgraph = self._context.evaluated_depsgraph_get()
        vertices, triangles, self._warnings = read_occluders(depsgraph, owners)
        if self._colours:  # in the same moment: its triangles are those
            self._albedo, self._unread = read_albedo(depsgraph, owners)
        self.key, self._scene = yield from in_thread(
            calling(occluders_of, vertices, triangles, self.ground_height, centre)
        )
        # One that is centred on an object is for that object alone.
        self._owners = owners if centre is None else frozenset()

    def _bounds_of(self, obj: bpy.types.Object) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As :func:`_bounds`, read once for the ground plane and the centre."""
        if obj not in self._bounds:
            self._bounds[obj] = _bounds(self._context, obj)
        return self._bounds[obj]


def _bounds(context: bpy.types.Context, obj: bpy.types.Object) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest world coordinates (3,) of the finite vertices of the faces of ``obj``; inf, -inf if none."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    positions = np.empty((0, 3))
    with evaluated_mesh(evaluated) as mesh:
        if mesh is not None:
            used = np.zeros(len(mesh.vertices), bool)
            used[read_corner_vertices(mesh)] = True
            positions = to_world(read_positions(mesh)[used], np.array(evaluated.matrix_world, np.float64))
    positions = positions[np.isfinite(positions).all(axis=1)]
    return positions.min(axis=0, initial=np.inf), positions.max(axis=0, initial=-np.inf)
