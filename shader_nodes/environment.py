# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures that shaders look up by Environment Texture nodes, at a point, not in a direction.

Such a node has no mipmaps, whose choice of level breaks at the seams of an atlas in EEVEE, but no alpha either. It
shows the point that a direction has in the equirectangular projection, so the point is turned into that direction.
Places near the poles lose digits: leave the lowest and the uppermost part of a picture empty.
"""

from __future__ import annotations

from math import pi

from .expression import Expression, Graph
from .functions import cosine, sine, vector


def direction_of(right: Expression, up: Expression, columns: int, rows: int) -> tuple[Expression, ...]:
    """x, y and z of the direction that shows the point ``right``, ``up`` of a picture ``columns`` wide, ``rows`` high.
    A point half the picture's width further on has -x and -y, one a quarter further on y and -x."""
    longitude = (right * (2 * pi / columns)).named("longitude")
    colatitude = (up * (pi / rows)).named("colatitude")
    ring = sine(colatitude)
    return (-(ring * cosine(longitude))).named("x'"), (ring * sine(longitude)).named("y'"), -cosine(colatitude)


def texture(graph: Graph, name: str, x: Expression, y: Expression, z: Expression) -> Expression:
    """The colour that a new Environment Texture node ``name`` shows in the direction (x, y, z)."""
    node = graph.node("ShaderNodeTexEnvironment", "")
    node.name = name
    graph.link(vector(x, y, z), node.inputs["Vector"])
    return Expression(graph, node.outputs["Color"], name)
