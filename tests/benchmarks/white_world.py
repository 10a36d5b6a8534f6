# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo scene under a white World: `Irradiance` of the bent-cone nodes against F0, at every vertex of every object.

The nodes are evaluated by Cycles, which bakes what they emit. Blender moves the points of such bakes into the faces, by
a fixed distance that on fine meshes is far enough to meet another value. So each vertex, or face corner where a mesh
has sharp edges, stands as a triangle of its own, all of which has its cone and its normal.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import numpy as np
from bakes import AO, CONE, CYCLES
from meshes import select
from report import Report

from core.sampling import frames
from demo.quiet import quiet


def main(report: Report, quick: bool) -> None:
    sys.path.append(str(Path(__file__).resolve().parents[2] / "demo"))
    import scene

    ruin = scene.build()
    objects = [obj for obj in ruin.vertex_objects + ruin.texture_objects if not quick or obj.name == "Alcove Floor"]
    for obj in objects:
        # A bake is of the mesh's own vertices.
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        obj.data = bpy.data.meshes.new_from_object(evaluated)
        obj.modifiers.clear()
    settings = bpy.context.scene.multibounce_ao
    settings.samples, settings.bounces = 16, "FITTED"
    bpy.context.view_layer.update()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0]
    with quiet():
        bpy.ops.multibounce_ao.bake()
    material = _emission_of_irradiance()
    worst, count = 0.0, 0
    for obj in objects:
        error = _errors(obj, material)
        count += len(error)
        worst = max(worst, error.max())
        report.note(f"{obj.name}: {len(error):,} points, Irradiance is F0 within {error.max():.5f}")
    report.add(
        f"Irradiance and F0 at {count:,} vertices or face corners of {len(objects)} objects", f"{worst:.5f}", "< .005"
    )


def _emission_of_irradiance() -> bpy.types.Material:
    """A material of the group as `Add World Light` builds it, its irradiance emitted."""
    obj = bpy.context.view_layer.objects.active
    bpy.ops.multibounce_ao.add_world_light()
    material = obj.active_material
    tree = material.node_tree
    light = next(n for n in tree.nodes if getattr(n, "node_tree", None) and n.node_tree.name == "Bent Cone Irradiance")
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(light.outputs["Irradiance"], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    return material


def _errors(obj: bpy.types.Object, material: bpy.types.Material) -> np.ndarray:
    """|Irradiance - F0| at each element of the bake."""
    cone, f0 = _colours(obj.data, CONE), _colours(obj.data, AO)[:, 0]
    is_smooth = obj.data.attributes[AO].domain == "POINT"
    normals = np.empty(3 * len(f0), np.float32)
    (obj.data.vertex_normals if is_smooth else obj.data.corner_normals).foreach_get("vector", normals)
    normals = normals.reshape(-1, 3).astype(np.float64)
    tangent, bitangent, _ = np.moveaxis(frames(normals.T, np.zeros(len(normals))), 1, 0)
    corners = np.stack((np.zeros_like(tangent), tangent, bitangent), axis=1).reshape(-1, 3)
    mesh = bpy.data.meshes.new("Probes")
    mesh.vertices.add(len(corners))
    mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", np.arange(len(corners), dtype=np.int32))
    mesh.polygons.add(len(normals))
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    mesh.shade_flat()
    mesh.materials.append(material)
    mesh.color_attributes.new(CONE, "FLOAT_COLOR", "POINT").data.foreach_set(
        "color", np.repeat(cone, 3, axis=0).ravel()
    )
    mesh.color_attributes.active_color = mesh.color_attributes.new(CYCLES, "FLOAT_COLOR", "CORNER")
    probes = bpy.data.objects.new("Probes", mesh)
    bpy.context.collection.objects.link(probes)
    probes.matrix_world = obj.matrix_world
    select(probes)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    with quiet():
        bpy.ops.object.bake(type="EMIT", target="VERTEX_COLORS")
    irradiance = _colours(mesh, CYCLES)[:, 0].reshape(-1, 3)
    bpy.data.objects.remove(probes)
    return np.abs(irradiance - f0[:, None]).max(axis=1)


def _colours(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    data = mesh.attributes[name].data
    values = np.empty(4 * len(data), np.float32)
    data.foreach_get("color", values)
    return values.reshape(-1, 4)
