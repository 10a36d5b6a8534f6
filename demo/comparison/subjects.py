# SPDX-License-Identifier: GPL-3.0-or-later
"""What is compared: scenes with materials whose base colour is one grey or their own, at a switch."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy
import scene
from scene import box
from scene.patches import COLOUR_ATTRIBUTE

GREY = 0.5


@dataclass(frozen=True)
class Subject:
    """A scene: `build` makes it in a new file and returns what to bake to vertices, and what to textures.

    size    (width, height) of its renders, in pixels
    detail  left, top, width, height of what pictures show of them
    gain    what pictures brighten it by
    """

    name: str
    build: Callable[[], tuple[list[bpy.types.Object], list[bpy.types.Object]]]
    size: tuple[int, int]
    detail: tuple[int, int, int, int]
    gain: float


def _ruin() -> tuple[list[bpy.types.Object], list[bpy.types.Object]]:
    ruin = scene.build()
    ruin.sun.hide_render = True
    return ruin.vertex_objects, ruin.texture_objects


SUBJECTS = (
    Subject("ruin", _ruin, (600, 400), (181, 50, 216, 220), gain=1.5),
    Subject("box", box.build, (228, 228), (6, 4, 216, 220), gain=2.0),
)


class Albedo:
    """The base colours of all materials: GREY, or each one's own without its fine grain, which no bake can read."""

    def __init__(self) -> None:
        self.sockets: dict[bpy.types.Material, bpy.types.NodeSocket] = {}
        self._factors = []
        for material in bpy.data.materials:
            tree = material.node_tree
            principled = next((node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"), None) if tree else None
            if principled is None:
                continue
            colour = tree.nodes.new("ShaderNodeAttribute")
            colour.attribute_name = COLOUR_ATTRIBUTE
            switch = tree.nodes.new("ShaderNodeMix")
            switch.data_type = "RGBA"
            inputs = {socket.identifier: socket for socket in switch.inputs}
            inputs["A_Color"].default_value = (GREY, GREY, GREY, 1)
            tree.links.new(colour.outputs["Color"], inputs["B_Color"])
            self._factors.append(inputs["Factor_Float"])
            result = next(socket for socket in switch.outputs if socket.identifier == "Result_Color")
            tree.links.new(result, principled.inputs["Base Color"])
            self.sockets[material] = result

    def show(self, own: bool) -> None:
        """Their own colours, or else grey."""
        for factor in self._factors:
            factor.default_value = float(own)
