# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Spherical Cap Occlusion``: how much light a round blocker takes away from a surface.

The closed form of ``core.cap.occlusion``, where it is derived. It holds for every cap and tilt, also where the horizon
cuts the cap, so no table is needed (Ambient Occlusion Fields, study notes, "Implementation": T_LUT).
"""

from __future__ import annotations

from math import pi

import bpy

from ..core.cap import LEAST_SQUARE
from .expression import Graph, clamp, maximum
from .functions import atan2, sqrt
from .group import Socket, ensure_group

NAME = "Spherical Cap Occlusion"
VERSION = 1

_INPUTS = (
    Socket(
        "Solid Angle",
        "NodeSocketFloat",
        "Size of the cap as seen from the surface, in steradians: 2 pi is a hemisphere, 4 pi everything",
        default_value=0.0,
        min_value=0.0,
        max_value=4.0 * pi,
    ),
    Socket(
        "Cosine",
        "NodeSocketFloat",
        "Cosine of the angle between the surface's normal and the middle of the cap",
        default_value=1.0,
        min_value=-1.0,
        max_value=1.0,
    ),
)
_OUTPUTS = (Socket("Occlusion", "NodeSocketFloat", "Cosine-weighted part of the hemisphere that the cap covers"),)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be."""
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("c, k: cosines of the cap's half angle and of its tilt"):
        c = clamp(1 - graph.input("Solid Angle") / (2 * pi), -1, 1).named("c")
        k = clamp(graph.input("Cosine"), -1, 1).named("k")
    with graph.frame("D = sqrt(1 - c^2 - k^2), above 0: the angles stay defined"):
        s2 = (1 - c * c).named("1 - c^2")
        d = sqrt(maximum(s2 - k * k, LEAST_SQUARE)).named("D")
    with graph.frame("A = ((1 - c^2) k atan2(D, -c k) + atan2(D, c) - c D) / pi"):
        occlusion = (s2 * k * atan2(d, -(c * k)) + atan2(d, c) - c * d) / pi
    graph.output("Occlusion", clamp(occlusion, 0, 1).named("A"))
    graph.arrange()
