# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes as users run them, and what they leave."""

from __future__ import annotations

import importlib
from types import ModuleType

import bpy
import numpy as np
from enable_extension import PACKAGE

MULTIBOUNCE_AO, BENT_CONE, RADIOSITY = "Multibounce AO", "Bent Cone", "Multibounce Radiosity"


def operators(name: str) -> ModuleType:
    """A module of the extension's ``operators``."""
    return importlib.import_module(f"{PACKAGE}.operators.{name}")


def change_settings(**settings) -> None:
    for name, value in settings.items():
        setattr(bpy.context.scene.multibounce_ao, name, value)


def select(*objects: bpy.types.Object) -> None:
    """Exactly these; the first is active."""
    bpy.context.view_layer.update()
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj in objects)
    bpy.context.view_layer.objects.active = objects[0] if objects else None


def bake(*objects: bpy.types.Object, samples: int = 64, **settings) -> None:
    """The button. Raises RuntimeError with its message where nothing could be baked."""
    change_settings(samples=samples, **settings)
    select(*objects)
    assert bpy.ops.multibounce_ao.bake() == {"FINISHED"}


def clear(*objects: bpy.types.Object) -> None:
    select(*objects)
    assert bpy.ops.multibounce_ao.clear() == {"FINISHED"}


def generator(*objects: bpy.types.Object, threads: int | None = None, samples: int = 64, **settings):
    """The same bake, not yet begun."""
    change_settings(samples=samples, **settings)
    select(*objects)
    bake_settings = operators("settings").BakeSettings.of(bpy.context.scene)
    return operators("bake_job").bake(bpy.context, list(objects), bake_settings, threads)


def reports(*objects: bpy.types.Object, **options) -> list:
    """The same bake; returns the report of each object."""
    return operators("progress").drive(generator(*objects, **options), lambda progress: None)


def attribute(obj: bpy.types.Object, name: str = MULTIBOUNCE_AO) -> np.ndarray:
    """(n, 4) float64, one row a vertex or face corner."""
    data = obj.data.attributes[name].data
    values = np.empty(len(data) * 4, np.float32)
    data.foreach_get("color", values)
    return values.reshape(-1, 4).astype(np.float64)


def f0(obj: bpy.types.Object) -> np.ndarray:
    return attribute(obj)[:, 0]


def alpha(obj: bpy.types.Object) -> np.ndarray:
    return attribute(obj, BENT_CONE)[:, 3]


def pixels(image: bpy.types.Image) -> np.ndarray:
    """(h, w, 4) float32, bottom row first."""
    width, height = image.size
    values = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(height, width, 4)


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
