# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces for bounce curves to be fitted to, and fits as users run them."""

from __future__ import annotations

import bpy
import numpy as np

from .bakes import change_settings, operators
from .meshes import add_mesh

FIT = "multibounce_ao_fit"


def trench(name: str = "Trench", **where) -> bpy.types.Object:
    """Square trenches side by side, of quads small enough to shade each other."""
    t = np.linspace(0, 4, 33)
    height = np.where(np.arange(33) // 4 % 2, 0.0, 0.5)
    points = [(x, y, z) for y in (0.0, 2.0, 4.0) for x, z in zip(t, height, strict=True)]
    faces = [(i + 33 * j, i + 1 + 33 * j, i + 34 + 33 * j, i + 33 + 33 * j) for j in range(2) for i in range(32)]
    return add_mesh(name, points, faces, smooth=False, **where)


def relief(name: str = "Relief", size=(24, 16), is_float: bool = True) -> bpy.types.Image:
    """Hills that tile."""
    width, height = size
    image = bpy.data.images.new(name, width, height, float_buffer=is_float)
    x, y = np.meshgrid(np.arange(width) / width, np.arange(height) / height)
    hills = 0.5 + 0.25 * (np.sin(4 * np.pi * x) + np.cos(4 * np.pi * y))
    set_heights(image, hills)
    return image


def set_heights(image: bpy.types.Image, heights) -> None:
    rgba = np.repeat(np.asarray(heights, np.float32)[..., None], 4, axis=-1)
    rgba[..., 3] = 1
    image.pixels.foreach_set(rgba.ravel())


def fit(samples: int = 16, **settings) -> dict:
    """The button; returns what it stored on the scene."""
    change_settings(samples=samples, **settings)
    assert bpy.ops.multibounce_ao.fit_bounces() == {"FINISHED"}
    return bpy.context.scene[FIT].to_dict()


def fit_generator(source: bpy.types.ID, threads: int | None = None, **settings):
    """The same fit, not yet begun, of an object or image."""
    change_settings(**{"samples": 16} | settings)
    fit_settings = operators("fit_sources").FitSettings.of(bpy.context.scene)
    return operators("fit_job").fit_bounces(bpy.context, source, fit_settings, threads)


def report_of(source: bpy.types.ID, **options):
    """The same fit; returns its report."""
    return operators("progress").drive(fit_generator(source, **options), lambda progress: None)
