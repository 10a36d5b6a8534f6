# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons: fit the bounce curves, and go back to the published fit."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING

import bpy

from ..shader_nodes.multibounce_fit import STORED_FIT, show_fit
from .modal import LongOperator
from .poll import object_mode_with
from .progress import Progress
from .report import count_text

if TYPE_CHECKING:
    from .fit_job import FitReport


class MULTIBOUNCE_AO_OT_fit_bounces(LongOperator, bpy.types.Operator):
    """Simulate light that bounces on the active mesh among its occluders, or on the height map, and fit its curves"""

    bl_idname = "multibounce_ao.fit_bounces"
    bl_label = "Fit Bounce Curves"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        source = fit_source(context)
        nothing = "The active object is no mesh: make one active, or choose a height map"
        return object_mode_with(cls, context, [source] if source is not None else [], nothing)

    def work(self, context: bpy.types.Context) -> Generator[Progress, None, FitReport]:
        from .fit_job import fit_bounces  # here: enabling the extension stays instant
        from .fit_sources import FitSettings

        settings = FitSettings.of(context.scene)
        return fit_bounces(context, fit_source(context), settings, selected=context.selected_objects)

    def tell(self, report: FitReport) -> set[str]:
        for warning in report.warnings:
            self.report({"WARNING"}, f"'{report.name}': {warning}")
        self.report({"INFO"}, summary(report))
        return {"FINISHED"}


class MULTIBOUNCE_AO_OT_clear_fit(bpy.types.Operator):
    """Forget the fit of this scene: Multibounce AO Fit goes back to the published coefficients. Plots stay"""

    bl_idname = "multibounce_ao.clear_fit"
    bl_label = "Use Published Fit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if STORED_FIT not in context.scene:
            cls.poll_message_set("The scene has no fit of its own: it uses the published one")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        del context.scene[STORED_FIT]
        show_fit(context.scene)
        return {"FINISHED"}


def fit_source(context: bpy.types.Context) -> bpy.types.Image | bpy.types.Object | None:
    """What a fit is made from: the height map of the settings, else the active object if that is a mesh."""
    height_map = context.scene.multibounce_ao.height_map
    if height_map is not None:
        return height_map
    obj = context.active_object
    return obj if obj is not None and obj.type == "MESH" else None


def summary(report: FitReport) -> str:
    """What a fit found, in one line."""
    fit = report.fit
    return (
        f"Fitted '{report.name}': A {fit['a']:.4g}, B {fit['b']:.4g}, rms {fit['f1_rms']:.4f}, "
        f"from {count_text(report.points)} points in {report.seconds:.1f} s"
    )
