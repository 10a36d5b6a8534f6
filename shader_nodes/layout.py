# SPDX-License-Identifier: GPL-3.0-or-later
"""Lays a node tree out as a derivation is written: one line a frame, each line read from left to right.

A node stands in the column just left of the first node that reads it, so all links run to the right and values are made
where they are needed. Blender measures nodes only when it draws them, and in background it never does: sizes are
estimated from what a node shows.
"""

from __future__ import annotations

from collections import defaultdict

import bpy

# Interface units at a scale of 1: Blender's node header, a row of buttons, and what a frame draws around its nodes.
_HEADER, _ROW, _CHARACTER = 30, 22, 7
_GAP_X, _GAP_Y = 50, 20
_LINE_GAP = 110


def arrange(tree: bpy.types.NodeTree) -> None:
    """Place every node of ``tree``. Nodes outside frames stand at the end of the last line."""
    nodes = [node for node in tree.nodes if node.bl_idname != "NodeFrame"]
    frames = [node for node in tree.nodes if node.bl_idname == "NodeFrame"]
    for node in nodes:
        node.width = max(node.width, 2 * _HEADER + _CHARACTER * len(node.label))
    columns = _columns(tree)

    left = {}
    x = 0.0
    for column in range(min(columns.values()), 1):
        left[column] = x
        x += max((node.width for node in nodes if columns[node.name] == column), default=0.0) + _GAP_X

    y = 0.0
    for frame in frames:
        height: dict[int, float] = defaultdict(float)
        for node in nodes:
            column = columns[node.name]
            if node.parent == frame or (node.parent is None and frame == frames[-1]):
                node.location = (left[column], y - height[column])
                height[column] += _height(node) + _GAP_Y
        y -= max(height.values(), default=0.0) + _LINE_GAP


def _columns(tree: bpy.types.NodeTree) -> dict[str, int]:
    """The column of each node: 0 for the last, negative numbers to its left."""
    readers: dict[str, list[str]] = {node.name: [] for node in tree.nodes if node.bl_idname != "NodeFrame"}
    for link in tree.links:
        readers[link.from_node.name].append(link.to_node.name)
    columns: dict[str, int] = {}

    def column(name: str) -> int:
        if name not in columns:
            columns[name] = min((column(reader) for reader in readers[name]), default=1) - 1
        return columns[name]

    for name in readers:
        column(name)
    return columns


def _height(node: bpy.types.Node) -> float:
    """Estimated height of an open node."""
    # the operation's menu and, for floats, the checkbox "Clamp"
    rows = {"ShaderNodeMath": 2, "ShaderNodeVectorMath": 1, "ShaderNodeClamp": 1, "ShaderNodeSeparateColor": 1}
    count = rows.get(node.bl_idname, 0)
    for socket in (*node.outputs, *node.inputs):
        if socket.enabled and not socket.hide:
            # an unlinked vector shows three fields under its name
            count += 4 if socket.type == "VECTOR" and not socket.is_output and not socket.is_linked else 1
    return _HEADER + _ROW * count
