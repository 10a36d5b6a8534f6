# SPDX-License-Identifier: GPL-3.0-or-later
"""The base colours of what blocks rays, triangle by triangle."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.albedo import Albedo, Constants, CornerColours, Texture, TextureColours
from .base_color_nodes import (
    AttributeColour,
    BaseColor,
    ImageColour,
    constant,
    read_base_color,
    unreadable_warning,
)
from .image_pixels import read_pixels
from .mesh_reader import evaluated_mesh, front_facing, read, read_corner_vertices, read_triangles
from .node_origins import UnreadableError
from .occluder_reader import blockers

# Property and width of the attributes that can be colours, by data type.
_VALUES = {"FLOAT_COLOR": ("color", 4), "BYTE_COLOR": ("color", 4), "FLOAT_VECTOR": ("vector", 3)}


def read_albedo(depsgraph: bpy.types.Depsgraph, owners: Collection[bpy.types.Object]) -> tuple[Albedo, list[str]]:
    """Colours of the triangles of :func:`.occluder_reader.read_occluders`, in the same order, and warnings.

    See :func:`.base_color_nodes.read_base_color` for what is read. Colours are those of the evaluated objects, and of
    what fills their slots. As in renders, an attribute that a mesh lacks is black, and a UV map that it lacks is zero.
    Pixels of images are blended, and darkened by their alpha, as linear light, as in EEVEE; Cycles does both to the
    encoded bytes.

    Memory: 4 bytes a triangle; for each triangle of each mesh, however often it is instanced, 8 more while reading, and
    36 where it has an attribute's colours or 24 where it has an image's; 12 bytes a pixel of each image, 28 while it is
    read. Instances that mirror a mesh count as another mesh.
    """
    sources, warnings = _Sources(), []
    meshes: dict[tuple[int, int, int], tuple[NDArray, NDArray]] = {}
    placed: list[tuple[tuple[int, int, int], NDArray | None]] = []
    for blocker in blockers(depsgraph, owners):
        # Where the instance's corners are among those of the mesh's triangles.
        order = front_facing(np.arange(3)[None], blocker.placed.matrix)[0]
        key = (*blocker.key, int(order[0]))
        if key not in meshes:
            meshes[key] = sources.add(blocker.evaluated, order, warnings)
        placed.append((key, blocker.placed.in_world()[2]))
    return sources.albedo(meshes, placed), warnings


def read_own_albedo(evaluated: bpy.types.Object, matrix: NDArray, warnings: list[str]) -> Albedo:
    """As :func:`read_albedo`, of the triangles of one object placed by ``matrix`` (4, 4), in the order of its surface
    (:meth:`.mesh_reader.MeshArrays.surface`)."""
    sources = _Sources()
    order = front_facing(np.arange(3)[None], matrix)[0]
    return sources.albedo({(0, 0, 0): sources.add(evaluated, order, warnings)}, [((0, 0, 0), None)])


@dataclass
class _Rows:
    """Rows of the source ``number``, as they come: ``parts`` (k, ...) of ``count`` rows together."""

    number: int
    parts: list[NDArray[np.float32]] = field(default_factory=list)
    count: int = 0

    def add(self, part: NDArray[np.float32]) -> tuple[int, NDArray[np.intp]]:
        """The number, and the rows (k,) that ``part`` now has."""
        self.parts.append(part)
        self.count += len(part)
        return self.number, np.arange(self.count - len(part), self.count)


class _Sources:
    """Colours of meshes, collected by source: 0 constants, 1 corners' colours, then one for each way that an image is
    shown."""

    def __init__(self) -> None:
        self._read: dict[bpy.types.Material | None, BaseColor] = {}
        self._unreadable: set[bpy.types.Material] = set()
        self._constants: dict[tuple[float, float, float], int] = {}
        self._corners = _Rows(1)
        self._images: dict[tuple, tuple[BaseColor, _Rows]] = {}

    def add(
        self, evaluated: bpy.types.Object, order: NDArray[np.intp], warnings: list[str]
    ) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Source (m,) of each triangle of ``evaluated``, and its row there (m,); corners come in ``order`` (3,)."""
        materials = [slot.material for slot in evaluated.material_slots] or [None]
        with evaluated_mesh(evaluated) as mesh:
            if mesh is None:
                return np.empty(0, np.int32), np.empty(0, np.int32)
            corners = read_triangles(mesh)[:, order]
            face = read(mesh.loop_triangles, "polygon_index", 1, np.int32)
            slot = _slots(mesh, len(materials))[face]
            source, row = np.empty_like(face), np.empty_like(face)
            for number, material in enumerate(materials):
                here = np.flatnonzero(slot == number)
                if not len(here):
                    continue
                colour = self._colour(material, evaluated, warnings)
                try:
                    source[here], row[here] = self._rows(colour, mesh, corners[here], face[here])
                except UnreadableError as unreadable:
                    if material not in self._unreadable:
                        warnings.append(_of(evaluated, unreadable_warning(material, unreadable)))
                    self._unreadable.add(material)
                    stand_in = constant(material.diffuse_color)
                    source[here], row[here] = self._rows(stand_in, mesh, corners[here], face[here])
        return source, row

    def albedo(
        self,
        meshes: dict[tuple[int, int, int], tuple[NDArray, NDArray]],
        placed: list[tuple[tuple[int, int, int], NDArray | None]],
    ) -> Albedo:
        """What was added, for instances ``placed`` of ``meshes``: those triangles of each that are kept, None: all."""
        sources = [
            Constants(np.array(list(self._constants)).reshape(-1, 3)),
            CornerColours(np.concatenate([np.empty((0, 3, 3), np.float32), *self._corners.parts])),
        ]
        pixels: dict[tuple, NDArray[np.float32]] = {}
        for colour, rows in self._images.values():
            shown = colour.source
            key = shown.image, shown.alpha
            if key not in pixels:
                pixels[key] = read_pixels(shown.image, shown.alpha).linear()
            texture = Texture(pixels[key], shown.extension, shown.is_closest)
            sources.append(TextureColours(texture, np.concatenate(rows.parts), colour.scale, colour.offset))
        first = np.cumsum([0, *map(len, sources)])
        numbered = {key: (first[source] + row).astype(np.int32) for key, (source, row) in meshes.items()}
        parts = [numbered[key] if kept is None else numbered[key][kept] for key, kept in placed]
        return Albedo(sources, np.concatenate([np.empty(0, np.int32), *parts]))

    def _colour(
        self, material: bpy.types.Material | None, evaluated: bpy.types.Object, warnings: list[str]
    ) -> BaseColor:
        if material not in self._read:
            self._read[material], warning = read_base_color(material)
            if warning:
                warnings.append(_of(evaluated, warning))
        return self._read[material]

    def _rows(
        self, colour: BaseColor, mesh: bpy.types.Mesh, corners: NDArray[np.int32], face: NDArray[np.int32]
    ) -> tuple[int, NDArray[np.intp] | int]:
        """Source and rows (k,), or the row of all, for triangles of ``corners`` (k, 3) in faces (k,)."""
        shown = colour.source
        if shown is None:
            return 0, self._constants.setdefault(colour.offset, len(self._constants))
        if isinstance(shown, AttributeColour):
            values = _attribute(mesh, shown, corners, face) * colour.scale + colour.offset
            return self._corners.add(values.astype(np.float32))
        look = shown.image, shown.alpha, shown.extension, shown.is_closest, colour.scale, colour.offset
        _, rows = self._images.setdefault(look, (colour, _Rows(2 + len(self._images))))
        return rows.add(_corner_uv(mesh, shown, corners))


def _of(evaluated: bpy.types.Object, warning: str) -> str:
    return f"'{evaluated.name}': {warning}"


def _slots(mesh: bpy.types.Mesh, slots: int) -> NDArray[np.int32]:
    """The slot (f,) of each face; what lies beyond the last has the last, as in renders."""
    attribute = mesh.attributes.get("material_index")
    if attribute is None:
        return np.zeros(len(mesh.polygons), np.int32)
    return np.clip(read(attribute.data, "value", 1, np.int32), 0, slots - 1)


def _attribute(
    mesh: bpy.types.Mesh, source: AttributeColour, corners: NDArray[np.int32], face: NDArray[np.int32]
) -> NDArray[np.float32]:
    """Values (k, 3 corners, 3)."""
    attribute = mesh.attributes.get(mesh.attributes.default_color_name if source.name is None else source.name)
    if attribute is None:
        return np.zeros((*corners.shape, 3), np.float32)
    if attribute.domain == "POINT":
        index = read_corner_vertices(mesh)[corners]
    elif attribute.domain == "CORNER":
        index = corners
    elif attribute.domain == "FACE":
        index = np.broadcast_to(face[:, None], corners.shape)
    else:
        raise UnreadableError(f"the attribute '{attribute.name}' of edges", "convert it to face corners")
    if attribute.data_type not in _VALUES:
        raise UnreadableError(f"the attribute '{attribute.name}' that is no color", "convert it to a color attribute")
    name, width = _VALUES[attribute.data_type]
    return read(attribute.data, name, width, np.float32)[:, :3][index]


def _corner_uv(mesh: bpy.types.Mesh, source: ImageColour, corners: NDArray[np.int32]) -> NDArray[np.float32]:
    """Coordinates (k, 3 corners, 2) in the image."""
    if source.uv_map:
        layer = mesh.uv_layers.get(source.uv_map)
    else:
        layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    uv = np.zeros((*corners.shape, 2)) if layer is None else read(layer.uv, "vector", 2, np.float32)[corners]
    return (uv @ source.mapping[:, :2].T + source.mapping[:, 2]).astype(np.float32)
