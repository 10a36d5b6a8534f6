# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does in the window, and sees there."""

from __future__ import annotations

import importlib
import shutil
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

import bpy
from enable_extension import PACKAGE

TAB = "Multibounce AO"


def module(name: str) -> ModuleType:
    """A module of the installed extension."""
    return importlib.import_module(f"{PACKAGE}.{name}")


def running():
    """The bake that the window drives, if any."""
    return module("operators.modal").running()


def window() -> bpy.types.Window:
    return bpy.context.window_manager.windows[0]


def viewport() -> bpy.types.Area:
    return max((area for area in window().screen.areas if area.type == "VIEW_3D"), key=lambda area: area.width)


def region(kind: str) -> bpy.types.Region:
    return next(region for region in viewport().regions if region.type == kind)


@contextmanager
def in_viewport() -> Iterator[None]:
    """For operators that are called by name."""
    with bpy.context.temp_override(window=window(), area=viewport(), region=region("WINDOW")):
        yield


def press(key: str, **modifiers: bool) -> None:
    """A key, with the mouse where it is."""
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=mouse[0], y=mouse[1], **modifiers)


mouse = [0, 0]


def move_to(x: float, y: float) -> None:
    mouse[:] = int(x), int(y)
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=mouse[0], y=mouse[1])


def move_into_view() -> None:
    view = region("WINDOW")
    move_to(view.x + 0.4 * view.width, view.y + 0.4 * view.height)


def click_first_button() -> Generator[float, None, None]:
    """The first in the panel: under the panel's title, and one and a half rows high."""
    sidebar, scale = region("UI"), bpy.context.preferences.system.ui_scale
    move_to(sidebar.x + 0.4 * sidebar.width, sidebar.y + sidebar.height - 47 * scale)
    yield 0.2
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type="LEFTMOUSE", value=value, x=mouse[0], y=mouse[1])
    yield 0.05


def open_sidebar() -> Generator[float | Callable[[], bool], None, None]:
    """N, and the extension's tab."""
    move_into_view()
    yield 0.2
    if not viewport().spaces.active.show_region_ui:
        press("N")
    yield lambda: region("UI").width > 1
    region("UI").tag_redraw()
    yield lambda: _has_tabs()
    region("UI").active_panel_category = TAB
    region("UI").tag_redraw()
    yield 0.3


def _has_tabs() -> bool:
    """They are known when the sidebar was drawn once."""
    try:
        region("UI").active_panel_category = TAB
    except (AttributeError, TypeError):
        return False
    return True


def photograph(path: Path) -> None:
    """Keep what the display shows now."""
    shutil.copy(path.with_name("Xvfb_screen0"), path)


def monkeys(count: int = 1) -> list[bpy.types.Object]:
    """Suzannes in place of all that the scene has; the first is active, and all are selected."""
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.meshes])
    with in_viewport():
        for index in range(count):
            bpy.ops.mesh.primitive_monkey_add(location=(3.0 * index, 0.0, 0.0))
            bpy.ops.object.shade_smooth()
        made = list(bpy.data.objects)
        for obj in made:
            obj.select_set(True)
        bpy.context.view_layer.objects.active = made[0]
    return made


def change_settings(**values) -> None:
    settings = window().scene.multibounce_ao
    for name, value in values.items():
        setattr(settings, name, value)


# A bake that takes minutes, of a mesh that is compared in a moment.
FOR_MINUTES = {"target": "TEXTURE", "resolution": 256, "samples": 2**15}
