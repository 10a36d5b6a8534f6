# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to vertices: the points that stand for a mesh's vertices or face corners, and the attributes they fill."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.fill import fill_points
from ..core.projection import ProjectedPoints
from ..core.sample_points import PROBES, CornerTable, SurfacePoints, spread_points
from ..core.surface import Surface, extent_of, unit
from ..core.workers import mapped
from .high_to_low import ProjectionSource
from .mesh_reader import MeshArrays, linear_inverse, read_corner_vertices, read_face_starts, read_mesh, to_world
from .names import CHANNELS
from .nearest_point import nearest_points
from .preview import VertexPicture, nearest_shown
from .progress import STARTED
from .report import BakeError, ObjectReport
from .tracer import Tracer

# Modifiers that keep the original vertices, in their order: before new ones, and without new ones.
SUBDIVIDE = {"SUBSURF", "MULTIRES"}
DEFORM = {
    *("ARMATURE", "CAST", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM", "LATTICE", "MESH_DEFORM", "SHRINKWRAP"),
    *("SIMPLE_DEFORM", "SMOOTH", "CORRECTIVE_SMOOTH", "LAPLACIANSMOOTH", "SURFACE_DEFORM", "WARP", "WAVE"),
    *("DATA_TRANSFER", "NORMAL_EDIT", "WEIGHTED_NORMAL", "UV_PROJECT", "UV_WARP"),
}

Topology = tuple[int, NDArray[np.int32], NDArray[np.int32]]


@dataclass(frozen=True)
class VertexPoints:
    """Sample points of one mesh, and which of them each vertex or face corner takes.

    positions, normals  (k, 3) float64, world space
    element_point       (n,) int, the point of each element of the attribute
    extent              size of the surface, world units
    lift                (k,) float64, see :class:`core.sample_points.SurfacePoints`
    cage                (k, 3) float64, where they are on a cage
    """

    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    element_point: NDArray[np.intp]
    extent: float
    lift: NDArray[np.float64] | None = None
    cage: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class VertexSource:
    """What the points of a mesh are made of: all that is read of it.

    own           the mesh whose elements are baked, where its modifiers put it if they keep its topology
    domain        of the attribute, "POINT" or "CORNER", and of the normals of ``own``
    matrix        (4, 4) float64, places it in the world
    modified      the surface that its modifiers make, where they change the topology
    comes_first   whether that begins with the vertices of ``own``
    cage          (n, 3) float64, world positions of the vertices on a cage
    """

    own: MeshArrays
    domain: str
    matrix: NDArray[np.float64]
    modified: MeshArrays | None = None
    comes_first: bool = False
    cage: NDArray[np.float64] | None = None

    @property
    def topology(self) -> Topology:
        """Number of vertices, the vertex (c,) of each of the face corners, each face's first."""
        return len(self.own.positions), self.own.corner_vertex, self.own.face_start

    def points(self, onto: Surface | None) -> tuple[VertexPoints, float]:
        """The points, moved ``onto`` the modified surface where there is one, and how far at most. Needs no Blender."""
        points_of = self._vertices if self.domain == "POINT" else self._corners
        if onto is None:
            points = points_of()
            return points if self.cage is None else replace(points, cage=points_of(self.cage).positions), 0.0
        return _moved_onto(points_of(onto.vertices[: len(self.own.positions)] if self.comes_first else None), onto)

    def _vertices(self, positions: NDArray | None = None) -> VertexPoints:
        """A point a vertex, at world ``positions`` if they are given."""
        if positions is None:
            positions = to_world(self.own.positions, self.matrix)
        normals = unit(self.own.normals @ linear_inverse(self.matrix))
        extent = extent_of(positions, self.own.corner_vertex)
        return VertexPoints(positions, normals, np.arange(len(positions)), extent)

    def _corners(self, positions: NDArray | None = None) -> VertexPoints:
        """A point for each normal at a vertex, with its vertices at world ``positions`` if they are given."""
        surface = self.own.surface(self.matrix)
        if positions is not None:
            surface = replace(surface, vertices=positions)
        positions, normals, corner_point = surface.split_vertices()
        return VertexPoints(positions, normals, corner_point, surface.extent)


@dataclass(frozen=True)
class VertexResult:
    """Channels (n, 4) float32 of every vertex or face corner, ready to be stored on ``mesh``; ``topology`` as in
    :class:`VertexSource`."""

    mesh: bpy.types.Mesh
    domain: str
    channels: dict[str, NDArray[np.float32]]
    topology: Topology

    def write(self) -> list[str]:
        """Store the attributes; returns their names. Raises BakeError where the mesh was edited since it was read."""
        if not all(map(np.array_equal, _topology(self.mesh), self.topology)):
            raise BakeError("was edited while it was baked: bake it again")
        for name, values in self.channels.items():
            write_attribute(self.mesh, name, self.domain, values)
        return list(self.channels)


def bake_vertices(
    mesh: bpy.types.Mesh,
    source: VertexSource,
    tracer: Tracer,
    report: ObjectReport,
    projected: ProjectionSource | None = None,
    picture: VertexPicture | None = None,
) -> Generator[float, None, VertexResult | None]:
    """Trace the points of ``source``, read from ``mesh``, or what they show of what is ``projected``; yields the
    fraction done, and shows it in the ``picture``. None where that is only to be a sketch. Raises BakeError."""
    yield 0.0
    projection = projected and projected.projection()
    surface = source.modified and source.modified.surface(source.matrix)
    points, moved = source.points(surface)
    report.points = len(points.positions)
    if surface is not None:
        away = f"up to {moved:.3g} away" if moved > 1e-3 * points.extent else "where they lie on it"
        report.warnings.append(
            "Modifiers change the topology: the original vertices were baked at the nearest point of the modified "
            f"surface, {away}"
        )
    on_surface = SurfacePoints(points.positions, points.normals, points.lift)
    starts, probes, extent = on_surface, lambda: on_surface, points.extent
    if projection is not None:
        cage = None if points.cage is None else SurfacePoints(points.cage, points.normals)
        starts = ProjectedPoints(starts, projection.high, cage)
        probes, extent = partial(spread_points, projection.high.corners, PROBES), projection.high.extent
    if picture is not None:
        shown = _shown(points, surface)
        yield from mapped(picture.sketch(tracer, starts, extent, *shown), lambda done: 0.0)
        if picture.is_sketch:
            return None
    begin = tracer.light_share(len(starts))
    cache = yield from mapped(tracer.light(probes, len(starts), extent), lambda done: begin * done)
    tracing = tracer.visibility(starts, extent, cache, picture and picture.refine)
    visibility = yield from mapped(tracing, lambda done: max(STARTED, begin + (1.0 - begin) * done / report.points))
    known = ~visibility.lost
    report.tell_f0(visibility.f0[known], "points", projection is not None)
    to_object = linear_inverse(source.matrix)
    channels = tracer.channels(visibility, to_object)
    if not known.all():
        fill_points(list(channels.values()), known, _edges(source, points))
        lost = np.flatnonzero(visibility.lost)
        tracer.fill_cones(channels, lost, points.normals[lost], to_object)
    stored = {name: values[points.element_point] for name, values in channels.items()}
    return VertexResult(mesh, source.domain, stored, source.topology)


def _shown(points: VertexPoints, onto: Surface | None) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """Which ``points`` the elements of what is drawn show (n, j), and with which weights: each its own, or the vertices
    of the surface that they were moved ``onto`` those nearby."""
    if onto is None:
        return points.element_point[:, None], np.ones((len(points.element_point), 1), np.float32)
    normals = np.zeros_like(onto.vertices)
    normals[onto.corner_vertex] = onto.corner_normals
    return nearest_shown(onto.vertices, normals, points.positions, points.normals, points.extent)


def _edges(source: VertexSource, points: VertexPoints) -> NDArray[np.intp]:
    """The ``points`` (e, 2) of ``source`` that stand for the ends of the faces' edges."""
    _, corner_vertex, start = source.topology
    corner = points.element_point
    if source.domain == "POINT":
        corner = corner[corner_vertex]
    following = np.arange(1, len(corner) + 1)
    following[np.append(start[1:], len(corner)) - 1] = start
    return np.column_stack((corner, corner[following]))


def read_vertices(
    obj: bpy.types.Object,
    evaluated: bpy.types.Mesh,
    matrix: NDArray,
    cage: NDArray | None = None,
) -> VertexSource:
    """What is sampled for the elements of the mesh of ``obj`` on ``evaluated``, the surface that its modifiers make;
    ``cage`` (n, 3) has the positions of that surface's vertices on a cage.

    A mesh with flat faces or sharp edges has several normals at a vertex, so it gets a value a face corner. Where
    modifiers change the topology, the original vertices go to the nearest point of the evaluated surface.
    """
    mesh = obj.data
    domain = "POINT" if mesh.normals_domain == evaluated.normals_domain == "POINT" else "CORNER"
    same_corners = np.array_equal(read_corner_vertices(mesh), read_corner_vertices(evaluated))
    if same_corners and len(mesh.vertices) == len(evaluated.vertices):
        return VertexSource(read_mesh(evaluated, domain), domain, matrix, cage=cage)
    if cage is not None:
        raise BakeError("has modifiers that change its topology, so its vertices have no place on a cage: apply them")
    return VertexSource(read_mesh(mesh, domain), domain, matrix, read_mesh(evaluated), _vertices_come_first(obj))


def _moved_onto(points: VertexPoints, surface: Surface) -> tuple[VertexPoints, float]:
    """``points`` at the nearest places of ``surface``, and how far the furthest was from there."""
    triangle, barycentric = nearest_points(points.positions, points.normals, surface)
    start = CornerTable(surface).start(triangle, barycentric[:, 1], barycentric[:, 2])
    positions, normals = start.positions.T, start.normals.T
    moved = float(np.linalg.norm(positions - points.positions, axis=1).max())
    extent, lift = surface.extent, start.lift
    return replace(points, positions=positions, normals=normals, extent=extent, lift=lift), moved


def _vertices_come_first(obj: bpy.types.Object) -> bool:
    """Whether the evaluated mesh begins with the original vertices, where the modifiers moved them.

    So it is under subdivision, which draws a cage's vertices far in: the nearest point of the surface is another one.
    """
    return all(modifier.type in SUBDIVIDE | DEFORM for modifier in obj.modifiers if modifier.show_viewport)


def _topology(mesh: bpy.types.Mesh) -> Topology:
    """As :attr:`VertexSource.topology`."""
    return len(mesh.vertices), read_corner_vertices(mesh), read_face_starts(mesh)


def check_attribute_names(obj: bpy.types.Object, bounces: str) -> None:
    """Raises BakeError where what is no colour has a name that the bake needs: it may be the artist's work."""
    for name in CHANNELS[bounces]:
        attribute = obj.data.attributes.get(name)
        if name in obj.vertex_groups or (attribute and attribute.data_type not in {"FLOAT_COLOR", "BYTE_COLOR"}):
            raise BakeError(f"has a UV map, vertex group or attribute '{name}' that is no color: rename it")


def write_attribute(mesh: bpy.types.Mesh, name: str, domain: str, values: NDArray[np.float32]) -> None:
    """Store ``values`` (n, 4) as a FLOAT_COLOR attribute; the colours that the artist paints and renders stay
    active."""
    attributes = mesh.attributes
    active, default = attributes.active_color_name, attributes.default_color_name
    attribute = attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != ("FLOAT_COLOR", domain):
        attributes.remove(attribute)
        attribute = None
    attribute = attribute or attributes.new(name, "FLOAT_COLOR", domain)
    attribute.data.foreach_set("color", np.ascontiguousarray(values, np.float32).ravel())
    attributes.active_color_name, attributes.default_color_name = active, default
    mesh.update()
