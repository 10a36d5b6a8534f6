# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that an object or a collection has of its own, in place of the scene's.

For each setting by itself: the object's own comes first, then that of its innermost collection that has one (of several
alike the first in the Outliner), then the scene's. Collections that the view layer excludes do not count.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import fields, replace
from typing import TypeVar

import bpy
from bpy.props import BoolProperty, PointerProperty

from .overridable_settings import IN_LIBRARY_OVERRIDES, OVERRIDABLE, OverridableSettings

SWITCH = "override_"
"""Before the name of a setting: of the property that says whether it is overridden."""

Settings = TypeVar("Settings")


def _switch(name: str, description: str):
    return BoolProperty(
        name=f"Override {name}",
        description=f"{description}, in place of the scene's setting",
        default=False,
        override=IN_LIBRARY_OVERRIDES,
    )


class MultibounceAOOverrides(OverridableSettings, bpy.types.PropertyGroup):
    override_target: _switch("Target", "Choose here where the result is stored")
    override_samples: _switch("Samples", "Trace this many rays from each point here")
    override_use_material_nodes: _switch(
        "Material Nodes", "Choose here whether the result is plugged into the materials"
    )
    override_occluders: _switch("Occluders", "Choose here which objects block rays")
    override_ignore_backfaces: _switch(
        "Ignore Backfaces", "Choose here whether rays pass through faces that they hit from behind"
    )
    override_max_distance: _switch("Max Distance", "Let surfaces occlude up to this distance here")
    override_falloff: _switch("Falloff", "Let occlusion fade with distance in this way here")
    override_resolution: _switch("Resolution", "Bake images of this width and height here")
    override_margin: _switch("Margin", "Extend the result this far past the edges of UV islands here")
    override_margin_type: _switch("Margin Type", "Extend the result past the edges of UV islands in this way here")
    override_uv_map: _switch("UV Map", "Bake into this UV map here")
    override_use_udim: _switch(
        "UDIM Tiles", "Choose here whether every UDIM tile is baked that the UV map reaches into"
    )
    override_cage_object: _switch("Cage Object", "Bake with this cage object here")
    override_cage_extrusion: _switch("Cage Extrusion", "Inflate the cage by this distance here")
    override_max_ray_distance: _switch("Max Ray Distance", "Match points up to this distance here")
    override_field_resolution: _switch("Field Resolution", "Bake AO fields of this resolution here")
    override_use_field_volume: _switch(
        "Field Volume", "Choose here whether AO fields also measure the inside of the convex hull"
    )


def overridden(owner: bpy.types.Object | bpy.types.Collection) -> dict[str, object]:
    """The settings that ``owner`` has of its own.

    No method of the property group: with one, Blender 4.2 as a Python module does not come to its end.
    """
    overrides = owner.multibounce_ao_overrides
    return {name: getattr(overrides, name) for name in OVERRIDABLE if getattr(overrides, SWITCH + name)}


class Overrides:
    """What holds for which object of a view layer; of its collections, what they have when this is made."""

    def __init__(self, view_layer: bpy.types.ViewLayer, fixed: Collection[str] = ()):
        """``fixed``: settings that nothing overrides."""
        self._fixed = fixed
        # The innermost first; sorting keeps the Outliner's order among those that are as deep.
        found = sorted(_collections(view_layer.layer_collection), key=lambda each: -each[0])
        values = ((collection, overridden(collection)) for _, collection in found)
        self._collections = [(frozenset(each.all_objects), chosen) for each, chosen in values if chosen]

    def settings_for(self, obj: bpy.types.Object, settings: Settings) -> Settings:
        """``settings``, a dataclass, as ``obj`` is to be baked with them."""
        chosen: dict[str, object] = {}
        for objects, values in reversed(self._collections):
            if obj in objects:
                chosen |= values
        chosen |= overridden(obj)
        if not chosen:  # the panel asks for many objects whenever it is drawn
            return settings
        names = {field.name for field in fields(settings)}.difference(self._fixed)
        return replace(settings, **{name: value for name, value in chosen.items() if name in names})


def _collections(layer: bpy.types.LayerCollection, depth: int = 0) -> Iterator[tuple[int, bpy.types.Collection]]:
    """Those inside ``layer``, with how deep they are, in the Outliner's order."""
    for child in layer.children:
        if not child.exclude:
            yield depth, child.collection
        yield from _collections(child, depth + 1)


class MULTIBOUNCE_AO_OT_clear_overrides(bpy.types.Operator):
    """Let everything here follow the scene's settings again"""

    bl_idname = "multibounce_ao.clear_overrides"
    bl_label = "Clear Overrides"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """In the panel alone, which says whose overrides are meant."""
        overrides = getattr(context, "multibounce_ao_overrides", None)
        return overrides is not None and overrides.id_data.library is None

    def execute(self, context: bpy.types.Context) -> set[str]:
        for name in OVERRIDABLE:
            context.multibounce_ao_overrides.property_unset(SWITCH + name)
            context.multibounce_ao_overrides.property_unset(name)
        return {"FINISHED"}


def register() -> None:
    for owner in (bpy.types.Object, bpy.types.Collection):
        owner.multibounce_ao_overrides = PointerProperty(
            type=MultibounceAOOverrides, name="Multibounce AO Overrides", override=IN_LIBRARY_OVERRIDES
        )


def unregister() -> None:
    for owner in (bpy.types.Object, bpy.types.Collection):
        del owner.multibounce_ao_overrides
