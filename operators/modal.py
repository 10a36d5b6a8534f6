# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work behind a button: in the window it runs beside the artist's own, from a script or in background it blocks.

The work is a generator that computes everything before it writes anything. Here a timer drives it, so that Blender
draws and listens in between; closing it cancels. What would pull the data away from under it ends it before: undo and
redo (as Blender ends its own jobs then), another file, the closing of its window. Deleted objects and Edit Mode are the
generator's own to find, see :mod:`.bake_job`; it writes only when its window is back in Object Mode, so that undo takes
back all of it in one step.
"""

from __future__ import annotations

import time
from collections.abc import Generator
from typing import TYPE_CHECKING, Any

import bpy

from ..core.workers import giving_way
from .progress import Pace, Progress, StderrProgress, drive
from .report import BakeError

if TYPE_CHECKING:
    from .preview_overlay import PreviewOverlay

# Seconds between steps, the most that one takes where there is always something new, and between drawings of it.
TICK, STEP, REDRAW = 0.04, 0.01, 0.25


class Running:
    """Work that the window drives; the panel draws its progress."""

    def __init__(
        self,
        label: str,
        work: Generator[Progress, None, Any],
        context: bpy.types.Context,
        overlay: PreviewOverlay | None = None,
    ):
        self.label = label
        self.progress = Progress(0.0, "")
        self.pace = Pace()
        self.ended: str | None = None
        """Why it came to an end before its own; None while it goes on."""
        self.waits = False
        """Whether the result waits for Object Mode."""
        self._work, self._overlay = work, overlay
        self._scene, self._view_layer = context.scene, context.view_layer
        self._timer = context.window_manager.event_timer_add(TICK, window=context.window)
        self._drawn = 0.0
        self._workspaces: set[str] = set()

    def step(self, context: bpy.types.Context) -> None:
        """Go on for a moment. Raises StopIteration with the result, BakeError, and whatever else the work raises;
        ReferenceError where its scene or view layer was removed."""
        if self._view_layer not in list(self._scene.view_layers):  # which raises the same where the scene is gone
            raise ReferenceError
        until = time.perf_counter() + STEP
        self.waits = self.progress.ready and context.mode != "OBJECT"
        # The work's own scene, whichever the window shows by now.
        with context.temp_override(scene=self._scene, view_layer=self._view_layer), giving_way():
            while not self.waits:
                before, self.progress = self.progress, next(self._work)
                self.pace(self.progress)
                if self.progress == before or self.progress.ready or time.perf_counter() > until:
                    break
        if self._overlay is not None:
            self._overlay.update(context.window_manager)
        if time.perf_counter() - self._drawn > REDRAW:
            self._drawn = time.perf_counter()
            self._show(context)

    def end(self, reason: str) -> None:
        """Stop, with nothing written; ``reason`` is what the artist is told."""
        if self._overlay is not None:
            self._overlay.remove(bpy.context.window_manager)
        if self.ended is None:
            self.ended = reason
            self._work.close()

    def clean_up(self, context: bpy.types.Context) -> None:
        """Take back what the window shows of it, and let the next begin."""
        global _running
        context.window_manager.event_timer_remove(self._timer)
        for name in self._workspaces & set(bpy.data.workspaces.keys()):
            bpy.data.workspaces[name].status_text_set(None)
        self._redraw(context)
        if _running is self:
            _running = None

    def text(self) -> str:
        """How far it is."""
        return "Done" if self.waits else f"{int(100 * self.progress.fraction)} %  {self.progress.name}"

    def details(self) -> str:
        """How fast it is and how long it will take, or what it waits for."""
        if self.waits:
            return "Switch to Object Mode to store it"
        return "    ".join(filter(None, (self.pace.text(), self.progress.note)))

    def _show(self, context: bpy.types.Context) -> None:
        if context.workspace is not None:
            self._workspaces.add(context.workspace.name)
            context.workspace.status_text_set(
                "    ".join(filter(None, (self.label, self.text(), self.details(), "Esc: Cancel")))
            )
        self._redraw(context)

    def _redraw(self, context: bpy.types.Context) -> None:
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                for region in area.regions if area.type == "VIEW_3D" else ():
                    if region.type == "UI":
                        region.tag_redraw()


_running: Running | None = None


def running() -> Running | None:
    """What is at work in the window, if anything."""
    return _running


class LongOperator:
    """To be derived from before ``bpy.types.Operator``. The operator says what the :meth:`work` is, and :meth:`tell`
    reports its result."""

    def work(self, context: bpy.types.Context) -> Generator[Progress, None, Any]:
        """The work, which raises BakeError where it cannot be done."""
        raise NotImplementedError

    def work_in_window(
        self, context: bpy.types.Context
    ) -> tuple[Generator[Progress, None, Any], PreviewOverlay | None]:
        """The same, and what shows it while it goes on."""
        return self.work(context), None

    def tell(self, result: Any) -> set[str]:
        """Report the ``result`` of the work; returns what the operator does."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        cursor = context.window_manager
        show = StderrProgress() if bpy.app.background else lambda step: cursor.progress_update(int(100 * step.fraction))
        cursor.progress_begin(0, 100)
        try:
            result = drive(self.work(context), show)
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            cursor.progress_end()
        return self.tell(result)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        global _running
        if bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            work, overlay = self.work_in_window(context)
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._run = _running = Running(self.bl_label, work, context, overlay)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        run = self._run
        if event.type == "ESC" and event.value == "PRESS":
            run.end("Cancelled: nothing was changed")
        elif event.type != "TIMER" and run.ended is None:
            return {"PASS_THROUGH"}
        going_on = False
        try:
            if run.ended is not None:
                self.report({"INFO"}, run.ended)
                return {"CANCELLED"}
            run.step(context)
            going_on = True
            return {"PASS_THROUGH"}
        except StopIteration as finished:
            return self.tell(finished.value)
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except ReferenceError:  # of objects the work itself tells
            self.report({"ERROR"}, f"{self.bl_label} has lost its scene, and changed nothing")
            return {"CANCELLED"}
        finally:
            if not going_on:
                run.end("")
                run.clean_up(context)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender's own: the window closes."""
        self._run.end("The window was closed")
        self._run.clean_up(context)


class MULTIBOUNCE_AO_OT_cancel(bpy.types.Operator):
    """Stop the bake that is running. Nothing is changed"""

    bl_idname = "multibounce_ao.cancel"
    bl_label = "Cancel Bake"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _running is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        _running.end("Cancelled: nothing was changed")
        return {"FINISHED"}


@bpy.app.handlers.persistent
def _end_before_undo(*_: object) -> None:
    if _running is not None:
        _running.end(f"{_running.label} was ended by undo, and changed nothing: start it again")


@bpy.app.handlers.persistent
def _end_before_load(*_: object) -> None:
    if _running is not None:
        _running.end("Another file was opened")
        _running.clean_up(bpy.context)


def register() -> None:
    bpy.app.handlers.undo_pre.append(_end_before_undo)
    bpy.app.handlers.redo_pre.append(_end_before_undo)
    bpy.app.handlers.load_pre.append(_end_before_load)


def unregister() -> None:
    _end_before_load()
    bpy.app.handlers.load_pre.remove(_end_before_load)
    bpy.app.handlers.redo_pre.remove(_end_before_undo)
    bpy.app.handlers.undo_pre.remove(_end_before_undo)
