# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group ``Bent Cone Irradiance``: the World's light on a baked surface, from where the sky is, without a ray.

The same steps and symbols as ``core.bent_cone.sky_light`` and ``core.specular_occlusion``; the World is that of
``cone_light``.

``Irradiance`` holds all of the direct light: F0 under a white World of radiance 1. The multi-bounce groups multiply
their ``Irradiance`` by E/E0, which holds F0 already. So what goes there is ``Sky Light`` = ``Irradiance`` / F0, the
mean light of the sky that the point sees: the direct light then counts once, and bounces carry that sky's colour.
Their ``Color`` is then light, to be emitted. Where the renderer lights the surface by the World itself, without
shadows, ``Relative Light`` goes there: ``Sky Light`` over the light of an open surface, which the renderer brings.
Under a white World both are 1 and change nothing.
"""

from __future__ import annotations

from math import pi

import bpy

from ..core.bent_cone import LEAST_F0, LEAST_OPEN
from ..core.cap import LEAST_SINE
from ..core.specular_occlusion import MOST_LOBE
from . import cone_light
from .expression import Expression, Graph, Operand, clamp, maximum, minimum
from .functions import atan2, dot, length, less_than, normalised, sqrt
from .group import Socket, ensure_group

NAME = "Bent Cone Irradiance"
VERSION = 2

_INPUTS = (
    Socket(
        "Bent Cone",
        "NodeSocketVector",
        "Mean visible direction in object space, not normalized (RGB of the bake)",
        default_value=(0.0, 0.0, 0.0),
    ),
    Socket(
        "Alpha",
        "NodeSocketFloat",
        "Uniform visibility (alpha of the bake)",
        default_value=1.0,
        min_value=0.0,
        max_value=1.0,
        subtype="FACTOR",
    ),
    Socket(
        "Normal",
        "NodeSocketVector",
        "Normal of the surface in world space, such as a Bump node gives; unconnected, the surface's own",
        default_value=(0.0, 0.0, 0.0),
    ),
    Socket(
        "Roughness",
        "NodeSocketFloat",
        "Roughness of the reflection that Specular Occlusion is for",
        default_value=0.5,
        min_value=0.0,
        max_value=1.0,
        subtype="FACTOR",
    ),
)
_OUTPUTS = (
    Socket(
        "Irradiance", "NodeSocketColor", "Direct light of the World through the bent cone over pi; F0 if it is white"
    ),
    Socket("Bent Normal", "NodeSocketVector", "Middle of what the point sees, in world space"),
    Socket("Aperture", "NodeSocketFloat", "Half-angle of the cone in radians; a hemisphere has pi/2", subtype="ANGLE"),
    Socket("Specular Occlusion", "NodeSocketFloat", "Share of the reflection that is sky: multiplies reflected World"),
    Socket(
        "Sky Light", "NodeSocketColor", "Irradiance / F0, for Irradiance of a multibounce group whose Color is emitted"
    ),
    Socket(
        "Relative Light", "NodeSocketColor", "Sky Light over that of an open surface, where the renderer brings light"
    ),
)


def ensure() -> bpy.types.ShaderNodeTree:
    """The group of this file's scene data, built or brought up to date if need be, with the World of the present scene.

    One that is up to date keeps the World that it has; ``cone_light.show_world`` gives it another.
    """
    cone_light.ensure()
    return ensure_group(NAME, VERSION, _INPUTS, _OUTPUTS, _build)


def _build(tree: bpy.types.ShaderNodeTree) -> None:
    graph = Graph(tree)
    with graph.frame("the baked cone: b, alpha, and whether there is one"):
        baked = graph.input("Bent Cone")
        size = length(baked).named("|b|")
        is_missing = less_than(size, 1e-6).named("is missing")
        alpha = clamp(graph.input("Alpha"), 0, 1).named("alpha")
    # A bake is of the front. Renderers turn normals round where a surface is seen from behind; and so does a bake of
    # Cycles wherever a smooth normal leans away from its own face.
    with graph.frame("n: the normal, in world space, of the front where baked"):
        surface = graph.node("ShaderNodeNewGeometry", "")
        given = graph.input("Normal")
        own = less_than(length(given), 1e-6) * Expression(graph, surface.outputs["Normal"], "own normal")
        behind = Expression(graph, surface.outputs["Backfacing"], "backfacing")
        normal = ((1 - 2 * behind * (1 - is_missing)) * normalised(given + own)).named("n")
    with graph.frame("b: turned with its object, length kept; open where missing"):
        world = _to_world(graph, baked)
        bent = (size * normalised(world) + 0.5 * is_missing * normal).named("b")
    with graph.frame("moments: seen m = alpha b, hidden n/2 - m, open n/2"):
        moment = (alpha * bent).named("m")
        half = (0.5 * normal).named("n/2")
        hidden_alpha = (1 - alpha).named("1 - alpha")
        hidden_moment = (half - moment).named("n/2 - m")
    with graph.frame("light of what is seen, of what is hidden, and of all"):
        seen, fit_of_seen, _ = _cone_light(graph, "seen", moment, alpha, normal)
        hidden, fit_of_hidden, _ = _cone_light(graph, "hidden", hidden_moment, hidden_alpha, normal)
        opened, _, mean = _cone_light(graph, "open", half, 1.0, normal)
    with graph.frame("seen : hidden = (1 - alpha) t seen^2 : alpha t hidden^2"):
        first = (hidden_alpha * (fit_of_seen * fit_of_seen)).named("of seen")
        weight = (first / (first + alpha * (fit_of_hidden * fit_of_hidden))).named("weight")
    with graph.frame("Irradiance; F0 = 2 n . m"):
        direct = maximum(weight * seen + (1 - weight) * (opened - hidden), 0).named("Irradiance")
        f0 = maximum(2 * dot(moment, normal), 0).named("F0")
    with graph.frame("Sky Light = Irradiance / F0, with a little open light beside"):
        plain = maximum(opened, 0).named("open light")
        sky = ((direct + LEAST_F0 * plain) / (f0 + LEAST_F0)).named("Sky Light")
    with graph.frame("Relative Light = Sky Light / open light, kept off 0"):
        relative = (sky / maximum(plain, LEAST_OPEN * mean)).named("Relative Light")
    with graph.frame("Bent Normal and Aperture"):
        axis = normalised(bent).named("Bent Normal")
        aperture = _arc_cosine(1 - alpha).named("Aperture")
    occlusion = _specular(graph, surface, normal, axis, alpha)
    for name, value in (
        ("Irradiance", direct),
        ("Bent Normal", axis),
        ("Aperture", aperture),
        ("Specular Occlusion", occlusion),
        ("Sky Light", sky),
        ("Relative Light", relative),
    ):
        graph.output(name, value)
    graph.arrange()


def _to_world(graph: Graph, direction: Expression) -> Expression:
    node = graph.node("ShaderNodeVectorTransform", "object to world")
    node.vector_type, node.convert_from, node.convert_to = "VECTOR", "OBJECT", "WORLD"
    graph.link(direction, node.inputs[0])
    return Expression(graph, node.outputs[0], "world b")


def _cone_light(
    graph: Graph, name: str, moment: Expression, alpha: Operand, normal: Expression
) -> tuple[Expression, Expression, Expression]:
    """Light through a cone, how much it is one, and the World's mean."""
    node = graph.node("ShaderNodeGroup", f"Light {name}")
    node.name = node.label
    node.node_tree = cone_light.ensure()
    for value, socket in ((moment, "Moment"), (alpha, "Alpha"), (normal, "Normal")):
        graph.link(value, node.inputs[socket])
    texts = {"Light": f"{name} light", "Fit": f"t {name}", "Mean": "mean light"}
    return tuple(Expression(graph, node.outputs[output], text) for output, text in texts.items())


def _specular(
    graph: Graph, surface: bpy.types.Node, normal: Expression, axis: Expression, alpha: Expression
) -> Expression:
    """Overlap of the bent cone and the reflection's, over the part of that which is above the horizon."""
    with graph.frame("the reflection, and its cone's cosine 10^(-roughness^4)"):
        view = Expression(graph, surface.outputs["Incoming"], "view")
        mirrored = (2 * dot(normal, view) * normal - view).named("reflection")
        roughness = clamp(graph.input("Roughness"), 0, 1).named("roughness")
        lobe = minimum(graph.operate("POWER", 10.0, -(roughness**4)), MOST_LOBE).named("lobe")
    with graph.frame("what the bent cone and the reflection share"):
        seen = _overlap(graph, 1 - alpha, lobe, dot(axis, mirrored))
    with graph.frame("what the hemisphere and the reflection share"):
        above = _overlap(graph, 0.0, lobe, dot(normal, mirrored))
        return minimum(seen / above, 1).named("Specular Occlusion")


def _overlap(graph: Graph, first: Operand, second: Expression, between: Expression) -> Expression:
    """Solid angle that two caps share, over 2 pi, from cosines."""

    def sine(cosine: Operand) -> Operand:
        return maximum(sqrt(maximum(1 - cosine * cosine, 0)), LEAST_SINE) if isinstance(cosine, Expression) else 1.0

    sine_1, sine_2, sine_between = sine(first), sine(second), sine(between)
    apart = _arc_cosine((between - first * second) / (sine_1 * sine_2))
    in_first = _arc_cosine((second - between * first) / (sine_between * sine_1))
    in_second = _arc_cosine((first - between * second) / (sine_between * sine_2))
    return maximum(pi - apart - first * in_first - second * in_second, 0) / pi


def _arc_cosine(cosine: Expression) -> Expression:
    """By the arc tangent, which keeps its digits near 1 and -1."""
    x = clamp(cosine, -1, 1)
    return atan2(sqrt(maximum((1 - x) * (1 + x), 0)), x)
