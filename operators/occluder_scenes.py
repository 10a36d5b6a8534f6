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
from .mesh_reader import MeshTriangles, evaluated_mesh, read_corner_vertices, read_positions, to_world
from .occluder_cache import occluders_of
from .occluder_reader import PlacedMesh, blockers, rendered_objects, together

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
        heights: list[float] = []
        if settings.use_ground_plane:
            self._bounds = {obj: _bounds(*_read_positions(context, obj)) for obj in baked}
            heights = [low[2] for low, _ in self._bounds.values()]
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

    def scene_for(
        self, obj: bpy.types.Object, warnings: list[str], mesh: MeshTriangles | None = None
    ) -> Generator[float, None, Occluders]:
        """What blocks the rays of ``obj``, always with itself; appends to ``warnings`` what its artist should know.
        Reads it in the first step, but for the evaluated ``mesh`` of ``obj``, if that is given; yields 0 while a scene
        is built."""
        positions = () if obj in self._bounds else _read_positions(self._context, obj)
        if self._which(obj) == "VISIBLE" and not self._sources and obj not in self._rendered:
            warnings.append("Disabled in renders: it was baked, and blocks no light on other objects")
        owners = self.owners_for(obj)
        if self._scene is None or owners != self._owners:
            yield from self._build(owners, known={obj: mesh} if mesh else None)
        if obj not in self._bounds:
            self._bounds[obj] = yield from in_thread(calling(_bounds, *positions))
        low, high = self._bounds[obj]
        if np.isfinite(low).all():
            centre = 0.5 * (low + high)
            if np.abs(centre - self._scene.centre).max() > FAR * (high - low).max():
                yield from self._build(owners, centre=centre)
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
        self,
        owners: frozenset[bpy.types.Object],
        known: dict[bpy.types.Object, MeshTriangles] | None = None,
        centre: NDArray | None = None,
    ) -> Generator[float, None, None]:
        self._scene = self._albedo = None  # freed before the next is built
        depsgraph = self._context.evaluated_depsgraph_get()
        placed = [blocker.placed for blocker in blockers(depsgraph, owners, known)]
        if self._colours:  # in the same moment: its triangles are those
            self._albedo, self._unread = read_albedo(depsgraph, owners)
        built = _built(placed, self.ground_height, centre)
        self.key, self._scene, self._warnings = yield from in_thread(built)
        # One that is centred on an object is for that object alone.
        self._owners = owners if centre is None else frozenset()


def _built(
    placed: list[PlacedMesh], ground_height: float | None, centre: NDArray | None
) -> Generator[float, None, tuple[bytes, Occluders, list[str]]]:
    """Fingerprint and scene of ``placed`` meshes, see :func:`.occluder_cache.occluders_of`, and warnings; for
    :func:`core.workers.in_thread`."""
    yield 0.0
    vertices, triangles, warnings = together(placed)
    yield 0.0
    return *occluders_of(vertices, triangles, ground_height, centre), warnings


def _read_positions(
    context: bpy.types.Context, obj: bpy.types.Object
) -> tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.float64]]:
    """Positions (n, 3) of the vertices of ``obj``, the vertices of its face corners, and its matrix."""
    evaluated = obj.evaluated_get(context.evaluated_depsgraph_get())
    matrix = np.array(evaluated.matrix_world, np.float64)
    with evaluated_mesh(evaluated) as mesh:
        if mesh is None:
            return np.empty((0, 3), np.float32), np.empty(0, np.int32), matrix
        return read_positions(mesh), read_corner_vertices(mesh), matrix


def _bounds(
    positions: NDArray[np.float32], corner_vertex: NDArray[np.int32], matrix: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest world coordinates (3,) of the finite vertices that faces have; inf, -inf if there are none."""
    used = np.zeros(len(positions), bool)
    used[corner_vertex] = True
    world = to_world(positions[used], matrix)
    world = world[np.isfinite(world).all(axis=1)]
    return world.min(axis=0, initial=np.inf), world.max(axis=0, initial=-np.inf)
