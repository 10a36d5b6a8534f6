# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas as shader nodes: arithmetic on expressions adds labelled Math and Vector Math nodes to a group.

    graph = Graph(tree)
    alpha = graph.input("AO")
    with graph.frame("F0 (eq. 7)"):
        f0 = minimum(alpha * (1 + (1 - alpha) ** 0.75 / 2), 1).named("F0")
    graph.output("F0", f0)
    graph.arrange()

Each node is labelled with what it computes, in terms of the names given so far. Floats are computed by Math nodes; as
soon as a colour or vector takes part it is Vector Math, per channel, and floats spread to all three channels. Vector
Math does not know every function: ``**`` and ``exp`` are for floats only.

Blender's division gives 0 where the divisor is 0, in Cycles and in EEVEE: formulas may rely on x / 0 = 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .layout import arrange

# operation: (symbol, binding strength, whether a - (b - c) needs its parentheses)
_INFIX = {
    "ADD": ("+", 1, False),
    "SUBTRACT": ("-", 1, True),
    "MULTIPLY": ("*", 2, False),
    "DIVIDE": ("/", 2, True),
    "POWER": ("^", 3, True),
}
_FUNCTION = {"MINIMUM": "min", "MAXIMUM": "max", "EXPONENT": "exp", "CLAMP": "clamp"}
_ATOM = 4
_LONGEST_LABEL = 28


class Expression:
    """The value of one output socket, with the text of its formula."""

    def __init__(self, graph: Graph, socket: bpy.types.NodeSocket, text: str, binding: int = _ATOM):
        self.graph = graph
        self.text = text
        self.binding = binding
        self._socket = socket

    @property
    def socket(self) -> bpy.types.NodeSocket:
        return self._socket

    @property
    def is_colour(self) -> bool:
        return self.socket.type in {"RGBA", "VECTOR"}

    def named(self, name: str) -> Expression:
        """The same value under a name, which labels its node and stands for it in the formulas that use it."""
        node = self.socket.node
        node.label = name
        node.name = name
        return Expression(self.graph, self.socket, name)

    def channels(self, *names: str) -> tuple[Expression, ...]:
        """Red, green and blue as floats called ``names``."""
        node = self.graph.node("ShaderNodeSeparateColor", f"{self.text} = {', '.join(names)}")
        self.graph.link(self, node.inputs[0])
        return tuple(Expression(self.graph, socket, name) for socket, name in zip(node.outputs, names, strict=True))

    def __add__(self, other: Operand) -> Expression:
        return self.graph.operate("ADD", self, other)

    def __radd__(self, other: float) -> Expression:
        return self.graph.operate("ADD", other, self)

    def __sub__(self, other: Operand) -> Expression:
        return self.graph.operate("SUBTRACT", self, other)

    def __rsub__(self, other: float) -> Expression:
        return self.graph.operate("SUBTRACT", other, self)

    def __mul__(self, other: Operand) -> Expression:
        return self.graph.operate("MULTIPLY", self, other)

    def __rmul__(self, other: float) -> Expression:
        return self.graph.operate("MULTIPLY", other, self)

    def __truediv__(self, other: Operand) -> Expression:
        return self.graph.operate("DIVIDE", self, other)

    def __rtruediv__(self, other: float) -> Expression:
        return self.graph.operate("DIVIDE", other, self)

    def __pow__(self, other: Operand) -> Expression:
        return self.graph.operate("POWER", self, other)

    def __neg__(self) -> Expression:
        return self.graph.operate("MULTIPLY", -1, self)


class _Input(Expression):
    """A socket of the group's interface. Each frame that reads it gets a Group Input node of its own: no long links."""

    @property
    def socket(self) -> bpy.types.NodeSocket:
        socket = self.graph.group_input().outputs[self.text]
        socket.hide = False
        return socket

    def named(self, name: str) -> Expression:
        raise TypeError(f"the group's input {self.text!r} has its name already")


Operand = Expression | float


class Graph:
    """Fills one shader node group. Nodes made inside ``with frame(...)`` are put into that frame."""

    def __init__(self, tree: bpy.types.ShaderNodeTree):
        self.tree = tree
        self._frame: bpy.types.NodeFrame | None = None
        self._group_inputs: dict[str, bpy.types.Node] = {}
        self._group_output: bpy.types.Node | None = None

    @contextmanager
    def frame(self, label: str) -> Iterator[None]:
        """Collect the nodes made inside the block in a frame. ``label``: which formula, and why a guard is there."""
        self._frame = self.tree.nodes.new("NodeFrame")
        self._frame.label = label
        self._frame.select = False
        try:
            yield
        finally:
            self._frame = None

    def node(self, bl_idname: str, label: str) -> bpy.types.Node:
        node = self.tree.nodes.new(bl_idname)
        # where the formula is too long to read on a node, Blender's own label is better: the operation
        node.label = label if len(label) <= _LONGEST_LABEL else ""
        node.parent = self._frame
        node.select = False
        return node

    def group_input(self) -> bpy.types.Node:
        """The Group Input node of the current frame; its sockets stay hidden until something reads them."""
        key = self._frame.name if self._frame else ""
        if key not in self._group_inputs:
            self._group_inputs[key] = self.node("NodeGroupInput", "")
            for socket in self._group_inputs[key].outputs:
                socket.hide = True
        return self._group_inputs[key]

    def input(self, name: str) -> Expression:
        """The group's input socket ``name``."""
        return _Input(self, None, name)

    def value(self, name: str, value: float) -> Expression:
        """A constant in a node of its own, where an artist finds and may change it."""
        node = self.node("ShaderNodeValue", name)
        node.name = name
        node.outputs[0].default_value = value
        return Expression(self, node.outputs[0], name)

    def output(self, name: str, value: Expression) -> None:
        """Make ``value`` the group's output socket ``name``."""
        if self._group_output is None:
            self._group_output = self.node("NodeGroupOutput", "")
        self.link(value, self._group_output.inputs[name])

    def link(self, value: Operand, socket: bpy.types.NodeSocket) -> None:
        if isinstance(value, Expression):
            self.tree.links.new(value.socket, socket)
        elif socket.type == "VECTOR":
            socket.default_value = (value, value, value)
        else:
            socket.default_value = value

    def operate(self, operation: str, *operands: Operand) -> Expression:
        """The value of ``operation``: one of Math's or Vector Math's, or ``CLAMP``."""
        text, binding = _text(operation, operands)
        if operation == "CLAMP":
            node = self.node("ShaderNodeClamp", text)
        else:
            colour = any(isinstance(operand, Expression) and operand.is_colour for operand in operands)
            node = self.node("ShaderNodeVectorMath" if colour else "ShaderNodeMath", text)
            node.operation = operation
        for operand, socket in zip(operands, node.inputs, strict=False):
            self.link(operand, socket)
        return Expression(self, node.outputs[0], text, binding)

    def arrange(self) -> None:
        """Lay the finished graph out, left to right."""
        arrange(self.tree)


def minimum(left: Expression, right: Operand) -> Expression:
    return left.graph.operate("MINIMUM", left, right)


def maximum(left: Expression, right: Operand) -> Expression:
    return left.graph.operate("MAXIMUM", left, right)


def clamp(value: Expression, low: Operand, high: Operand) -> Expression:
    """min(max(value, low), high)"""
    if value.is_colour:
        return minimum(maximum(value, low), high)
    return value.graph.operate("CLAMP", value, low, high)


def exp(value: Expression) -> Expression:
    return value.graph.operate("EXPONENT", value)


def _text(operation: str, operands: tuple[Operand, ...]) -> tuple[str, int]:
    """The formula as a person would write it, and how tightly it binds."""
    texts = [operand.text if isinstance(operand, Expression) else f"{operand:g}" for operand in operands]
    if operation in _FUNCTION:
        return f"{_FUNCTION[operation]}({', '.join(texts)})", _ATOM
    symbol, binding, ordered = _INFIX[operation]
    inner = [operand.binding if isinstance(operand, Expression) else _ATOM for operand in operands]
    if inner[0] < binding:
        texts[0] = f"({texts[0]})"
    if inner[1] < binding or (ordered and inner[1] == binding):
        texts[1] = f"({texts[1]})"
    if operation == "MULTIPLY" and texts[0] == "-1":
        return f"-{texts[1]}", binding
    return f"{texts[0]} {symbol} {texts[1]}", binding
