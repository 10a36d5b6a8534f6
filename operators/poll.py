# SPDX-License-Identifier: GPL-3.0-or-later
"""When an operator is available, and what its greyed-out button says."""

from __future__ import annotations

import bpy


def object_mode_with(
    operator: type[bpy.types.Operator], context: bpy.types.Context, objects: list[bpy.types.Object], nothing: str
) -> bool:
    """Whether ``context`` is in Object Mode and there are ``objects`` to work on; tells why not (``nothing``)."""
    if context.mode != "OBJECT":
        operator.poll_message_set("Switch to Object Mode first")
        return False
    if not objects:
        operator.poll_message_set(nothing)
        return False
    return True
