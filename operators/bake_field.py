# SPDX-License-Identifier: GPL-3.0-or-later
"""The button: bake the AO field of the active object."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING

import bpy

from .modal import LongOperator
from .poll import object_mode_with
from .progress import Progress
from .report import count_text

if TYPE_CHECKING:
    from .field_job import FieldReport


class MULTIBOUNCE_AO_OT_bake_field(LongOperator, bpy.types.Operator):
    """Bake what the active object blocks of the sky all around it, for it to darken whatever comes near"""

    bl_idname = "multibounce_ao.bake_field"
    bl_label = "Bake AO Field"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        source = field_source(context)
        nothing = "The active object is no mesh: make the one that casts the occlusion active"
        return object_mode_with(cls, context, [source] if source is not None else [], nothing)

    def work(self, context: bpy.types.Context) -> Generator[Progress, None, FieldReport]:
        from .field_job import FieldSettings, bake_object_field  # here: enabling the extension stays instant

        return bake_object_field(context, field_source(context), FieldSettings.of(context.scene))

    def tell(self, report: FieldReport) -> set[str]:
        for warning in report.warnings:
            self.report({"WARNING"}, f"'{report.name}': {warning}")
        self.report({"INFO"}, summary(report))
        return {"FINISHED"}


def field_source(context: bpy.types.Context) -> bpy.types.Object | None:
    """The object whose field is baked: the active one, if it is a mesh."""
    obj = context.active_object
    return obj if obj is not None and obj.type == "MESH" else None


def summary(report: FieldReport) -> str:
    """What a bake did, in one line."""
    return (
        f"Baked the AO field of '{report.name}': {report.resolution} x {report.resolution}, "
        f"{count_text(report.points)} points, {count_text(report.rays)} rays in {report.seconds:.1f} s"
    )
