# SPDX-License-Identifier: GPL-3.0-or-later
"""What bent cones cost: the time of a bake with their directions, over that of one without; and of Project World.

Whole bakes by the operator, of an unchanged object, in turns. Without: rays are not weighted by their directions, whose
sums then are not there to be turned and stored; alpha stays, which the published fit needs. What counts is the time of
all processors together, on which other programs have little hold.
"""

from __future__ import annotations

import importlib
import time
from unittest.mock import patch

import bpy
import meshes
import numpy as np
from bakes import by_the_extension
from enable_extension import PACKAGE
from report import Report
from timing import seconds, side_by_side

from demo.quiet import quiet

TEXTURE = {"target": "TEXTURE", "resolution": 512}


def main(report: Report, quick: bool) -> None:
    cases = [(meshes.suzanne, 16, {}), (meshes.suzanne, 64, {}), (meshes.suzanne, 256, {}), (meshes.coral, 64, {})]
    cases += [(meshes.coral, 64, TEXTURE)]
    if quick:
        cases = [(lambda: meshes.suzanne(2), 16, {}), (lambda: meshes.coral(4), 16, {**TEXTURE, "resolution": 64})]
    for make, samples, chosen in cases:
        obj = make()
        if chosen:
            meshes.unwrap(obj)
        by_the_extension(obj, samples, **chosen)  # leaves the scene for its rays
        taken = side_by_side(
            {
                "with": lambda obj=obj, samples=samples, chosen=chosen: _with(obj, samples, chosen),
                "without": lambda obj=obj, samples=samples, chosen=chosen: _without(obj, samples, chosen),
            },
            repeats=1 if quick else 7,
        )
        what = f"{obj.name.lower()}, {chosen.get('target', 'VERTEX').lower()} bake at {samples} samples"
        report.note(f"{what}: {taken['with']:.3f} s of processors with bent cones, {taken['without']:.3f} s without")
        report.add(f"{what}: what bent cones add", f"{100 * (taken['with'] / taken['without'] - 1):+.1f} %", "< 15 %")
    _project_worlds(report, quick)


def _with(obj: bpy.types.Object, samples: int, chosen: dict) -> float:
    started = time.process_time()
    by_the_extension(obj, samples, **chosen)
    return time.process_time() - started


def _without(obj: bpy.types.Object, samples: int, chosen: dict) -> float:
    visibility = importlib.import_module(f"{PACKAGE}.core.visibility")

    def deal(pattern, places, whole=visibility.deal):
        directions, weights = whole(pattern, places)
        return directions, np.ascontiguousarray(weights[:, :, :2])

    with patch.object(visibility, "deal", deal):
        return _with(obj, samples, chosen)


def _project_worlds(report: Report, quick: bool) -> None:
    """Seconds of `bpy.ops.multibounce_ao.project_world()`, the middle of three. The HDRI has 4096 x 2048 pixels."""
    meshes.empty_scene()
    for name, make in (("an HDRI", _picture), ("a sky", _sky), ("a procedural World", _noise)):
        world = bpy.data.worlds.new(name)
        world.use_nodes = True
        tree = world.node_tree
        colour = make(tree, 64 if quick else 2048)
        tree.links.new(colour, next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBackground").inputs["Color"])
        bpy.context.scene.world = world
        with quiet():
            taken = sorted(seconds(bpy.ops.multibounce_ao.project_world) for _ in range(1 if quick else 3))
        report.add(f"Project World, {name}", f"{taken[len(taken) // 2]:.2f} s")


def _picture(tree: bpy.types.NodeTree, height: int) -> bpy.types.NodeSocket:
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = bpy.data.images.new("HDRI", 2 * height, height, float_buffer=True)
    node.image.pixels.foreach_set(np.random.default_rng(0).random(8 * height * height, np.float32))
    return node.outputs["Color"]


def _sky(tree: bpy.types.NodeTree, _: int) -> bpy.types.NodeSocket:
    return tree.nodes.new("ShaderNodeTexSky").outputs["Color"]


def _noise(tree: bpy.types.NodeTree, _: int) -> bpy.types.NodeSocket:
    return tree.nodes.new("ShaderNodeTexNoise").outputs["Color"]
