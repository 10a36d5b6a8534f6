# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a subject, renders it by every model and by path tracing, and takes the differences."""

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
import renders

from .models import MODELS, Shaders
from .subjects import Albedo, Subject

BOUNCES = 64
TEXTURE_SIZE = 512
MODEL_SAMPLES = 64


@dataclass(frozen=True)
class Difference:
    """Of linear RGB from path tracing, over the pixels that surfaces cover wholly: mean absolute, rms, mean."""

    absolute: float
    rms: float
    bias: float

    @classmethod
    def between(cls, render: np.ndarray, truth: np.ndarray) -> "Difference":
        covered = (render[..., 3] > 0.999) & (truth[..., 3] > 0.999)
        d = (render - truth)[covered][:, :3]
        return cls(float(np.abs(d).mean()), float(np.sqrt(np.mean(d**2))), float(d.mean()))


@dataclass(frozen=True)
class Comparison:
    """One subject in grey or in its own colours: `renders` by the models' names, linear RGBA (height, width, 4).

    halves    two path-traced pictures of other seeds; the truth is their mean
    openness  what the surface curve knew of the scene
    """

    subject: Subject
    own_colours: bool
    halves: np.ndarray
    renders: dict[str, np.ndarray]
    openness: float

    @property
    def name(self) -> str:
        return f"{self.subject.name}_{'colour' if self.own_colours else 'grey'}"

    @property
    def truth(self) -> np.ndarray:
        return self.halves.mean(axis=0)

    @property
    def noise(self) -> float:
        """Mean |difference| that the truth's own noise makes: halves differ by twice what their mean is off."""
        return Difference.between(*self.halves).absolute / 2

    def difference(self, model: str) -> Difference:
        return Difference.between(self.renders[model], self.truth)

    def save(self, folder: Path) -> None:
        kept = {"halves": self.halves, "openness": self.openness, **self.renders}
        np.savez_compressed(folder / f"{self.name}.npz", **{key: np.float32(value) for key, value in kept.items()})

    @classmethod
    def load(cls, folder: Path, subject: Subject, own_colours: bool) -> "Comparison":
        empty = cls(subject, own_colours, np.empty(0), {}, 0.0)
        with np.load(folder / f"{empty.name}.npz") as kept:
            found = {key: kept[key].astype(float) for key in kept.files}
        return cls(subject, own_colours, found.pop("halves"), found, float(found.pop("openness")))


def compare(
    package: str, subject: Subject, rays: int, samples: int, say: Callable[[str], None]
) -> Iterator[Comparison]:
    """The subject in grey, then in its own colours: `rays` from each point, `samples` a pixel of the path tracing."""
    to_vertices, to_textures = subject.build()
    albedo = Albedo()
    renders.set_up()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = subject.size
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    settings = scene.multibounce_ao
    settings.use_material_nodes, settings.samples, settings.resolution = False, rays, TEXTURE_SIZE

    def bake(bounces: str) -> None:
        say(f"{subject.name}: baking {bounces}")
        settings.bounces = bounces
        for settings.target, chosen in (("VERTEX", to_vertices), ("TEXTURE", to_textures)):
            for obj in bpy.context.view_layer.objects:
                obj.select_set(obj in chosen)
            bpy.context.view_layer.objects.active = chosen[0]
            bpy.ops.multibounce_ao.bake()

    bake("BAKED")
    openness = importlib.import_module(f"{package}.operators.openness").baked_openness(to_vertices + to_textures)
    shaders = None
    for own_colours in (False, True):
        albedo.show(own_colours)
        bake("RADIOSITY")
        shaders = shaders or Shaders(package, albedo, to_textures, openness)
        say(f"{subject.name}: rendering the models")
        renders.light_world(0)
        passes = renders.render(MODEL_SAMPLES, bounces=0)
        say(f"{subject.name}: path tracing {samples} samples")
        shaders.show_diffuse()
        renders.light_world(1)
        halves = []
        for scene.cycles.seed in (1, 2):
            halves.append(renders.render(samples // 2, BOUNCES)["Combined"])
        shaders.show_principled()
        shades = {model.name: passes[model.name] for model in MODELS}
        yield Comparison(subject, own_colours, np.stack(halves), shades, openness)
