# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce Radiosity``: a base colour in the light that a radiosity bake found."""

from __future__ import annotations

import bpy

from .expression import Graph
from .group import Socket, ensure_group
from .shading import BASE_COLOR, COLOR, FACTOR, IRRADIANCE, shade

NAME = "Multibounce Radiosity"
VERSION = 1

_INPUTS = (
    Socket(
        "Radiosity",
        "NodeSocketColor",
        "E/E0 (RGB of the bake): light after all bounces over the unoccluded light",
        default_value=(1.0, 1.0, 1.0, 1.0),
    ),
    BASE_COLOR,
    IRRADIANCE,
)
_OUTPUTS = (COLOR, FACTOR)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be."""
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    shade(graph, graph.input("Radiosity"))
    graph.arrange()
