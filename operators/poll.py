# SPDX-License-Identifier: GPL-3.0-or-later
"""When an operator is available, and what its greyed-out button says."""

from __future__ import annotations

import bpy

from .modal import running


def object_mode_with(
    operator: type[bpy.types.Operator], context: bpy.types.Context, objects: list[bpy.types.Object], nothing: str
) -> bool:
    """Whether ``context`` is in Object Mode, there are ``objects`` to work on, and no bake is running; tells why not
    (``nothing``)."""
    if not nothing_runs(operator):
        return False
    if context.mode != "OBJECT":
        operator.poll_message_set("Switch to Object Mode first")
        return False
    if not objects:
        operator.poll_message_set(nothing)
        return False
    return True


def nothing_runs(operator: type[bpy.types.Operator]) -> bool:
    """Whether no long work is running; tells what is."""
    if running() is not None:
        operator.poll_message_set(f"{running().label} is running: wait for it, or press Esc to cancel it")
        return False
    return True
