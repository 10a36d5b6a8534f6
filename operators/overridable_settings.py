# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings that an object or a collection may override: the scene's settings and the overrides both have them."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

# A library override of an object may have its own, too.
IN_LIBRARY_OVERRIDES = {"LIBRARY_OVERRIDABLE"}


class OverridableSettings:
    """To be derived from before ``bpy.types.PropertyGroup``."""

    target: EnumProperty(
        name="Target",
        description="Where the result is stored",
        items=(
            ("VERTEX", "Vertices", "Color attributes on the mesh"),
            ("TEXTURE", "Texture", "Images, through a UV map"),
        ),
        default="VERTEX",
        override=IN_LIBRARY_OVERRIDES,
    )
    samples: IntProperty(
        name="Samples",
        description="Rays traced from each point: 16 for a draft, 256 are clean, 1024 for what is looked at closely",
        default=256,
        min=1,
        max=2**16,
        soft_min=16,
        soft_max=4096,
        override=IN_LIBRARY_OVERRIDES,
    )
    use_material_nodes: BoolProperty(
        name="Material Nodes",
        description="Plug the result into the materials of the baked objects",
        default=True,
        override=IN_LIBRARY_OVERRIDES,
    )
    occluders: EnumProperty(
        name="Occluders",
        description="Which objects block rays",
        items=(
            ("SELF", "Self", "Only the baked object, with the instances it makes"),
            ("SELECTED", "Selected", "The selected objects"),
            ("VISIBLE", "Visible", "All objects that are visible and enabled in renders"),
        ),
        default="VISIBLE",
        override=IN_LIBRARY_OVERRIDES,
    )
    ignore_backfaces: BoolProperty(
        name="Ignore Backfaces",
        description="Let rays pass through faces that they hit from behind",
        default=False,
        override=IN_LIBRARY_OVERRIDES,
    )
    max_distance: FloatProperty(
        name="Max Distance",
        description="Surfaces further away do not occlude. 0: no limit",
        default=0.0,
        min=0.0,
        soft_max=100.0,
        subtype="DISTANCE",
        unit="LENGTH",
        override=IN_LIBRARY_OVERRIDES,
    )
    falloff: EnumProperty(
        name="Falloff",
        description="How occlusion fades with the distance of what occludes, up to Max Distance",
        items=(
            ("NONE", "None", "Everything within Max Distance occludes fully"),
            ("LINEAR", "Linear", "Fades evenly from full at contact to nothing at Max Distance"),
            ("SMOOTH", "Smooth", "As Linear, eased at both ends"),
        ),
        default="NONE",
        override=IN_LIBRARY_OVERRIDES,
    )
    resolution: IntProperty(
        name="Resolution",
        description="Width and height of the images",
        default=1024,
        min=1,
        max=16384,
        soft_min=64,
        soft_max=8192,
        subtype="PIXEL",
        override=IN_LIBRARY_OVERRIDES,
    )
    margin: IntProperty(
        name="Margin",
        description="How far the result extends past the edges of UV islands",
        default=16,
        min=0,
        max=32767,
        soft_max=64,
        subtype="PIXEL",
        override=IN_LIBRARY_OVERRIDES,
    )
    margin_type: EnumProperty(
        name="Margin Type",
        description="How the result is extended",
        items=(
            ("ADJACENT_FACES", "Adjacent Faces", "Use pixels from adjacent faces across UV seams"),
            ("EXTEND", "Extend", "Extend border pixels outwards"),
        ),
        default="ADJACENT_FACES",
        override=IN_LIBRARY_OVERRIDES,
    )
    uv_map: StringProperty(
        name="UV Map",
        description="UV map to bake into. Empty: the one that is active for rendering",
        override=IN_LIBRARY_OVERRIDES,
    )
    use_udim: BoolProperty(
        name="UDIM Tiles",
        description="Bake every UDIM tile that the UV map reaches into, to tiled images",
        default=False,
        override=IN_LIBRARY_OVERRIDES,
    )
    cage_object: PointerProperty(
        type=bpy.types.Object,
        name="Cage Object",
        description="Object to use as cage instead of calculating the cage from the active object with cage extrusion",
        poll=lambda self, obj: obj.type == "MESH",
        override=IN_LIBRARY_OVERRIDES,
    )
    cage_extrusion: FloatProperty(
        name="Cage Extrusion",
        description="Inflate the active object by the specified distance for baking. This helps matching to points "
        "nearer to the outside of the selected object meshes",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        subtype="DISTANCE",
        unit="LENGTH",
        override=IN_LIBRARY_OVERRIDES,
    )
    max_ray_distance: FloatProperty(
        name="Max Ray Distance",
        description="The maximum ray distance for matching points between the active and selected objects. If zero, "
        "there is no limit",
        default=0.0,
        min=0.0,
        soft_max=1.0,
        subtype="DISTANCE",
        unit="LENGTH",
        override=IN_LIBRARY_OVERRIDES,
    )
    field_resolution: IntProperty(
        name="Resolution",
        description="Texels along the faces of the AO field's cubemaps: 16 for most, 32 or 64 for intricate shapes",
        default=16,
        min=8,
        max=64,
        subtype="PIXEL",
        override=IN_LIBRARY_OVERRIDES,
    )
    use_field_volume: BoolProperty(
        name="Volume",
        description=(
            "Also measure 16 x 16 x 16 places within the object's convex hull, for what stands under, in or between "
            "its parts. Its node group has half as many nodes again"
        ),
        default=False,
        override=IN_LIBRARY_OVERRIDES,
    )


OVERRIDABLE = tuple(OverridableSettings.__annotations__)
"""Their names."""
