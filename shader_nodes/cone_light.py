# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Cone Light``, a part of ``Bent Cone Irradiance``: the World's light through one cone.

The same formula as ``core.clipped_cone``, with the steps of ``core.bent_cone``. Here lie the World's nine coefficients
a channel, as fractions of the largest, since what a socket holds is limited.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core.spherical_harmonics import COUNT, Y0, Y1, Y2, Y20, Y22
from .expression import Expression, Graph, maximum
from .functions import components, dot, length, normalised
from .group import Socket, ensure_group, find_group

NAME = "Cone Light"
VERSION = 1

STORED_WORLD = "multibounce_ao_world"
"""ID property of a scene: what its World was projected to; ``red``, ``green`` and ``blue`` have nine numbers each."""

LARGEST = 1e30
"""Shaders have 32-bit floats: what is larger than this would become infinite on the way."""

_SCALE = "World Scale"
# L_lm in the order of core.spherical_harmonics.
_NAMES = ("L 0 0", "L 1 -1", "L 1 0", "L 1 1", "L 2 -2", "L 2 -1", "L 2 0", "L 2 1", "L 2 2")

Coefficients = Sequence[Sequence[float]]
"""Nine times red, green and blue."""

# Radiance 1 all around.
WHITE: Coefficients = ((1.0 / Y0,) * 3, *((0.0,) * 3,) * (COUNT - 1))

_INPUTS = (
    Socket("Moment", "NodeSocketVector", "Integral of the cone's directions over 2 pi, in world space"),
    Socket("Alpha", "NodeSocketFloat", "Solid angle of the cone over 2 pi", default_value=1.0),
    Socket("Normal", "NodeSocketVector", "Unit normal of the surface in world space"),
)
_OUTPUTS = (
    Socket("Light", "NodeSocketColor", "Irradiance of the World through the cone over pi"),
    Socket("Fit", "NodeSocketFloat", "How much what has this moment and solid angle is a cone: 1 for cones"),
    Socket("Mean", "NodeSocketColor", "Mean radiance of the World"),
)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be, with the World of the present scene.

    One that is up to date keeps the World that it has.
    """
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def stored_world(scene: bpy.types.Scene) -> Coefficients:
    """The projection that is stored on ``scene``, or a white World where it has none that shaders can compute with."""
    stored = scene.get(STORED_WORLD, {})
    channels = [list(stored.get(name, ())) for name in ("red", "green", "blue")]
    is_usable = all(len(each) == COUNT and all(abs(value) <= LARGEST for value in each) for each in channels)
    return tuple(zip(*channels, strict=True)) if is_usable else WHITE


def show_world(scene: bpy.types.Scene) -> None:
    """Give this file's group, if it has one, the World of ``scene``: materials that use it follow."""
    if find_group(NAME)[0] is not None:
        _set_world(ensure(), stored_world(scene))


def _set_world(tree: bpy.types.ShaderNodeTree, world: Coefficients) -> None:
    """Nodes that an artist has taken out of the group stay out."""
    largest = max(max(map(abs, each)) for each in world)
    if _SCALE in tree.nodes:
        tree.nodes[_SCALE].outputs[0].default_value = largest
    for name, colour in zip(_NAMES, world, strict=True):
        for socket, value in zip(tree.nodes[name].inputs if name in tree.nodes else (), colour, strict=False):
            socket.default_value = value / largest if largest > 0.0 else 0.0


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("the cone: axis d, c = 1 - alpha; F, its share of a white sky"):
        moment, normal, alpha = (graph.input(name) for name in ("Moment", "Normal", "Alpha"))
        size = (2 * length(moment)).named("2 |m|")
        axis = normalised(moment).named("d")
        share = (2 * dot(moment, normal)).named("F")
        c = (1 - alpha).named("c")
    with graph.frame("t = alpha / (2 (1 - |b|)), with alpha |b| = |m|"):
        fit = (alpha * alpha / maximum(2 * alpha - size, alpha * alpha)).named("t")
    with graph.frame("band 1: s = (1-c)(2+c)/(3(1+c)) n 2|m| + c F d"):
        even = (size * (alpha * (2 + c) / (3 * (1 + c)))).named("even")
        slope = (even * normal + c * share * axis).named("s")
        sx, sy, sz = components(slope, "s.x", "s.y", "s.z")
    with graph.frame("band 2: u . curve d, u = (1-c^2)/2 n 2|m| + (5c^2-1)/4 F d"):
        c2 = (c * c).named("c^2")
        bent = (size * ((1 - c2) / 2) * normal + ((5 * c2 - 1) / 4) * share * axis).named("u")
        ux, uy, uz = components(bent, "u.x", "u.y", "u.z")
        dx, dy, dz = components(axis, "d.x", "d.y", "d.z")
    with graph.frame("the basis functions for this cone"):
        weights = (
            Y0 * share,
            *(Y1 * sy, Y1 * sz, Y1 * sx),
            *(Y2 / 2 * (ux * dy + uy * dx), Y2 / 2 * (uy * dz + uz * dy)),
            *(Y20 * (3 * (uz * dz) - dot(bent, axis)), Y2 / 2 * (ux * dz + uz * dx), Y22 * (ux * dx - uy * dy)),
        )
    with graph.frame("Light = World Scale * sum of L * its basis function"):
        coefficients = [_coefficient(graph, name) for name in _NAMES]
        scale = graph.value(_SCALE, 1.0)
        total = coefficients[0] * weights[0]
        for name, coefficient, weight in zip(_NAMES[1:], coefficients[1:], weights[1:], strict=True):
            total = (total + coefficient * weight).named(f"sum to {name}")
        light = (scale * total).named("Light")
        mean = (scale * (Y0 * coefficients[0])).named("Mean")
    graph.output("Light", light)
    graph.output("Fit", fit)
    graph.output("Mean", mean)
    graph.arrange()
    _set_world(tree, stored_world(bpy.context.scene))


def _coefficient(graph: Graph, name: str) -> Expression:
    node = graph.node("ShaderNodeCombineXYZ", name)
    node.name = name
    return Expression(graph, node.outputs[0], name)
