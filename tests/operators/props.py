# SPDX-License-Identifier: GPL-3.0-or-later
"""AO fields as users bake and apply them."""

from __future__ import annotations

import bpy

from .bakes import change_settings, operators, select

FIELD, RECEIVES = "multibounce_ao_field", "multibounce_ao_receives"
DRAFT = {"samples": 4, "field_resolution": 8}


def ball(name: str = "Ball", radius: float = 1.0, subdivisions: int = 1, **where) -> bpy.types.Object:
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=subdivisions, radius=radius, **where)
    obj = bpy.context.active_object
    obj.name = obj.data.name = name
    return obj


def bake_field(obj: bpy.types.Object, **settings) -> bpy.types.ShaderNodeTree:
    """The button; returns the node group."""
    change_settings(**{**DRAFT, **settings})
    select(obj)
    assert bpy.ops.multibounce_ao.bake_field() == {"FINISHED"}
    return bpy.data.node_groups[f"AO Field {obj.name}"]


def apply_field(occluder: bpy.types.Object, *receivers: bpy.types.Object) -> list[str]:
    """What the button does; returns the warnings."""
    select(occluder, *receivers)
    return operators("field_receivers").apply_field(occluder, list(receivers))[1]


def press_apply(occluder: bpy.types.Object, *receivers: bpy.types.Object) -> None:
    """The button."""
    select(occluder, *receivers)
    assert bpy.ops.multibounce_ao.apply_field() == {"FINISHED"}


def field_generator(obj: bpy.types.Object, threads: int | None = None, **settings):
    """The same bake, not yet begun."""
    change_settings(**{**DRAFT, **settings})
    job = operators("field_job")
    return job.bake_object_field(bpy.context, obj, job.FieldSettings.of(bpy.context.scene), threads)


def report_of(obj: bpy.types.Object, **options):
    return operators("progress").drive(field_generator(obj, **options), lambda progress: None)


def fields_of(material: bpy.types.Material) -> list[str]:
    """Names of the field groups in a material."""
    return [node.node_tree.name for node in operators("field_nodes").fields_in(material)]
