# SPDX-License-Identifier: GPL-3.0-or-later
"""What gives a material its base colour, as far as it can be known without a renderer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Euler
from numpy.typing import NDArray

from ..core.albedo import GREY, Extension
from .image_pixels import AlphaUse, alpha_use, check_image
from .node_origins import Groups, UnreadableError, is_our_group, origin_of

RGB = tuple[float, float, float]

# Shaders that scatter light diffusely, by the input that colours it; and those that have no such light.
_DIFFUSE = {
    "ShaderNodeBsdfPrincipled": "Base Color",
    "ShaderNodeBsdfDiffuse": "Color",
    "ShaderNodeSubsurfaceScattering": "Color",
}
_NOT_DIFFUSE = {
    "ShaderNodeBsdfAnisotropic",
    "ShaderNodeBsdfGlass",
    "ShaderNodeBsdfGlossy",
    "ShaderNodeBsdfMetallic",
    "ShaderNodeBsdfRefraction",
    "ShaderNodeBsdfTransparent",
    "ShaderNodeEmission",
    "ShaderNodeHoldout",
}


@dataclass(frozen=True)
class ImageColour:
    """The pixels of ``image`` through ``uv_map`` (empty: the one active for render), whose coordinates (u, v, 1) the
    ``mapping`` (2, 3) moves; ``alpha`` as :func:`.image_pixels.alpha_use` has it."""

    image: bpy.types.Image
    extension: Extension
    is_closest: bool
    alpha: AlphaUse
    uv_map: str
    mapping: NDArray[np.float64]


@dataclass(frozen=True)
class AttributeColour:
    """The mesh's attribute ``name``, None: the colour attribute that is active for render."""

    name: str | None


@dataclass(frozen=True)
class BaseColor:
    """``scale`` times what ``source`` gives, plus ``offset``, linear RGB; ``offset`` alone where there is no source."""

    source: ImageColour | AttributeColour | None
    scale: RGB = (1.0, 1.0, 1.0)
    offset: RGB = (0.0, 0.0, 0.0)

    def times_plus(self, scale: Sequence[float] | float, offset: Sequence[float] | float = 0.0) -> BaseColor:
        """This times ``scale`` plus ``offset``, each a number or an RGB."""
        return BaseColor(self.source, _rgb(np.array(self.scale) * scale), _rgb(np.array(self.offset) * scale + offset))


def constant(value: Sequence[float] | float) -> BaseColor:
    """One colour everywhere: a number, RGB or RGBA, of which alpha does not count."""
    return BaseColor(None, (0.0, 0.0, 0.0), _rgb(value))


def read_base_color(material: bpy.types.Material | None) -> tuple[BaseColor, str | None]:
    """Base colour of ``material``, None: an empty slot; and a warning where it is not quite that.

    Base Color of a Principled BSDF, less what its constant Metallic takes; Color of a Diffuse BSDF or a Subsurface
    Scattering. The first of them counts where shaders are mixed. Emission, glossy and transparent shaders alone: black.
    Behind our node group, what comes into it counts, as if light were not baked. What cannot be read is stood in for by
    the viewport colour.
    """
    if material is None:
        return constant(GREY), None
    tree = material.node_tree
    if tree is None or not (bpy.app.version >= (5, 0, 0) or material.use_nodes):
        return constant(material.diffuse_color), None
    try:
        return _surface_colour(material, tree)
    except UnreadableError as unreadable:
        return constant(material.diffuse_color), unreadable_warning(material, unreadable)


def unreadable_warning(material: bpy.types.Material, unreadable: UnreadableError) -> str:
    return (
        f"Material '{material.name}' has its base color from {unreadable}, which cannot be read: "
        f"its viewport color was taken; {unreadable.remedy}"
    )


def _surface_colour(material: bpy.types.Material, tree: bpy.types.ShaderNodeTree) -> tuple[BaseColor, str | None]:
    output = tree.get_output_node("CYCLES")
    shaders = [] if output is None else _shaders(output.inputs["Surface"], ())
    others = []
    for node, groups in shaders:
        if node.bl_idname not in _DIFFUSE:
            others.append(node)
            continue
        colour, warning = _colour(node.inputs[_DIFFUSE[node.bl_idname]], groups), None
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            try:
                colour = colour.times_plus(1.0 - min(max(_number(node.inputs["Metallic"], groups), 0.0), 1.0))
            except UnreadableError as unreadable:
                warning = (
                    f"Material '{material.name}' has its Metallic from {unreadable}, which is not read: it counts as 0;"
                    f" where it is a metal, set it to a number or darken the base color"
                )
        return colour, warning
    if others and all(node.bl_idname in _NOT_DIFFUSE for node in others):
        return constant(0.0), None
    if others:
        raise UnreadableError(f"the node '{others[0].name}'")
    raise UnreadableError("no shader", "connect a Principled BSDF to the output")


def _shaders(socket: bpy.types.NodeSocket, groups: Groups) -> Iterator[tuple[bpy.types.Node, Groups]]:
    origin, groups = origin_of(socket, groups)
    if not origin.is_output:
        return
    if origin.node.bl_idname in ("ShaderNodeMixShader", "ShaderNodeAddShader"):
        for each in origin.node.inputs:
            if each.type == "SHADER":
                yield from _shaders(each, groups)
    else:
        yield origin.node, groups


def _colour(socket: bpy.types.NodeSocket, groups: Groups) -> BaseColor:
    origin, groups = origin_of(socket, groups)
    if not origin.is_output:
        return constant(origin.default_value)
    node, kind, output = origin.node, origin.node.bl_idname, origin.name
    if kind in ("ShaderNodeRGB", "ShaderNodeValue"):
        return constant(origin.default_value)
    if kind in ("ShaderNodeMix", "ShaderNodeMixRGB"):
        return _mixed(node, groups)
    if kind == "ShaderNodeTexImage" and output == "Color":
        return BaseColor(_image(node, groups))
    if kind == "ShaderNodeAttribute" and output == "Color" and node.attribute_type == "GEOMETRY":
        return BaseColor(AttributeColour(node.attribute_name))
    if kind == "ShaderNodeVertexColor" and output == "Color":
        return BaseColor(AttributeColour(node.layer_name or None))
    if is_our_group(node):
        return _colour(node.inputs["Base Color"], groups) if output == "Color" else constant(1.0)
    raise UnreadableError(f"the node '{node.name}'")


def _mixed(node: bpy.types.Node, groups: Groups) -> BaseColor:
    """A Mix of which one side, at least, is constant: by blend type Mix or Multiply."""
    unreadable = UnreadableError(f"the node '{node.name}'")
    if node.bl_idname == "ShaderNodeMixRGB":
        (factor, first, second), is_clamped = node.inputs, True
    elif node.data_type == "RGBA":
        inputs = {socket.identifier: socket for socket in node.inputs}
        factor, first, second = (inputs[name] for name in ("Factor_Float", "A_Color", "B_Color"))
        is_clamped = node.clamp_factor
    else:
        raise unreadable
    f = _number(factor, groups)
    f = min(max(f, 0.0), 1.0) if is_clamped else f
    if f == 0.0:
        return _colour(first, groups)
    if node.blend_type == "MIX" and f == 1.0:
        return _colour(second, groups)
    a, b = _colour(first, groups), _colour(second, groups)
    if a.source is not None and b.source is not None:
        raise unreadable
    if node.blend_type == "MIX":  # (1 - f) a + f b
        if b.source is None:
            return a.times_plus(1.0 - f, f * np.array(b.offset))
        return b.times_plus(f, (1.0 - f) * np.array(a.offset))
    if node.blend_type == "MULTIPLY":  # (1 - f) a + f a b
        if b.source is None:
            return a.times_plus(1.0 - f + f * np.array(b.offset))
        return b.times_plus(f * np.array(a.offset), (1.0 - f) * np.array(a.offset))
    raise unreadable


def _number(socket: bpy.types.NodeSocket, groups: Groups) -> float:
    colour = _colour(socket, groups)
    if colour.source is not None or len(set(colour.offset)) > 1:
        raise UnreadableError(f"'{socket.name}' of the node '{socket.node.name}'")
    return colour.offset[0]


def _image(node: bpy.types.Node, groups: Groups) -> ImageColour:
    image = check_image(node)
    if node.projection != "FLAT":
        raise UnreadableError(f"the node '{node.name}' with {node.projection.title()} projection")
    uv_map, mapping = "", np.eye(3, 4)
    if origin_of(node.inputs["Vector"], groups)[0] != node.inputs["Vector"]:
        uv_map, mapping = _coordinates(node.inputs["Vector"], groups)
    in_plane = mapping[:2, (0, 1, 3)]  # z is 0
    return ImageColour(image, node.extension, node.interpolation == "Closest", alpha_use(node), uv_map, in_plane)


def _coordinates(socket: bpy.types.NodeSocket, groups: Groups) -> tuple[str, NDArray[np.float64]]:
    """The UV map, empty for the one active for render, that feeds ``socket``, and how (u, v, 0, 1) is moved on the way:
    (3, 4)."""
    origin, groups = origin_of(socket, groups)
    node = origin.node
    if origin.is_output:
        if node.bl_idname == "ShaderNodeUVMap" and not node.from_instancer:
            return node.uv_map, np.eye(3, 4)
        if node.bl_idname == "ShaderNodeTexCoord" and origin.name == "UV" and not node.from_instancer:
            return "", np.eye(3, 4)
        if node.bl_idname == "ShaderNodeMapping" and node.vector_type in ("POINT", "TEXTURE", "VECTOR"):
            uv_map, before = _coordinates(node.inputs["Vector"], groups)
            return uv_map, mapping_matrix(node, groups) @ np.vstack((before, (0.0, 0.0, 0.0, 1.0)))
    raise UnreadableError(f"an image at coordinates of the node '{node.name}'")


def mapping_matrix(node: bpy.types.Node, groups: Groups) -> NDArray[np.float64]:
    """What a Mapping node does to (x, y, z, 1): (3, 4)."""
    vectors = []
    for socket in node.inputs[1:]:
        origin, _ = origin_of(socket, groups)
        if origin.is_output:
            raise UnreadableError(f"'{socket.name}' of the node '{node.name}'")
        vectors.append(np.array(origin.default_value))
    location, angles, scale = vectors
    rotation = np.array(Euler(angles).to_matrix())
    if node.vector_type == "TEXTURE":  # the inverse of a point's; what is scaled by 0 is 0
        linear = np.divide(rotation.T, scale[:, None], out=np.zeros((3, 3)), where=scale[:, None] != 0.0)
        return np.column_stack((linear, -linear @ location))
    return np.column_stack((rotation * scale, location if node.vector_type == "POINT" else np.zeros(3)))


def _rgb(value: Sequence[float] | float) -> RGB:
    if np.ndim(value) == 0:
        value = (value, value, value)
    return tuple(float(part) for part in value[:3])
