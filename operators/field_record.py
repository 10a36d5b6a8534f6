# SPDX-License-Identifier: GPL-3.0-or-later
"""The record of an AO field on its object: which images show it, the numbers beside them, what the bake took.

Objects that share a mesh, with the same modifiers and proportions, share the field: each has the record, and the same
images serve all. Only the node group is an object's own, because it follows that object.
"""

from __future__ import annotations

from collections.abc import Collection

import bpy
import numpy as np
from numpy.typing import NDArray

from ..shader_nodes import ao_field
from .report import BakeError

FIELD = "multibounce_ao_field"
"""ID property: on objects the record of their field, on images, materials and nodes that they are ours."""

# Proportions that differ by less count as equal: float matrices of turned objects do, in the last digits.
SAME_PROPORTIONS = 1e-3


def proportions_of(matrix: NDArray) -> NDArray[np.float64]:
    """Scale along the object's axes over its mean, (3,); exactly 1 where a 4x4 ``matrix`` scales evenly.

    Raises BakeError where it shears: no scale along the axes makes up for that.
    """
    linear = np.asarray(matrix, np.float64)[:3, :3]
    scale = np.linalg.norm(linear, axis=0)
    axes = linear / scale
    if np.abs(axes.T @ axes - np.eye(3)).max() > SAME_PROPORTIONS:
        raise BakeError("is sheared by its parents: apply their scale, or clear the parent and keep the transform")
    proportions = scale / np.cbrt(scale.prod())
    return np.ones(3) if np.abs(proportions - 1.0).max() < SAME_PROPORTIONS else proportions


def has_changed(obj: bpy.types.Object) -> bool:
    """Whether the proportions of ``obj`` are no longer those that its field was baked for."""
    try:
        proportions = proportions_of(np.array(obj.matrix_world))
    except BakeError:
        return True
    return bool(np.abs(proportions - obj[FIELD]["proportions"]).max() > 2 * SAME_PROPORTIONS)


def is_uneven(obj: bpy.types.Object) -> bool:
    """Whether ``obj`` is scaled by more along one of its axes than along another, or sheared."""
    try:
        return bool((proportions_of(np.array(obj.matrix_world)) != 1.0).any())
    except BakeError:
        return True


def sharers(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """``obj`` and the objects that are the same shape: a field of one is a field of all."""
    return [obj, *(other for other in bpy.data.objects if other != obj and _same_shape(obj, other))]


def record_field(obj: bpy.types.Object, record: dict[str, object]) -> None:
    """Leave the ``record`` of a new field on ``obj`` and its :func:`sharers`, in place of older ones; the group of
    ``obj`` and those that sharers have show it."""
    objects = sharers(obj)
    replaced = recorded_images(objects)
    for each in objects:
        each[FIELD] = record
        if each == obj or ao_field.group_of(each) is not None:
            show_field(each)
    _remove_unused(replaced)


def show_field(obj: bpy.types.Object) -> bpy.types.ShaderNodeTree:
    """The node group of ``obj`` with the field of its record."""
    record, volume = obj[FIELD], None
    if "volume_image" in record:
        volume = ao_field.ShownVolume(record["volume_image"], record["volume_low"], record["volume_size"])
    tree = ao_field.ensure(obj, volume is not None)
    ao_field.show(tree, record["image"], record["numbers"].to_dict(), record["centre"], record["proportions"], volume)
    record["group"] = tree  # Blender saves it for this, where no material has it
    return tree


def has_field(obj: bpy.types.Object | None) -> bool:
    """Whether ``obj`` has a field that is whole: the artist may have removed its images."""
    return obj is not None and FIELD in obj and None not in _images(obj)


def remove_fields(objects: Collection[bpy.types.Object]) -> None:
    """Take records, images and node groups of ``objects`` away; materials must be without them. Files on disk stay."""
    images = recorded_images(objects)
    for obj in objects:
        obj.pop(FIELD, None)
        tree = ao_field.group_of(obj)
        if tree is not None:
            bpy.data.node_groups.remove(tree)
    _remove_unused(images)


def recorded_images(objects: Collection[bpy.types.Object]) -> set[bpy.types.Image]:
    return {image for obj in objects if FIELD in obj for image in _images(obj) if image is not None}


def _images(obj: bpy.types.Object) -> list[bpy.types.Image | None]:
    """Of the field of ``obj``; None for those that are gone."""
    record = obj[FIELD]
    return [record.get("image"), *([record["volume_image"]] if "volume_image" in record else [])]


def _remove_unused(images: set[bpy.types.Image]) -> None:
    for image in images - recorded_images(bpy.data.objects):
        bpy.data.images.remove(image)


def _same_shape(obj: bpy.types.Object, other: bpy.types.Object) -> bool:
    if other.data != obj.data or other.library is not None or _modifiers(other) != _modifiers(obj):
        return False
    try:
        one, two = (proportions_of(np.array(each.matrix_world)) for each in (obj, other))
    except BakeError:
        return False
    return bool(np.abs(one - two).max() < 2 * SAME_PROPORTIONS)


def _modifiers(obj: bpy.types.Object) -> list[tuple]:
    return [(modifier.type, modifier.name, modifier.show_viewport) for modifier in obj.modifiers]
