# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Multibounce AO Fit``: light of all bounces from the alpha of any AO map.

Source: Patapom, "Improved Ambient Occlusion" (study notes), equations (7) to (12), with the energy guard that
``core.multibounce`` explains: F0 <= 1 and F1 <= 1 - F0. The coefficients are those of the scene's own fit where it has
one, else the published ones.
"""

from __future__ import annotations

from dataclasses import fields

import bpy

from ..core.multibounce import PUBLISHED, Coefficients
from .expression import Expression, Graph, clamp, exp
from .group import Socket, ensure_group, find_group
from .shading import BASE_COLOR, COLOR, FACTOR, IRRADIANCE, shade

NAME = "Multibounce AO Fit"
VERSION = 2

STORED_FIT = "multibounce_ao_fit"
"""ID property of a scene: the coefficients of its own fit, by their names in :class:`core.multibounce.Coefficients`."""

# Shaders have 32-bit floats: what is larger than this would become infinite on the way.
_LARGEST = 1e30

# The coefficients by the names of their nodes.
_NODES = {"A": "a", "B": "b", "F0 factor": "f0_factor", "F0 exponent": "f0_exponent"}

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
    """The group of this file's scene data, built or brought up to date if need be, with the fit of the present scene.

    One that is up to date keeps the coefficients that it has.
    """
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def stored_fit(scene: bpy.types.Scene) -> Coefficients:
    """The fit that is stored on ``scene``, or the published one where there is none that shaders can compute with."""
    stored = scene.get(STORED_FIT, {})
    values = {field.name: stored.get(field.name, float("nan")) for field in fields(Coefficients)}
    return Coefficients(**values) if all(abs(value) <= _LARGEST for value in values.values()) else PUBLISHED


def show_fit(scene: bpy.types.Scene) -> None:
    """Give this file's group, if it has one, the fit of ``scene``: materials that use it follow. Nodes that an artist
    has taken out of the group stay out."""
    if find_group(NAME)[0] is None:
        return
    tree, fit = ensure(), stored_fit(scene)
    for name, field in _NODES.items():
        if name in tree.nodes:
            tree.nodes[name].outputs[0].default_value = getattr(fit, field)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph, fit = Graph(tree), stored_fit(bpy.context.scene)

    def coefficient(name: str) -> Expression:
        return graph.value(name, getattr(fit, _NODES[name]))

    with graph.frame("F0 (eq. 7), at most 1: else it passes 1 near alpha = 1"):
        alpha = clamp(graph.input("AO"), 0, 1).named("alpha")
        f0_factor, f0_exponent = coefficient("F0 factor"), coefficient("F0 exponent")
        f0 = clamp(alpha * (1 + f0_factor * (1 - alpha) ** f0_exponent), 0, 1).named("F0")
        left = 1 - f0
    with graph.frame("F1 (eq. 11), at most what F0 leaves: else E/E0 has a pole"):
        a, b = coefficient("A"), coefficient("B")
        f1 = clamp(a * alpha * (1 - alpha) ** 1.5 * exp(-b * alpha**0.25), 0, left).named("F1")
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
