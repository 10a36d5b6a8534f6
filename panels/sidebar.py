# SPDX-License-Identifier: GPL-3.0-or-later
"""What all panels share: their place in the sidebar, a column of settings, a table of results."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

import bpy


class SidebarPanel:
    """To be derived from before ``bpy.types.Panel``."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Multibounce AO"

    def _column(self, layout: bpy.types.UILayout) -> bpy.types.UILayout:
        """For settings: names to the left, values to the right."""
        layout.use_property_split = True
        layout.use_property_decorate = False
        return layout.column()

    def _table(self, layout: bpy.types.UILayout, lines: Iterable[tuple[str, str]]) -> None:
        """A name and its value a line."""
        split = layout.split(factor=0.4)
        names, values = split.column(), split.column()
        names.alignment = "RIGHT"
        for name, value in lines:
            names.label(text=name)
            values.label(text=value)

    def _wrapped(self, context: bpy.types.Context, text: str, icon: str = "ERROR") -> None:
        """Labels do not wrap: a line a label, by a rough width of a letter; ``icon`` before the first."""
        letters = max(20, int(context.region.width / context.preferences.system.ui_scale / 7))
        column = self.layout.column(align=True)
        for line, words in enumerate(textwrap.wrap(text, letters)):
            column.label(text=words, icon="BLANK1" if line and icon != "NONE" else icon)
