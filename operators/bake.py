# SPDX-License-Identifier: GPL-3.0-or-later
"""The button: bake the selected meshes."""

from __future__ import annotations

from collections.abc import Generator
from typing import TYPE_CHECKING

import bpy

from .forecast import remember
from .modal import LongOperator
from .poll import object_mode_with
from .progress import Progress
from .report import BakeError, ObjectReport, count_text
from .settings import BakeSettings

if TYPE_CHECKING:
    from .preview import Preview
    from .preview_overlay import PreviewOverlay


def selected_meshes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """The selected mesh objects, the active one first."""
    meshes = [obj for obj in context.selected_objects if obj.type == "MESH"]
    return sorted(meshes, key=lambda obj: obj != context.active_object)


class MULTIBOUNCE_AO_OT_bake(LongOperator, bpy.types.Operator):
    """Bake ambient occlusion and the light of many bounces for the selected meshes"""

    bl_idname = "multibounce_ao.bake"
    bl_label = "Bake Multibounce AO"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        nothing = "No mesh is selected: select the objects to bake"
        return object_mode_with(cls, context, selected_meshes(context), nothing)

    def work(
        self, context: bpy.types.Context, preview: Preview | None = None
    ) -> Generator[Progress, None, list[ObjectReport]]:
        from .bake_job import bake  # here, with all of core: enabling the extension stays instant

        settings = BakeSettings.of(context.scene)
        one_target = settings.use_selected_to_active and not settings.use_match_names
        if one_target and context.active_object not in selected_meshes(context):
            raise BakeError("Selected to Active bakes onto the active mesh, and none is: select it last")
        self._bounces = settings.bounces
        chosen = context.selected_objects
        return bake(context, selected_meshes(context), settings, selected=chosen, preview=preview)

    def work_in_window(
        self, context: bpy.types.Context
    ) -> tuple[Generator[Progress, None, list[ObjectReport]], PreviewOverlay]:
        from .preview import Preview
        from .preview_overlay import PreviewOverlay

        preview = Preview()
        return self.work(context, preview), PreviewOverlay(preview)

    def tell(self, reports: list[ObjectReport]) -> set[str]:
        failed = [report.error for report in reports if report.error]
        baked = [report for report in reports if report.f0 and not report.error]
        for report in reports:
            for warning in report.warnings:
                self.report({"WARNING"}, f"'{report.name}': {warning}")
        if not baked:
            self.report({"ERROR"}, "\n".join(failed))
            return {"CANCELLED"}
        for message in failed:
            self.report({"WARNING"}, message)
        remember(baked, self._bounces)
        points, rays = sum(r.points for r in baked), sum(r.rays for r in baked)
        seconds = sum(r.seconds for r in baked)
        names = f"'{baked[0].name}'" if len(baked) == 1 else f"{len(baked)} objects"
        self.report({"INFO"}, f"Baked {names}: {count_text(points)} points, {count_text(rays)} rays in {seconds:.1f} s")
        return {"FINISHED"}
