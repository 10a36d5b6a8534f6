# SPDX-License-Identifier: GPL-3.0-or-later
"""One copy of each node group in the file, brought up to date in place.

A group of ours is a *local* shader node tree with the group's name that carries two custom properties: which group it
is, and the version of the code that built it. Linked groups are left alone: they cannot be edited, and the library they
come from may go.

Where the name is taken by a node group that is not ours, that one is the artist's: it keeps its name and its nodes, and
ours is called ``<name> (extension)``. So hold on to the tree that ``ensure()`` returns; do not look it up by name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import bpy

_GROUP_KEY = "multibounce_ao_group"
_VERSION_KEY = "multibounce_ao_version"


@dataclass(frozen=True)
class Socket:
    """One socket of a group's interface. ``type`` is a ``NodeSocket...`` id; None keeps Blender's default."""

    name: str
    type: str
    description: str
    default_value: Any = None
    min_value: float | None = None
    max_value: float | None = None
    subtype: str | None = None


def ensure_group(
    name: str,
    version: int,
    inputs: Sequence[Socket],
    outputs: Sequence[Socket],
    build: Callable[[bpy.types.ShaderNodeTree], None],
) -> bpy.types.ShaderNodeTree:
    """The group ``name``, made where it is missing and rebuilt in place where it is older than ``version``.

    A rebuilt group stays the same data-block and keeps its sockets, known by name: the materials that use it keep their
    links and values. A group of the same or a newer version is returned as it is. ``build(tree)`` adds the nodes to a
    tree that has its interface and is otherwise empty.
    """
    tree, free_name = find_group(name)
    if tree is None:
        tree = bpy.data.node_groups.new(free_name, "ShaderNodeTree")
    elif tree.get(_VERSION_KEY, 0) >= version:
        return tree
    tree.nodes.clear()
    _update_interface(tree, inputs, outputs)
    build(tree)
    tree[_GROUP_KEY] = name
    # last: a build that fails half-way is done again the next time
    tree[_VERSION_KEY] = version
    return tree


def find_group(name: str) -> tuple[bpy.types.ShaderNodeTree | None, str]:
    """Our local group ``name``, or None and a name that is free for it."""
    free_name = name
    # the key (name, None) finds local data only
    while (tree := bpy.data.node_groups.get((free_name, None))) is not None:
        if tree.bl_idname == "ShaderNodeTree" and tree.get(_GROUP_KEY) == name:
            return tree, free_name
        free_name += " (extension)"
    return None, free_name


def rename_group(tree: bpy.types.ShaderNodeTree, name: str) -> None:
    """Make ``tree``, one of our groups, the group ``name``, which no other of ours is."""
    _, free_name = find_group(name)
    tree.name = free_name
    tree[_GROUP_KEY] = name


def outdate_group(tree: bpy.types.ShaderNodeTree) -> None:
    """Let the next :func:`ensure_group` build ``tree``, one of our groups, anew."""
    tree[_VERSION_KEY] = 0


def _update_interface(tree: bpy.types.ShaderNodeTree, inputs: Sequence[Socket], outputs: Sequence[Socket]) -> None:
    """Make the interface what it should be. A socket of the right name keeps its identifier, and so its links."""
    interface = tree.interface
    # outputs first: the order in which Blender draws them
    wanted = {("OUTPUT", socket.name): socket for socket in outputs}
    wanted.update({("INPUT", socket.name): socket for socket in inputs})
    present = {}
    for item in list(interface.items_tree):
        key = (item.in_out, item.name) if item.item_type == "SOCKET" else None
        if key in wanted and key not in present:
            present[key] = item
        else:
            interface.remove(item)
    for position, (key, socket) in enumerate(wanted.items()):
        item = present.get(key) or interface.new_socket(socket.name, in_out=key[0], socket_type=socket.type)
        item.socket_type = socket.type
        interface.move(item, position)
        # Python's view of an item does not follow a change of its type
        item = interface.items_tree[position]
        item.description = socket.description
        for attribute in ("subtype", "min_value", "max_value", "default_value"):
            value = getattr(socket, attribute)
            if value is not None:
                setattr(item, attribute, value)
