# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera and sun. The World is set by each picture."""

import bpy
from mathutils import Vector

EYE = Vector((-1.9, -9.4, 2.3))
TARGET = Vector((0.12, 0.0, 1.66))
SUN_FROM = Vector((-0.72, -0.62, 0.62))


def add_camera() -> bpy.types.Object:
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = EYE
    camera.rotation_euler = (TARGET - EYE).to_track_quat("-Z", "Y").to_euler()
    camera.data.lens = 42
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return camera


def add_sun() -> bpy.types.Object:
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.rotation_euler = SUN_FROM.to_track_quat("Z", "Y").to_euler()
    sun.data.color = (1.0, 0.82, 0.58)
    sun.data.energy = 3.6
    sun.data.angle = 0.012
    bpy.context.scene.collection.objects.link(sun)
    return sun
