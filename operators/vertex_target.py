# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking to vertices: the points that stand for a mesh's vertices or face corners, and the attributes they fill."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.channels import bent_cone, fitted_bounces
from ..core.closest_point import closest_point
from ..core.surface import Surface
from .mesh_reader import linear_inverse, read_surface
from .names import BENT_CONE, MULTIBOUNCE_AO
from .progress import mapped
from .report import BakeError, ObjectReport, statistics


@dataclass(frozen=True)
class VertexPoints:
    """Sample points of one mesh, and which of them each vertex or face corner takes.

    positions, normals  (k, 3) float64, world space
    element_point       (n,) int, the point of each element of the attribute ``domain``, "POINT" or "CORNER"
    extent              size of the surface, world units
    moved               the points are not the mesh's own vertices
    """

    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    element_point: NDArray[np.intp]
    domain: str
    extent: float
    moved: bool = False


@dataclass(frozen=True)
class VertexResult:
    """Channels (n, 4) float32 of every vertex or face corner, ready to be stored on ``mesh``."""

    mesh: bpy.types.Mesh
    domain: str
    multibounce_ao: NDArray[np.float32]
    bent_cone: NDArray[np.float32]

    def write(self) -> list[str]:
        """Store both attributes; returns their names."""
        write_attribute(self.mesh, MULTIBOUNCE_AO, self.domain, self.multibounce_ao)
        write_attribute(self.mesh, BENT_CONE, self.domain, self.bent_cone)
        return [MULTIBOUNCE_AO, BENT_CONE]


def bake_vertices(
    mesh: bpy.types.Mesh, points: VertexPoints, matrix: NDArray, trace, report: ObjectReport
) -> Generator[float, None, VertexResult]:
    """Trace the ``points`` of ``mesh``, which ``matrix`` (4, 4) places in the world; yields the fraction done.

    ``trace(positions, normals, extent=...)`` is :func:`core.visibility.trace_visibility` with its scene and settings
    bound.
    """
    report.points = len(points.positions)
    if points.moved:
        report.warnings.append(
            "Modifiers change the topology: the original vertices were baked at the nearest point "
            "of the modified surface"
        )
    tracing = trace(points.positions, points.normals, extent=points.extent)
    visibility = yield from mapped(tracing, lambda done: done / report.points)
    report.f0 = statistics(visibility.f0)
    return VertexResult(
        mesh,
        points.domain,
        fitted_bounces(visibility)[points.element_point],
        bent_cone(visibility, linear_inverse(matrix))[points.element_point],
    )


def vertex_points(mesh: bpy.types.Mesh, evaluated: bpy.types.Mesh, matrix: NDArray) -> VertexPoints:
    """Where the elements of ``mesh`` are sampled.

    A mesh with flat faces or sharp edges has several normals at a vertex, so it gets a value a face corner. Where
    modifiers change the topology, the original vertices go to the nearest point of the evaluated surface.
    """
    surface = read_surface(evaluated, matrix)
    smooth = mesh.normals_domain == evaluated.normals_domain == "POINT"
    if len(mesh.vertices) == len(evaluated.vertices) and len(mesh.loops) == len(evaluated.loops):
        return _points_of(surface, smooth)
    points = _points_of(read_surface(mesh, matrix), smooth)
    triangle, barycentric = closest_point(points.positions, surface.vertices, surface.vertex_triangles)
    return VertexPoints(
        surface.positions_at(triangle, barycentric),
        surface.normals_at(triangle, barycentric),
        points.element_point,
        points.domain,
        surface.extent,
        moved=True,
    )


def _points_of(surface: Surface, smooth: bool) -> VertexPoints:
    if not smooth:
        positions, normals, corner_point = surface.split_vertices()
        return VertexPoints(positions, normals, corner_point, "CORNER", surface.extent)
    count = len(surface.vertices)
    normals = np.tile((0.0, 0.0, 1.0), (count, 1))  # what loose vertices, which no face gives a normal, keep
    normals[surface.corner_vertex] = surface.corner_normals
    return VertexPoints(surface.vertices, normals, np.arange(count), "POINT", surface.extent)


def check_attribute_names(obj: bpy.types.Object) -> None:
    """Raises BakeError where what is no colour has a name that the bake needs: it may be the artist's work."""
    for name in (MULTIBOUNCE_AO, BENT_CONE):
        attribute = obj.data.attributes.get(name)
        if name in obj.vertex_groups or (attribute and attribute.data_type not in {"FLOAT_COLOR", "BYTE_COLOR"}):
            raise BakeError(f"has a UV map, vertex group or attribute '{name}' that is no colour: rename it")


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


def remove_attributes(mesh: bpy.types.Mesh) -> None:
    """Take back what a bake stored on ``mesh``."""
    for name in (MULTIBOUNCE_AO, BENT_CONE):
        attribute = mesh.attributes.get(name)
        if attribute is not None:
            mesh.attributes.remove(attribute)
