# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of the World's light: project it, forget it, and add it to a material."""

from __future__ import annotations

import bpy

from ..core.spherical_harmonics import Y0
from ..shader_nodes.cone_light import STORED_WORLD, show_world
from .bake_record import baked_source
from .material_nodes import add_world_light
from .report import BakeError
from .version import extension_version
from .world_radiance import world_coefficients


class MULTIBOUNCE_AO_OT_project_world(bpy.types.Operator):
    """Project the light of the scene's World for the bent-cone nodes. Press again after changing the World"""

    bl_idname = "multibounce_ao.project_world"
    bl_label = "Project World"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            project_world(context.scene)
        except BakeError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, summary(context.scene))
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
    """Let the multibounce nodes of the active material take the World's light from where the sky is seen"""

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


def project_world(scene: bpy.types.Scene) -> None:
    """Store the light of the World of ``scene`` on it, and show it in the node groups of the file. Raises BakeError,
    and then nothing has changed."""
    red, green, blue = world_coefficients(scene).T.tolist()
    scene[STORED_WORLD] = {
        "red": red,
        "green": green,
        "blue": blue,
        "world": scene.world.name,
        "frame": scene.frame_current,
        "version": extension_version(),
    }
    show_world(scene)


def summary(scene: bpy.types.Scene) -> str:
    """What was projected, in one line."""
    stored = scene[STORED_WORLD]
    return f"Projected World '{stored['world']}', mean {mean_text(stored)}"


def mean_text(stored) -> str:
    """Mean radiance of a projected World: red, green, blue."""
    return ", ".join(f"{Y0 * stored[name][0]:.3g}" for name in ("red", "green", "blue"))
