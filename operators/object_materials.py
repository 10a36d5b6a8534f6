# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials of one object: made where there are none, made its own where it must not share, and put back."""

from __future__ import annotations

from collections.abc import Collection

import bpy

from .material_nodes import BakedSource, plug, unplug
from .names import PROPERTY

# On a material that we added: whether its slot was new too ("SLOT") or was there, empty ("MATERIAL").
_CREATED = "multibounce_ao_created"
# On an object's own copy of a shared material: the one it was copied from, and what its slot was linked to.
_ORIGINAL = "multibounce_ao_original"
_SLOT_LINK = "multibounce_ao_slot_link"


def plug_object(obj: bpy.types.Object, bounces: str, source: BakedSource) -> list[str]:
    """Plug the node group into all materials of ``obj``; returns warnings about those where it could not be.

    Images belong to one object. A material that other objects use too is therefore copied before an image goes into
    it; one that reads attributes stays shared, since each mesh brings its own.
    """
    warnings = []
    if not any(slot.material for slot in obj.material_slots):
        _create_material(obj)
    for slot in obj.material_slots:
        if slot.material is None:
            continue
        if source.images is not None and _used_by_others(slot.material, obj):
            _make_own(slot, obj)
        material = slot.material
        if material.library is not None:
            warnings.append(f"Material '{material.name}' is linked: make it local to plug the nodes in")
        elif not plug(material, bounces, source):
            warnings.append(f"Material '{material.name}' has no Principled BSDF: plug the node group in by hand")
    return warnings


def unplug_object(obj: bpy.types.Object, cleared: Collection[bpy.types.Object]) -> None:
    """Put the materials of ``obj`` back; nodes that a baked object outside ``cleared`` still shows stay."""
    for index in reversed(range(len(obj.material_slots))):
        slot = obj.material_slots[index]
        if slot.material is not None and slot.material.get(_ORIGINAL) is not None:
            _give_original_back(slot)
        material = slot.material
        if material is None or material.library is not None:
            continue
        if _has_copies(material) or any(PROPERTY in other for other in _users(material) if other not in cleared):
            continue
        if _CREATED not in material:
            unplug(material)
            continue
        if material[_CREATED] == "SLOT":
            _remove_slot(obj, index)
        else:
            slot.material = None
        if material.users == 0:
            bpy.data.materials.remove(material)


def _create_material(obj: bpy.types.Object) -> None:
    material = bpy.data.materials.new(obj.name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material[_CREATED] = "MATERIAL" if obj.material_slots else "SLOT"
    if obj.material_slots:
        obj.material_slots[0].material = material
    else:
        obj.data.materials.append(material)


def _remove_slot(obj: bpy.types.Object, index: int) -> None:
    """By the operator: ``materials.pop`` shortens the mesh's list and leaves the object's slot standing."""
    obj.active_material_index = index
    with bpy.context.temp_override(object=obj):
        bpy.ops.object.material_slot_remove()


def _make_own(slot: bpy.types.MaterialSlot, obj: bpy.types.Object) -> None:
    shared = slot.material
    own = shared.copy()
    own.name = f"{shared.name} {obj.name}"
    own[_ORIGINAL] = shared
    own[_SLOT_LINK] = slot.link
    if obj.data.users > 1:
        slot.link = "OBJECT"
    slot.material = own


def _give_original_back(slot: bpy.types.MaterialSlot) -> None:
    own = slot.material
    if own[_SLOT_LINK] == slot.link:
        slot.material = own[_ORIGINAL]
    else:
        # The mesh has kept the original: only the object's own place is emptied.
        slot.material = None
        slot.link = own[_SLOT_LINK]
    if own.users == 0:
        bpy.data.materials.remove(own)


def _users(material: bpy.types.Material) -> list[bpy.types.Object]:
    return [obj for obj in bpy.data.objects if any(slot.material == material for slot in obj.material_slots)]


def _used_by_others(material: bpy.types.Material, obj: bpy.types.Object) -> bool:
    return _has_copies(material) or any(other != obj for other in _users(material))


def _has_copies(material: bpy.types.Material) -> bool:
    """Whether objects have a copy of their own of ``material``: it is what they will get back."""
    return any(other.get(_ORIGINAL) == material for other in bpy.data.materials)
