# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions for the formulas of ``expression``, each one node: of floats, of vectors, and from one to the other."""

from __future__ import annotations

from collections.abc import Sequence

from .expression import Expression, Operand


def sqrt(value: Expression) -> Expression:
    return _function("SQRT", "sqrt", value)


def absolute(value: Expression) -> Expression:
    return _function("ABSOLUTE", "abs", value)


def sign(value: Expression) -> Expression:
    """-1, 0 or 1"""
    return _function("SIGN", "sign", value)


def sine(angle: Expression) -> Expression:
    return _function("SINE", "sin", angle)


def cosine(angle: Expression) -> Expression:
    return _function("COSINE", "cos", angle)


def floor(value: Expression) -> Expression:
    return _function("FLOOR", "floor", value)


def atan2(y: Expression, x: Operand) -> Expression:
    """The angle of (x, y), in (-pi, pi]."""
    return _function("ARCTAN2", "atan2", y, x)


def less_than(left: Expression, right: Operand) -> Expression:
    """1 where ``left`` < ``right``, else 0."""
    return _function("LESS_THAN", "less than", left, right)


def dot(left: Expression, right: Expression | Sequence[float]) -> Expression:
    return _function("DOT_PRODUCT", "dot", left, right, output="Value")


def length(vector: Expression) -> Expression:
    return _function("LENGTH", "length", vector, output="Value")


def cross(left: Expression, right: Expression) -> Expression:
    return _function("CROSS_PRODUCT", "cross", left, right)


def normalised(vector: Expression) -> Expression:
    """Of length 1; zero stays zero."""
    return _function("NORMALIZE", "normalize", vector)


def components(vector: Expression, *names: str) -> tuple[Expression, ...]:
    """x, y and z as floats called ``names``."""
    node = vector.graph.node("ShaderNodeSeparateXYZ", f"{vector.text} = {', '.join(names)}")
    vector.graph.link(vector, node.inputs[0])
    return tuple(Expression(vector.graph, socket, name) for socket, name in zip(node.outputs, names, strict=True))


def vector(x: Expression, y: Operand, z: Operand) -> Expression:
    text = f"({', '.join(_text(each) for each in (x, y, z))})"
    node = x.graph.node("ShaderNodeCombineXYZ", text)
    for each, socket in zip((x, y, z), node.inputs, strict=True):
        x.graph.link(each, socket)
    return Expression(x.graph, node.outputs[0], text)


def select(where: Expression, chosen: Expression, otherwise: Operand) -> Expression:
    """The float ``chosen`` where ``where`` is 1, ``otherwise`` where it is 0, exactly; mixed between."""
    graph = where.graph
    node = graph.node("ShaderNodeMix", f"{where.text} ? {chosen.text} : {_text(otherwise)}")
    node.data_type = "FLOAT"
    sockets = {socket.identifier: socket for socket in node.inputs}
    for value, name in ((where, "Factor_Float"), (otherwise, "A_Float"), (chosen, "B_Float")):
        graph.link(value, sockets[name])
    result = next(socket for socket in node.outputs if socket.identifier == "Result_Float")
    return Expression(graph, result, node.label)


def _function(operation: str, name: str, *operands: Operand | Sequence[float], output: str | None = None) -> Expression:
    graph = operands[0].graph
    text = f"{name}({', '.join(_text(operand) for operand in operands)})"
    node = graph.node("ShaderNodeVectorMath" if operands[0].is_colour else "ShaderNodeMath", text)
    node.operation = operation
    for operand, socket in zip(operands, node.inputs, strict=False):
        if isinstance(operand, Sequence):
            socket.default_value = operand
        else:
            graph.link(operand, socket)
    return Expression(graph, node.outputs[output or 0], text)


def _text(operand: Operand | Sequence[float]) -> str:
    if isinstance(operand, Sequence):
        return f"({', '.join(f'{each:g}' for each in operand)})"
    return operand.text if isinstance(operand, Expression) else f"{operand:g}"
