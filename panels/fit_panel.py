# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel of bounce curves: what they are simulated on, the button, and the fit that the scene has."""

from __future__ import annotations

import bpy

from ..shader_nodes.multibounce_fit import STORED_FIT


class MULTIBOUNCE_AO_PT_fit(bpy.types.Panel):
    bl_label = "Bounce Curves"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Multibounce AO"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        settings = context.scene.multibounce_ao
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.template_ID(settings, "height_map", open="image.open", text="Height Map")
        amplitude = column.row()
        amplitude.active = settings.height_map is not None
        amplitude.prop(settings, "height_map_amplitude")
        layout.operator("multibounce_ao.fit_bounces", icon="FCURVE")

        fit = context.scene.get(STORED_FIT)
        if fit is not None and "source" in fit:
            self._fit(layout, fit)
            layout.operator("multibounce_ao.clear_fit", icon="LOOP_BACK")

    def _fit(self, layout: bpy.types.UILayout, fit) -> None:
        lines = (
            ("Fit of", fit["source"]),
            ("A, B", f"{fit['a']:.4g}, {fit['b']:.4g}"),
            ("F1 residual", f"{fit['f1_rms']:.4f} rms"),
            ("F0 residual", f"{fit['f0_rms']:.4f} rms"),
        )
        split = layout.split(factor=0.4)
        labels, values = split.column(), split.column()
        labels.alignment = "RIGHT"
        for label, value in lines:
            labels.label(text=label)
            values.label(text=value)
