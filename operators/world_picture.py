# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a World that is one picture, an HDRI, without a renderer: exact, however small its sun."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.panorama import project_picture
from ..core.spherical_harmonics import rotate
from .base_color_nodes import mapping_matrix
from .image_pixels import Pixels, alpha_use, check_image, read_pixels
from .node_origins import UnreadableError, origin_of

# 28 bytes each while they are read. Cycles keeps larger pictures in fewer.
MOST_PIXELS = 2**25


@dataclass(frozen=True)
class PictureLight:
    """Light of ``pixels`` all around, times ``strength``; what is seen at w is the picture at R w, R being ``turn``."""

    pixels: Pixels
    turn: NDArray[np.float64]
    strength: float

    def coefficients(self) -> NDArray[np.float64]:
        """(9, 3). Needs no Blender."""
        # The light is turned back.
        return self.strength * rotate(project_picture(self.pixels.linear()), self.turn.T)


def read_picture(colour: bpy.types.NodeSocket, strength: float) -> PictureLight | None:
    """What feeds the ``colour`` of a World: an equirectangular picture, which a Mapping node may turn. None where that
    is something else."""
    try:
        node = origin_of(colour, ())[0].node
        if node.bl_idname != "ShaderNodeTexEnvironment" or node.projection != "EQUIRECTANGULAR":
            return None
        image, turn = check_image(node), _turn(node.inputs["Vector"])
    except UnreadableError:
        return None
    if turn is None or node.interpolation == "Closest" or image.size[0] * image.size[1] > MOST_PIXELS:
        return None
    return PictureLight(read_pixels(image, alpha_use(node)), turn, strength)


def _turn(vector: bpy.types.NodeSocket) -> NDArray[np.float64] | None:
    """The rotation or reflection R (3, 3) of the direction that reaches ``vector``, None where it is no such."""
    origin, groups = origin_of(vector, ())
    if not origin.is_output:
        return np.eye(3) if origin == vector else None
    node = origin.node
    if node.bl_idname == "ShaderNodeTexCoord" and origin.name == "Generated":
        return np.eye(3)
    if node.bl_idname != "ShaderNodeMapping" or node.vector_type == "NORMAL":
        return None
    before, matrix = _turn(node.inputs["Vector"]), mapping_matrix(node, groups)
    is_turn = np.allclose(matrix[:, :3] @ matrix[:, :3].T, np.eye(3), atol=1e-5) and not matrix[:, 3].any()
    # A Mapping node whose own vector is not linked maps that one vector.
    return matrix[:, :3] @ before if is_turn and before is not None and node.inputs["Vector"].is_linked else None
