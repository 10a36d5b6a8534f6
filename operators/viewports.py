# SPDX-License-Identifier: GPL-3.0-or-later
"""The 3D viewports of all windows."""

from __future__ import annotations

import bpy


def redraw_viewports(manager: bpy.types.WindowManager) -> None:
    """Draw them anew, with their sidebars."""
    for window in manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
