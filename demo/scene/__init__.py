# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo's scene, built by code: a ruined niche with Suzanne in it."""

from dataclasses import dataclass

import bpy

from . import alcove, arch, columns, ground, materials, rubble, stage, statue, urn, wall


@dataclass
class Ruin:
    """What to bake: objects for a vertex bake, objects with a UV map for a texture bake; a prop that comes later, for a
    field bake, and the ground that receives it; and the sun."""

    vertex_objects: list[bpy.types.Object]
    texture_objects: list[bpy.types.Object]
    prop: bpy.types.Object
    ground: list[bpy.types.Object]
    sun: bpy.types.Object


def build() -> Ruin:
    """Build the ruin in a new, empty file."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    masonry = materials.add("Masonry", grain=25, roughness=0.85)
    stone = materials.add("Stone", grain=18, roughness=0.75)
    plaster = materials.add("Plaster", grain=16, roughness=0.8)
    glaze = materials.add("Glaze", grain=8, roughness=0.25)
    earth = materials.add("Earth", grain=30, roughness=0.95)

    ground_objects = [ground.add_paving(earth), ground.add_rock(earth)]
    heap = rubble.add_heap("Rubble Heap", (1.15, -0.75, 0.0), 0.75, 22, 3, masonry)
    vertex_objects = [
        wall.add(masonry),
        arch.add(stone),
        alcove.add_floor(stone),
        statue.add_pedestal(stone),
        statue.add_suzanne(glaze),
        columns.add_standing("Left Column", (-2.35, -0.95, 0.0), 2.75, 1, stone),
        columns.add_standing("Right Column", (2.45, -0.95, 0.0), 0.75, 4, stone),
        columns.add_fallen_drum((1.65, -1.75, 0.28), stone),
        *ground_objects,
        heap,
    ]
    rubble.add_instances(heap, [(-1.45, -0.75, 0.45), (3.1, -0.7, -0.5)])
    stage.add_camera()
    ruin = Ruin(vertex_objects, [alcove.add_inside(plaster)], urn.add(glaze), ground_objects, stage.add_sun())
    bpy.context.view_layer.update()  # until then what was made last cannot be selected
    return ruin
