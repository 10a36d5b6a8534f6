# SPDX-License-Identifier: GPL-3.0-or-later
"""Props on a floor, animated: a table, a ring, a ball, and a head that flies about."""

from dataclasses import dataclass
from math import pi, radians

import bpy
from mathutils import Vector

FRAMES = (1, 21, 41)
FLOOR_COLOUR = (0.56, 0.50, 0.43, 1)
FLOOR_SHARE, OWN_AO = "Floor Share", "Own AO"


@dataclass
class Stage:
    """``props`` have fields and receive them, ``floor`` only receives; ``standing`` are props with AO of their own that
    holds the floor too, ``flying`` those whose AO is of themselves alone."""

    floor: bpy.types.Object
    props: list[bpy.types.Object]
    standing: list[bpy.types.Object]
    flying: list[bpy.types.Object]


def build() -> Stage:
    """The scene, with a camera; nothing is baked yet."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    floor = _floor()
    table, ring, head, ball = _table(), _ring(), _head(), _ball()
    _animate(table, "rotation_euler", 2, (0, radians(40), radians(80)))
    _animate(ring, "location", 0, (-1.95, -1.6, -1.15))
    _animate(ring, "rotation_euler", 2, (radians(20), radians(75), radians(130)))
    _animate(head, "location", 2, (0.95, 1.5, 1.1))
    _animate(head, "rotation_euler", 0, (radians(-20), radians(25), radians(70)))
    _animate(head, "rotation_euler", 2, (radians(-30), radians(10), radians(60)))
    _animate(ball, "location", 1, (-1.9, -1.55, -1.3))
    _camera()
    return Stage(floor, [table, ring, head, ball], [table, ring], [head])


def _material(name: str, colour, shade: str) -> bpy.types.Material:
    """``colour`` times what the floor and the object itself leave of the light, which fields know nothing of.

    shade  OWN_AO: as baked to the vertices, over a ground plane; FLOOR_SHARE: (1 + n_z) / 2, what an endless floor
           leaves to a surface that faces along n
    """
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    principled = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    plain = nodes.new("ShaderNodeRGB")
    plain.name = "Plain Color"
    plain.outputs[0].default_value = colour
    factors = []
    if OWN_AO in shade:
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "Multibounce AO"
        separate = nodes.new("ShaderNodeSeparateColor")
        links.new(attribute.outputs["Color"], separate.inputs[0])
        factors.append(separate.outputs["Red"])
    if FLOOR_SHARE in shade:
        geometry, split, half = (
            nodes.new(kind) for kind in ("ShaderNodeNewGeometry", "ShaderNodeSeparateXYZ", "ShaderNodeMath")
        )
        half.operation = "MULTIPLY_ADD"
        half.inputs[1].default_value = half.inputs[2].default_value = 0.5
        links.new(geometry.outputs["Normal"], split.inputs[0])
        links.new(split.outputs["Z"], half.inputs[0])
        factors.append(half.outputs[0])
    colour = plain.outputs[0]
    for factor in factors:
        times = nodes.new("ShaderNodeVectorMath")
        times.operation = "MULTIPLY"
        links.new(colour, times.inputs[0])
        links.new(factor, times.inputs[1])
        colour = times.outputs[0]
    links.new(colour, principled.inputs["Base Color"])
    return material


def _named(name: str, colour, shade: str, smooth: bool) -> bpy.types.Object:
    obj = bpy.context.active_object
    obj.name = obj.data.name = name
    obj.data.polygons.foreach_set("use_smooth", [smooth] * len(obj.data.polygons))
    obj.data.materials.append(_material(name, colour, shade))
    return obj


def _floor() -> bpy.types.Object:
    bpy.ops.mesh.primitive_plane_add(size=60)
    return _named("Floor", FLOOR_COLOUR, "", False)


def _table() -> bpy.types.Object:
    """A top and four legs, one mesh, its feet at z = 0; finely cut, for the AO at its vertices."""
    boxes = [((0, 0, 1.0), (1.5, 1.0, 0.1))]
    boxes += [((x, y, 0.475), (0.12, 0.12, 0.95)) for x in (-0.65, 0.65) for y in (-0.4, 0.4)]
    for location, size in boxes:
        bpy.ops.mesh.primitive_cube_add(size=1, location=location)
        bpy.context.active_object.scale = size
    bpy.ops.object.select_all(action="SELECT")
    bpy.data.objects["Floor"].select_set(False)
    bpy.ops.object.transform_apply(location=True, rotation=False, scale=True)
    bpy.ops.object.join()
    bpy.context.scene.cursor.location = (0, 0, 0)
    bpy.ops.object.origin_set(type="ORIGIN_CURSOR")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide(number_cuts=15)
    bpy.ops.object.mode_set(mode="OBJECT")
    return _named("Table", (0.62, 0.36, 0.19, 1), OWN_AO, False)


def _ring() -> bpy.types.Object:
    """A torus that stands on its edge."""
    bpy.ops.mesh.primitive_torus_add(
        major_radius=0.55, minor_radius=0.16, major_segments=64, minor_segments=24, rotation=(pi / 2, 0, 0)
    )
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=False)
    ring = _named("Ring", (0.22, 0.42, 0.60, 1), OWN_AO, True)
    ring.location = (-2.0, -0.3, 0.71)
    return ring


def _head() -> bpy.types.Object:
    bpy.ops.mesh.primitive_monkey_add(size=1.6, location=(1.6, -0.3, 1.3))
    head = bpy.context.active_object
    head.modifiers.new("Subdivision", "SUBSURF").levels = 2
    bpy.ops.object.modifier_apply(modifier="Subdivision")
    return _named("Head", (0.66, 0.50, 0.22, 1), OWN_AO + FLOOR_SHARE, True)


def _ball() -> bpy.types.Object:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.32, location=(0.1, -1.6, 0.32))
    return _named("Ball", (0.70, 0.70, 0.68, 1), FLOOR_SHARE, True)


def _animate(obj: bpy.types.Object, path: str, axis: int, values) -> None:
    for frame, value in zip(FRAMES, values, strict=True):
        getattr(obj, path)[axis] = value
        obj.keyframe_insert(path, index=axis, frame=frame)


def _camera() -> None:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens = 44
    camera.location = (0.0, -6.6, 3.9)
    camera.rotation_euler = (Vector((0.05, -0.25, 0.55)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
