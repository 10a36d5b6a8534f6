# SPDX-License-Identifier: GPL-3.0-or-later
"""The materials of one object: made where there are none, made its own where it must not share, and put back."""

from __future__ import annotations

from collections.abc import Collection

import bpy

from .field_nodes import fields_in
from .gltf_occlusion import plug_occlusion, unplug_occlusion
from .material_nodes import BakedSource, groups_in, plug, shows, unplug
from .material_tree import can_plug, turn_nodes_on
from .names import PROPERTY

# On a material that we added: whether its slot was new too ("SLOT") or was there, empty ("MATERIAL").
_CREATED = "multibounce_ao_created"
# On an object's own copy of a shared material: the one it was copied from, and what its slot was linked to.
_ORIGINAL = "multibounce_ao_original"
_SLOT_LINK = "multibounce_ao_slot_link"


def plug_object(obj: bpy.types.Object, bounces: str, source: BakedSource) -> list[str]:
    """Plug the node group into all materials of ``obj``; returns warnings about those where it could not be."""
    if not any(slot.material for slot in obj.material_slots):
        create_material(obj)
    warnings = [plug_slot(slot, obj, bounces, source) for slot in obj.material_slots if slot.material]
    return [warning for warning in warnings if warning]


def plug_object_occlusion(obj: bpy.types.Object, image: bpy.types.Image | None, uv_map: str) -> list[str]:
    """Let glTF exports of all materials of ``obj`` carry ``image`` as occlusion, None: none of ours any longer; returns
    warnings about those where it could not be."""
    if image is not None and not any(slot.material for slot in obj.material_slots):
        create_material(obj)
    warnings = []
    for slot in obj.material_slots:
        material = slot.material
        if material is None or (image is None and material.node_tree is None):
            continue
        if material.library is not None:
            if image is not None:
                warnings.append(f"Material '{material.name}' is linked: make it local for its occlusion in glTF")
        elif image is None:
            unplug_occlusion(material.node_tree)
        else:
            if _used_by_others(material, obj):
                material = _make_own(slot, obj)
            turn_nodes_on(material)
            warnings += [warning for warning in [plug_occlusion(material, image, uv_map)] if warning]
    return warnings


def plug_slot(
    slot: bpy.types.MaterialSlot, obj: bpy.types.Object, bounces: str, source: BakedSource | None
) -> str | None:
    """Plug the node group into the material of one ``slot`` of ``obj``; returns a warning where it could not be.

    Images belong to one object. A material that other objects use too is therefore copied before an image goes into
    it, or out of it; one that reads attributes stays shared, since each mesh brings its own.
    """
    material = slot.material
    if material.library is not None:
        return f"Material '{material.name}' is linked: make it local to plug the nodes in"
    if not can_plug(material):
        return f"Material '{material.name}' has no Principled BSDF: add one, or plug the node group in by hand"
    has_images = source is not None and (source.images is not None or shows(material, bpy.data.images.values()))
    if has_images and _used_by_others(material, obj):
        material = _make_own(slot, obj)
    plug(material, bounces, source)
    return None


def unplug_objects(objects: Collection[bpy.types.Object]) -> None:
    """Put the materials of ``objects`` back; what another baked object still shows stays."""
    cleared = set(objects)
    # First the copies of all: they stand over slots of a mesh that several objects may share.
    for obj in objects:
        for index in _slots_to_clear(obj, cleared):
            while _is_own(obj.material_slots[index]):
                _give_original_back(obj.material_slots[index])
    for obj in objects:
        for material in {obj.material_slots[index].material for index in _slots_to_clear(obj, cleared)}:
            if material is None or material.library is not None:
                continue
            if not any(PROPERTY in other for other in users_of(material) if other not in cleared):
                unplug(material)
                remove_if_created(material, cleared)


def unplug_images(images: Collection[bpy.types.Image]) -> None:
    """Take our nodes out of the materials that read ``images``, which are about to be removed."""
    for material in bpy.data.materials:
        if shows(material, images):
            unplug(material)


def mesh_is_baked(mesh: bpy.types.Mesh, cleared: Collection[bpy.types.Object]) -> bool:
    """Whether an object outside ``cleared`` that uses ``mesh`` is baked."""
    return any(obj.data == mesh and PROPERTY in obj for obj in bpy.data.objects if obj not in cleared)


def users_of(material: bpy.types.Material) -> list[bpy.types.Object]:
    """The objects that show ``material``."""
    return [obj for obj in bpy.data.objects if any(slot.material == material for slot in obj.material_slots)]


def create_material(obj: bpy.types.Object) -> None:
    """Give ``obj``, which has none, a material."""
    material = bpy.data.materials.new(obj.name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    material[_CREATED] = "MATERIAL" if obj.material_slots else "SLOT"
    if obj.material_slots:
        obj.material_slots[0].material = material
    else:
        obj.data.materials.append(material)


def remove_if_created(material: bpy.types.Material, objects: Collection[bpy.types.Object]) -> None:
    """Take ``material`` away from ``objects``, if we made it and nothing of ours is left in it."""
    if _CREATED not in material or groups_in(material) or fields_in(material):
        return
    for obj in objects:
        for index in reversed(range(len(obj.material_slots))):
            if obj.material_slots[index].material != material:
                continue
            if material[_CREATED] == "SLOT":
                # By the operator: ``materials.pop`` shortens the mesh's list and leaves the object's slot standing.
                obj.active_material_index = index
                with bpy.context.temp_override(object=obj, active_object=obj):
                    if bpy.ops.object.material_slot_remove.poll():
                        bpy.ops.object.material_slot_remove()
                    else:  # of a library override
                        obj.data.materials.pop(index=index)
            else:
                obj.material_slots[index].material = None
    if material.users == 0:
        bpy.data.materials.remove(material)


def _slots_to_clear(obj: bpy.types.Object, cleared: Collection[bpy.types.Object]) -> list[int]:
    """Not those of a mesh that another object still shows baked."""
    keep_mesh = mesh_is_baked(obj.data, cleared)
    return [index for index, slot in enumerate(obj.material_slots) if not (keep_mesh and slot.link == "DATA")]


def _make_own(slot: bpy.types.MaterialSlot, obj: bpy.types.Object) -> bpy.types.Material:
    shared = slot.material
    own = shared.copy()
    own.name = f"{shared.name} {obj.name}"
    own[_ORIGINAL] = shared
    own[_SLOT_LINK] = slot.link
    if any(other.data == obj.data for other in bpy.data.objects if other != obj):
        slot.link = "OBJECT"
    slot.material = own
    return own


def _is_own(slot: bpy.types.MaterialSlot) -> bool:
    return slot.material is not None and slot.material.get(_ORIGINAL) is not None


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


def _used_by_others(material: bpy.types.Material, obj: bpy.types.Object) -> bool:
    return _has_copies(material) or any(other != obj for other in users_of(material))


def _has_copies(material: bpy.types.Material) -> bool:
    """Whether objects have a copy of their own of ``material``: it is what they will get back."""
    return any(other.get(_ORIGINAL) == material and users_of(other) for other in bpy.data.materials)
