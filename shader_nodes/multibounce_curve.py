# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Curve``: light of all bounces from k_A, the AO that most programs bake.

Three curves beside each other: that of ``core.multibounce.surface_curve``, which comes nearest to simulated bounces,
and the published ones of ``equal_neighbours`` and ``jimenez_2016``. ``Multibounce AO Fit`` is the published fit of
alpha.
"""

from __future__ import annotations

import bpy

from .expression import Expression, Graph, clamp, maximum
from .group import Socket, ensure_group
from .shading import BASE_COLOR, COLOR, FACTOR, IRRADIANCE, shade

NAME = "Multibounce AO Curve"
VERSION = 1

_INPUTS = (
    Socket(
        "AO",
        "NodeSocketFloat",
        "k_A, the cosine-weighted ambient occlusion that most programs bake: 1 is open",
        default_value=1.0,
        min_value=0.0,
        max_value=1.0,
        subtype="FACTOR",
    ),
    Socket(
        "Openness",
        "NodeSocketFloat",
        "Mean AO of what blocks light, each point by its 1 - AO. 0: not known, then as open as the point itself",
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
    Socket(
        "Pit Factor",
        "NodeSocketColor",
        "E/E0 where all that blocks light is as bright as the point itself, as in a spherical pit; for comparison",
    ),
    Socket(
        "Jimenez Factor",
        "NodeSocketColor",
        "E/E0 by the cubic of Jimenez et al. 2016, that of ground-truth AO in many game engines; for comparison",
    ),
)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be."""
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("k' = sqrt(k openness), of what blocks the light"):
        k = clamp(graph.input("AO"), 0, 1).named("k")
        openness = clamp(graph.input("Openness"), 0, 1).named("openness")
        # Division by 0 gives 0: 1 where the openness is known.
        known = (openness / openness).named("known")
        neighbour = ((k * (openness + (1 - known) * k)) ** 0.5).named("k'")
    with graph.frame("light of all bounces in pits of openness k' and k"):
        albedo = clamp(graph.input("Base Color"), 0, 1).named("albedo")
        dark = (1 - albedo).named("1 - albedo")

        def pit(k: Expression) -> Expression:
            # k / (1 - albedo (1 - k)), so that nothing cancels near k = 0.
            return k / (dark + albedo * k)

        around = pit(neighbour).named("E'")
        equal = pit(k).named("pit")
    with graph.frame("E/E0 = k + albedo (1 - k) E'"):
        factor = (k + albedo * (1 - k) * around).named("E/E0")
    with graph.frame("Jimenez 2016, a cubic of k"):
        a, b, c = 2.0404 * albedo - 0.3324, -4.7951 * albedo + 0.6417, 2.7552 * albedo + 0.6903
        cubic = maximum(((k * a + b) * k + c) * k, k).named("Jimenez")
    shade(graph, factor)
    graph.output("Pit Factor", equal)
    graph.output("Jimenez Factor", cubic)
    graph.arrange()
