# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel of the World's light: the buttons, and what is projected."""

from __future__ import annotations

import bpy

from ..operators.project_world import mean_text
from ..shader_nodes.cone_light import STORED_WORLD
from .sidebar import SidebarPanel


class MULTIBOUNCE_AO_PT_world(SidebarPanel, bpy.types.Panel):
    bl_label = "World Light"
    bl_parent_id = "MULTIBOUNCE_AO_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator("multibounce_ao.project_world", icon="WORLD")
        stored = context.scene.get(STORED_WORLD)
        if stored is not None and "world" in stored:
            self._table(layout, (("Projected", stored["world"]), ("Mean", mean_text(stored))))
            if context.scene.world is None or context.scene.world.name != stored["world"]:
                layout.label(text="The scene has another World: project it", icon="ERROR")
            layout.operator("multibounce_ao.clear_world", icon="LOOP_BACK")
        layout.operator("multibounce_ao.add_world_light", icon="NODE_MATERIAL")
