# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that receive AO fields: into their materials, made where there are none, and out again."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import bpy

from ..shader_nodes import ao_field
from .field_nodes import fields_in, receive, release
from .field_record import FIELD, has_changed, remove_fields, show_field
from .material_tree import can_plug
from .object_materials import create_material, remove_if_created, users_of
from .occluder_reader import SURFACE_TYPES

RECEIVES = "multibounce_ao_receives"
"""ID property: on objects that fields were applied to."""


def apply_field(
    occluder: bpy.types.Object, objects: Sequence[bpy.types.Object]
) -> tuple[list[bpy.types.Object], list[str]]:
    """Make ``objects`` receive the field of ``occluder``, which has one.

    Returns the objects that do, and warnings: what could not receive it, and what receives it unasked, because it
    shares a material.
    """
    warnings = []
    if has_changed(occluder):
        warnings.append(
            f"Object '{occluder.name}' has other proportions than when its field was baked: bake it again, or put its "
            "scale back"
        )
    group, receivers, materials = show_field(occluder), [], {}
    for obj in objects:
        problem = _problem(obj)
        if problem:
            warnings.append(f"Object '{obj.name}' {problem}")
            continue
        if not any(slot.material for slot in obj.material_slots):
            create_material(obj)
        own = [slot.material for slot in obj.material_slots if slot.material]
        refused = {material: reason for material in own if (reason := _refusal(material))}
        warnings += [f"Object '{obj.name}': {reason}" for reason in refused.values()]
        materials |= dict.fromkeys(material for material in own if material not in refused)
        if len(refused) < len(set(own)):
            receivers.append(obj)
    for material in materials:
        receive(material, group)
    for obj in receivers:
        obj[RECEIVES] = True
    return receivers, warnings + _shared(materials, occluder)


def clear_fields(objects: Sequence[bpy.types.Object]) -> None:
    """Take the fields that ``objects`` receive out of their materials, unless another receiver shows them too, and the
    fields that ``objects`` have out of every material and the file."""
    cleared = set(objects)
    receivers = [obj for obj in bpy.data.objects if RECEIVES in obj]
    for obj in objects:
        obj.pop(RECEIVES, None)
    groups = {group for obj in objects if (group := ao_field.group_of(obj)) is not None}
    for material in list(bpy.data.materials):
        users = users_of(material)
        if not fields_in(material) or material.library is not None:
            continue
        if cleared.isdisjoint(users) or any(RECEIVES in user for user in users):
            release(material, groups)
        else:
            release(material)
        remove_if_created(material, receivers)
    remove_fields([obj for obj in objects if FIELD in obj])
    for obj in bpy.data.objects:
        if RECEIVES in obj and not any(slot.material and fields_in(slot.material) for slot in obj.material_slots):
            del obj[RECEIVES]


def _problem(obj: bpy.types.Object) -> str | None:
    """Why ``obj`` cannot receive a field at all."""
    if obj.type not in SURFACE_TYPES:
        return "has no surface to darken: select meshes, curves or text"
    if obj.library is not None or obj.data.library is not None:
        return "is linked from a library: make it local (Object > Relations > Make Local)"
    return None


def _refusal(material: bpy.types.Material) -> str | None:
    if material.library is not None:
        return f"material '{material.name}' is linked: make it local for it to receive the field"
    if not can_plug(material):
        return f"material '{material.name}' has no Principled BSDF: add one, or connect the node group by hand"
    return None


def _shared(materials: Collection[bpy.types.Material], occluder: bpy.types.Object) -> list[str]:
    """A warning a material that darkens objects which were not asked to receive."""
    warnings = []
    for material in materials:
        others = [user for user in users_of(material) if RECEIVES not in user]
        if not others:
            continue
        names = ", ".join(f"'{other.name}'" for other in others[:3]) + (" and others" if len(others) > 3 else "")
        itself = ", which so darkens itself" if occluder in others else ""
        warnings.append(
            f"Material '{material.name}' is also on {names}{itself}: "
            "for them to stay as they are, make it single-user (Object > Relations > Make Single User)"
        )
    return warnings
