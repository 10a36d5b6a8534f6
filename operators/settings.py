# SPDX-License-Identifier: GPL-3.0-or-later
"""``scene.multibounce_ao``: the settings that every operator and the command line read."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .overridable_settings import OverridableSettings


class MultibounceAOSettings(OverridableSettings, bpy.types.PropertyGroup):
    use_ground_plane: BoolProperty(
        name="Ground Plane",
        description="Add an infinite floor under the lowest point of the baked objects",
        default=False,
    )
    bounces: EnumProperty(
        name="Bounces",
        description="How the light that comes from other surfaces is found",
        items=(
            ("FITTED", "Fitted", "By Patapom's published fit, from ambient occlusion alone"),
            ("BAKED", "Baked", "Measured at each point: light that bounces off all occluders"),
            ("RADIOSITY", "Radiosity", "As Baked, in the base colors that the occluders have now: colors bleed"),
        ),
        default="BAKED",
    )
    seed: IntProperty(
        name="Seed",
        description="Seed of the random directions of rays. Change it for another pattern of noise",
        default=0,
        min=0,
    )
    output_directory: StringProperty(
        name="Output",
        description="Folder for images and bounce curves. Empty: they are packed in the .blend",
        subtype="DIR_PATH",
        # Said since 4.5, which warns of "//" without it; 4.2 does not know the word.
        options={"PATH_SUPPORTS_BLEND_RELATIVE"} if bpy.app.version >= (4, 5, 0) else set(),
    )
    use_bent_normal_map: BoolProperty(
        name="Bent Normal Map",
        description="Write the middle of what each texel sees as a normal map too, for other programs",
        default=False,
    )
    bent_normal_space: EnumProperty(
        name="Space",
        description="Space of the bent normal map",
        items=(
            ("OBJECT", "Object", "Bake the bent normals in object space"),
            ("TANGENT", "Tangent", "Bake the bent normals in tangent space, as most programs read normal maps"),
        ),
        default="TANGENT",
    )
    bent_normal_y: EnumProperty(
        name="Swizzle G",
        description="Axis of the green channel of the bent normal map",
        items=(
            ("POS_Y", "+Y (OpenGL)", "Up the image, as in Blender, glTF, Unity and Godot"),
            ("NEG_Y", "-Y (DirectX)", "Down the image, as in Unreal Engine"),
        ),
        default="POS_Y",
    )
    color_depth: EnumProperty(
        name="Color Depth",
        description="Bits of each channel of the OpenEXR files. Packed images have full floats",
        items=(
            ("16", "Float (Half)", "16-bit floats: half the size, off by at most .00025"),
            ("32", "Float (Full)", "32-bit floats: without rounding"),
        ),
        default="32",
    )
    exr_codec: EnumProperty(
        name="Codec",
        description="Compression of the OpenEXR files, of packed tiles and maps too. All of these keep every bit",
        items=(
            ("NONE", "None", "No compression"),
            ("RLE", "RLE", "Lossless run length encoding compression"),
            ("ZIPS", "ZIPS", "Lossless zip compression, each image row compressed separately"),
            ("ZIP", "ZIP", "Lossless zip compression of 16 row image blocks"),
            ("PIZ", "PIZ", "Lossless wavelet compression, effective for noisy images"),
        ),
        default="ZIP",
    )
    use_ao_map: BoolProperty(
        name="AO Map",
        description="Write a grayscale map of ambient occlusion too, for other programs",
        default=False,
    )
    use_colored_ao_map: BoolProperty(
        name="Colored AO Map",
        description="Write the light of all bounces too, in the base color that the material has now. Other programs "
        "multiply the base color by it",
        default=False,
    )
    map_format: EnumProperty(
        name="Map Format",
        description="File format of the maps for other programs",
        items=(
            ("PNG_8", "PNG (8-bit)", "256 steps a channel"),
            ("PNG_16", "PNG (16-bit)", "65536 steps a channel"),
            ("OPEN_EXR", "OpenEXR", "Floats, with the color depth and codec chosen here"),
        ),
        default="PNG_8",
    )
    use_gltf_occlusion: BoolProperty(
        name="glTF Occlusion",
        description="Plug the AO map into the Occlusion of a node group 'glTF Material Output', so that glTF exports "
        "carry it",
        default=False,
    )
    use_selected_to_active: BoolProperty(
        name="Selected to Active",
        description="Bake what the surfaces of the other selected objects see onto the active one",
        default=False,
    )
    use_match_names: BoolProperty(
        name="Match Names",
        description="Bake every selected object 'Name_high' onto the selected 'Name_low', all pairs at once. The other "
        "pairs cast no shadow, unless Occluders is Selected",
        default=False,
    )
    height_map: PointerProperty(
        type=bpy.types.Image,
        name="Height Map",
        description="Image that bounce curves are simulated on, as relief that repeats. Empty: the active object",
        poll=lambda self, image: image.source != "VIEWER",
    )
    height_map_amplitude: FloatProperty(
        name="Amplitude",
        description="Height of white over black in the height map, as a fraction of its width",
        default=0.04,
        min=0.0,
        soft_max=0.5,
        precision=3,
        subtype="FACTOR",
    )


@dataclass(frozen=True)
class BakeSettings:
    """A copy of the settings at the moment a bake starts, so that nothing changes under it."""

    target: str
    samples: int
    max_distance: float
    falloff: str
    occluders: str
    use_ground_plane: bool
    ignore_backfaces: bool
    bounces: str
    use_material_nodes: bool
    seed: int
    resolution: int
    margin: int
    margin_type: str
    use_udim: bool
    uv_map: str
    output_directory: str
    use_bent_normal_map: bool
    bent_normal_space: str
    bent_normal_y: str
    color_depth: str
    exr_codec: str
    use_ao_map: bool
    use_colored_ao_map: bool
    map_format: str
    use_gltf_occlusion: bool
    use_selected_to_active: bool
    use_match_names: bool
    cage_object: bpy.types.Object | None
    cage_extrusion: float
    max_ray_distance: float

    @classmethod
    def of(cls, scene: bpy.types.Scene) -> BakeSettings:
        return cls(**{name: getattr(scene.multibounce_ao, name) for name in cls.__dataclass_fields__})

    def as_property(self) -> dict[str, object]:
        """The settings as values that an ID property and JSON hold: objects by their names."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        if self.cage_object is None:
            return values | {"cage_object": ""}
        return values | {"cage_object": self.cage_object.name}


def add_to_scene() -> None:
    bpy.types.Scene.multibounce_ao = PointerProperty(type=MultibounceAOSettings, name="Multibounce AO")


def remove_from_scene() -> None:
    del bpy.types.Scene.multibounce_ao
