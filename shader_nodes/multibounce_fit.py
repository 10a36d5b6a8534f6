# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Fit``: light of all bounces from the alpha of any AO map.

Source: Patapom, "Improved Ambient Occlusion" (study notes), equations (7) to (12), with the energy guard that
``core.multibounce`` explains: F0 <= 1 and F1 <= 1 - F0.
"""

from __future__ import annotations

import bpy

from ..core.multibounce import A, B
from .expression import Graph, clamp, exp, minimum
from .group import Socket, ensure_group
from .shading import BASE_COLOR, COLOR, FACTOR, IRRADIANCE, shade

NAME = "Multibounce AO Fit"
VERSION = 1

_INPUTS = (
    Socket(
        "AO",
        "NodeSocketFloat",
        "Alpha, the uniform visibility: the open fraction of the hemisphere, without the cosine",
        default_value=1.0,
        min_value=0.0,
        max_value=1.0,
        subtype="FACTOR",
    ),
    BASE_COLOR,
    IRRADIANCE,
)
_OUTPUTS = (
    COLOR,
    FACTOR,
    Socket("F0", "NodeSocketFloat", "Direct light over the unoccluded light: what most programs call AO"),
    Socket("F1", "NodeSocketFloat", "Light of the first bounce at albedo 1"),
    Socket("Tau", "NodeSocketFloat", "Ratio of each further bounce to the one before it"),
)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be."""
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("F0 (eq. 7), at most 1: as printed it passes 1 at alpha = 0.949"):
        alpha = clamp(graph.input("AO"), 0, 1).named("alpha")
        f0 = minimum(alpha * (1 + (1 - alpha) ** 0.75 / 2), 1).named("F0")
        left = 1 - f0
    with graph.frame("F1 (eq. 11), at most what F0 leaves: else E/E0 has a pole"):
        a, b = graph.value("A", A), graph.value("B", B)
        f1 = minimum(a * alpha * (1 - alpha) ** 1.5 * exp(-b * alpha**0.25), left).named("F1")
    with graph.frame("tau (eq. 9)"):
        tau = ((left - f1) / left).named("tau")
    # Eq. (10) has F1 / (1 - albedo tau). With tau put in, and both sides times 1 - F0, no difference of nearly
    # equal numbers is left, which float32 would turn into sparkles near alpha = 1 and near alpha = 0.
    with graph.frame("E/E0 (eq. 10), tau put in: no rounding noise near alpha = 1"):
        albedo = clamp(graph.input("Base Color"), 0, 1).named("albedo")
        first = albedo * f1
        factor = (f0 + left * (first / (first + (1 - albedo) * left))).named("E/E0")
    shade(graph, factor)
    for name, value in (("F0", f0), ("F1", f1), ("Tau", tau)):
        graph.output(name, value)
    graph.arrange()
