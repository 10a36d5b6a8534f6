# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel of bounce curves: what they are simulated on, the buttons, and the fit that the scene has."""

from __future__ import annotations

import bpy

from ..shader_nodes.multibounce_fit import STORED_FIT
from .sidebar import SidebarPanel


class MULTIBOUNCE_AO_PT_fit(SidebarPanel, bpy.types.Panel):
    bl_label = "Bounce Curves"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        layout = self.layout
        column = self._column(layout)
        column.template_ID(settings, "height_map", open="image.open", text="Height Map")
        amplitude = column.row()
        amplitude.active = settings.height_map is not None
        amplitude.prop(settings, "height_map_amplitude")
        layout.operator("multibounce_ao.fit_bounces", icon="FCURVE")

        fit = context.scene.get(STORED_FIT)
        if fit is not None and "source" in fit:
            self._fit(layout, fit)
            layout.operator("multibounce_ao.clear_fit", icon="LOOP_BACK")
        layout.operator("multibounce_ao.add_curve_nodes", icon="NODE_MATERIAL")

    def _fit(self, layout: bpy.types.UILayout, fit) -> None:
        lines = (
            ("Fit of", fit["source"]),
            ("Coefficients", f"{fit['a']:.4g}, {fit['b']:.4g}"),
            ("AO", f"RMS error {fit['f0_rms']:.4f}"),
            ("First Bounce", f"RMS error {fit['f1_rms']:.4f}"),
        )
        self._table(layout, lines)
