# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel knows of UV maps: found once a mesh beside the artist's work, and kept until the mesh changes, because
a panel is drawn many times a second."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.rasterise import rasterise
from ..core.workers import calling, giving_way, in_thread
from .mesh_reader import read, read_triangles
from .uv_layout import expected_texels, overlaps, touched_tiles
from .viewports import redraw_viewports

# Side of the image that overlaps are looked for in: small ones are found by the bake alone.
SIZE = 512
TICK = 0.1


@dataclass(frozen=True)
class UVCheck:
    """``coverage`` in tiles, and whether faces ``overlap``: of the 0-1 tile, or of all UDIM tiles together."""

    coverage: float
    overlap: bool


# By the mesh's session_uid, the UV map, and whether it has tiles; None while it is looked for.
_known: dict[tuple[int, str, bool], UVCheck | None] = {}
_wanted: list[tuple[int, str, bool]] = []
_work: Generator | None = None


def uv_check(mesh: bpy.types.Mesh, uv_map: str, has_tiles: bool) -> UVCheck | None:
    """What is known of ``uv_map`` of ``mesh``, in UDIM tiles where it ``has_tiles``. None where nothing is yet: it is
    found out, and panels drawn again."""
    key = mesh.session_uid, uv_map, has_tiles
    if key not in _known:
        _known[key] = None
        _wanted.append(key)
        if not (bpy.app.background or bpy.app.timers.is_registered(_go_on)):
            bpy.app.timers.register(_go_on, first_interval=TICK)
    return _known[key]


def check_layout(triangle_uv: NDArray[np.float64], has_tiles: bool) -> UVCheck:
    """Of a layout (m, 3, 2)."""
    numbers = touched_tiles(triangle_uv) if has_tiles else [1001]
    covered = 0
    for number in numbers:
        corner = (number - 1001) % 10, (number - 1001) // 10
        covered += len(rasterise(triangle_uv - corner, SIZE, SIZE).texel)
    coverage = expected_texels(triangle_uv, SIZE, len(numbers)) / SIZE**2
    return UVCheck(coverage, overlaps(triangle_uv, covered, SIZE, has_tiles))


def _go_on() -> float | None:
    """Blender's timer, while something is wanted."""
    global _work
    try:
        with giving_way():
            if _work is None:
                _work = _begin()
            next(_work)
    except StopIteration:
        _work = None
        redraw_viewports(bpy.context.window_manager)
    return TICK if _wanted or _work else None


def _begin() -> Generator[float, None, None]:
    """Look at the first mesh that is wanted, unless it is gone or in Edit Mode."""
    key = _wanted.pop(0)
    mesh = next((mesh for mesh in bpy.data.meshes if mesh.session_uid == key[0]), None)
    if mesh is None or mesh.is_editmode or key[1] not in mesh.uv_layers:
        _known.pop(key, None)
        return
    mesh.calc_loop_triangles()
    uv = read(mesh.uv_layers[key[1]].uv, "vector", 2, np.float32).astype(np.float64)
    found = yield from in_thread(calling(check_layout, uv[read_triangles(mesh)], key[2]))
    if key in _known:  # else it has changed meanwhile
        _known[key] = found


@bpy.app.handlers.persistent
def _forget_changed(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _known:
        for update in depsgraph.updates:
            if update.is_updated_geometry and isinstance(update.id, bpy.types.Mesh):
                uid = update.id.original.session_uid
                for key in [key for key in _known if key[0] == uid]:
                    del _known[key]


@bpy.app.handlers.persistent
def _forget(*_: object) -> None:
    global _work
    if _work is not None:
        _work.close()
        _work = None
    _known.clear()
    _wanted.clear()


def register() -> None:
    bpy.app.handlers.depsgraph_update_post.append(_forget_changed)
    bpy.app.handlers.load_pre.append(_forget)


def unregister() -> None:
    _forget()
    if bpy.app.timers.is_registered(_go_on):
        bpy.app.timers.unregister(_go_on)
    bpy.app.handlers.load_pre.remove(_forget)
    bpy.app.handlers.depsgraph_update_post.remove(_forget_changed)
