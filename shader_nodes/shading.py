# SPDX-License-Identifier: GPL-3.0-or-later
"""What the multi-bounce groups share: sockets for colour and light, Color = Base Color * Factor * Irradiance."""

from __future__ import annotations

from .expression import Expression, Graph
from .group import Socket

BASE_COLOR = Socket(
    "Base Color",
    "NodeSocketColor",
    "Color of the surface, taken as that of its neighbors too: the albedo of every bounce",
    default_value=(0.8, 0.8, 0.8, 1.0),
)
IRRADIANCE = Socket(
    "Irradiance",
    "NodeSocketColor",
    "Unoccluded light, multiplied into Color; white where the renderer brings the light itself",
    default_value=(1.0, 1.0, 1.0, 1.0),
)
COLOR = Socket("Color", "NodeSocketColor", "Base Color * Factor * Irradiance")
FACTOR = Socket("Factor", "NodeSocketColor", "E/E0, a channel: light after all bounces over the unoccluded light")


def shade(graph: Graph, factor: Expression) -> None:
    """Add the outputs ``Color`` and ``Factor``. Only the albedo of the bounces is clamped: Base Color is not."""
    with graph.frame("Color"):
        color = (graph.input("Base Color") * factor * graph.input("Irradiance")).named("Color")
    graph.output("Color", color)
    graph.output("Factor", factor)
