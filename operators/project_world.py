# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the World's light: project it, forget it, and add it to a material."""

from __future__ import annotations

from collections.abc import Generator

import bpy

from ..core.spherical_harmonics import Y0
from ..core.workers import mapped
from ..shader_nodes.cone_light import STORED_WORLD, show_world
from .bake_record import baked_source
from .material_nodes import add_world_light
from .modal import LongOperator
from .poll import nothing_runs
from .progress import Progress, drive
from .version import extension_version

# Each rendering in the window is to be short, since Blender draws nothing else meanwhile; each takes its time to begin.
STRIPS = 4


class MULTIBOUNCE_AO_OT_project_world(LongOperator, bpy.types.Operator):
    """Project the light of the scene's World for the bent-cone nodes. Press again after changing the World"""

    bl_idname = "multibounce_ao.project_world"
    bl_label = "Project World"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return nothing_runs(cls)

    def work(self, context: bpy.types.Context, strips: int = 1) -> Generator[Progress, None, bpy.types.Scene]:
        return projecting(context.scene, strips)

    def work_in_window(self, context: bpy.types.Context) -> tuple[Generator[Progress, None, bpy.types.Scene], None]:
        return self.work(context, STRIPS), None

    def tell(self, scene: bpy.types.Scene) -> set[str]:
        self.report({"INFO"}, summary(scene))
        return {"FINISHED"}


class MULTIBOUNCE_AO_OT_clear_world(bpy.types.Operator):
    """Forget the projected World: the bent-cone nodes take it to be white, as plain ambient occlusion does"""

    bl_idname = "multibounce_ao.clear_world"
    bl_label = "Use White World"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if STORED_WORLD not in context.scene:
            cls.poll_message_set("No World is projected: the nodes take it to be white")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        del context.scene[STORED_WORLD]
        show_world(context.scene)
        return {"FINISHED"}


class MULTIBOUNCE_AO_OT_add_world_light(bpy.types.Operator):
    """Light the active material by the projected World, from the directions in which each point sees the sky"""

    bl_idname = "multibounce_ao.add_world_light"
    bl_label = "Add World Light"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = context.active_object
        if obj is None or obj.active_material is None:
            cls.poll_message_set("No active material: select an object and give it a material")
            return False
        if obj.active_material.library is not None:
            cls.poll_message_set(f"Material '{obj.active_material.name}' is linked: make it local first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj, material = context.active_object, context.active_object.active_material
        source = baked_source(obj)
        if source is None:
            self.report({"ERROR"}, f"Object '{obj.name}' has no bake: bake it first")
            return {"CANCELLED"}
        if not add_world_light(material, source):
            self.report({"ERROR"}, f"Material '{material.name}' has no multibounce nodes: add them first")
            return {"CANCELLED"}
        if STORED_WORLD not in context.scene:
            self.report({"INFO"}, "The World is taken to be white: press Project World")
        return {"FINISHED"}


def projecting(scene: bpy.types.Scene, strips: int) -> Generator[Progress, None, bpy.types.Scene]:
    """Store the light of the World of ``scene`` on it, which is returned, and show it in the node groups of the file.
    ``strips`` as for :func:`.world_radiance.world_coefficients`. Raises BakeError, and then nothing has changed."""
    from .world_radiance import world_coefficients  # here, with much of core: enabling the extension stays instant

    name, frame = scene.world.name if scene.world is not None else "", scene.frame_current
    work = world_coefficients(scene, strips)
    red, green, blue = (yield from mapped(work, lambda done: Progress(done, name))).T.tolist()
    scene[STORED_WORLD] = {
        "red": red,
        "green": green,
        "blue": blue,
        "world": name,
        "frame": frame,
        "version": extension_version(),
    }
    show_world(scene)
    return scene


def project_world(scene: bpy.types.Scene) -> None:
    """The same at once."""
    drive(projecting(scene, strips=1), lambda progress: None)


def summary(scene: bpy.types.Scene) -> str:
    """What was projected, in one line."""
    stored = scene[STORED_WORLD]
    return f"Projected World '{stored['world']}', mean {mean_text(stored)}"


def mean_text(stored) -> str:
    """Mean radiance of a projected World: red, green, blue."""
    return ", ".join(f"{Y0 * stored[name][0]:.3g}" for name in ("red", "green", "blue"))
