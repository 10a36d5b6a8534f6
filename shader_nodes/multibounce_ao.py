# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO``: light of all bounces from the measured channels F0, F1, F2, T of a bake.

The same sum and the same energy guard as ``core.multibounce.irradiance_from_bounces``.
"""

from __future__ import annotations

import bpy

from ..core.multibounce import MOST_TAIL, TAIL_ALBEDO
from .expression import Graph, clamp, maximum, minimum
from .group import Socket, ensure_group
from .shading import BASE_COLOR, COLOR, FACTOR, IRRADIANCE, shade

NAME = "Multibounce AO"
VERSION = 2

_INPUTS = (
    Socket(
        "Bounces",
        "NodeSocketColor",
        "F0, F1, F2 (RGB of the bake): direct light and two bounces at albedo 1, over the unoccluded light",
        default_value=(1.0, 0.0, 0.0, 1.0),
    ),
    Socket(
        "Tail",
        "NodeSocketFloat",
        "T (alpha of the bake): ratio of each bounce after the second to the one before it",
        default_value=0.0,
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
    Socket("AO", "NodeSocketFloat", "F0, direct light over the unoccluded light: what most programs call AO"),
)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be."""
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("F0, F1, F2: none brings more light than the ones before leave"):
        f0, f1, f2 = graph.input("Bounces").channels("F0 raw", "F1 raw", "F2 raw")
        f0 = clamp(f0, 0, 1).named("F0")
        left_after_f0 = 1 - f0
        f1 = clamp(f1, 0, left_after_f0).named("F1")
        left = left_after_f0 - f1
        f2 = clamp(f2, 0, left).named("F2")
    # 1 - T instead of T: 1 - albedo T, as written, loses its digits where both are nearly 1.
    with graph.frame("1 - T, so that later bounces stay within what is left"):
        left_after_f2 = left - f2
        least = (f2 - (1 - TAIL_ALBEDO) * left_after_f2) / (f2 + TAIL_ALBEDO * left_after_f2)
        loss = clamp(1 - graph.input("Tail"), maximum(least, 1 - MOST_TAIL), 1).named("loss")
    with graph.frame("E/E0 = F0 + albedo F1 + albedo^2 F2 / (1 - albedo T)"):
        albedo = clamp(graph.input("Base Color"), 0, 1).named("albedo")
        dark = (1 - albedo).named("1 - albedo")
        series = (f0 + albedo * (f1 + albedo * (f2 / (dark + albedo * loss)))).named("series")
    with graph.frame(f"from albedo {TAIL_ALBEDO} on at most the straight line to 1"):
        rest = TAIL_ALBEDO * f2 / (1 - TAIL_ALBEDO + TAIL_ALBEDO * loss)
        missing = (1 - (f0 + TAIL_ALBEDO * (f1 + rest))).named("missing")
        factor = minimum(series, 1 - missing * minimum(dark / (1 - TAIL_ALBEDO), 1)).named("E/E0")
    shade(graph, factor)
    graph.output("AO", f0)
    graph.arrange()
