# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the ruin as its user would: choose settings, select objects, press the button."""

import time
from pathlib import Path

import bpy
from scene import Ruin

VERTEX_SAMPLES = 128
TEXTURE_SAMPLES = 64
TEXTURE_SIZE = 512


FIELD_SAMPLES = 256


def _select(objects: list[bpy.types.Object], active: bpy.types.Object) -> None:
    for scene_object in bpy.context.view_layer.objects:
        scene_object.select_set(scene_object in objects or scene_object == active)
    bpy.context.view_layer.objects.active = active


def bake_ruin(ruin: Ruin, maps_folder: str) -> float:
    """Bake some objects to vertices, some to textures in `maps_folder`, then the field of the prop, which is put down
    for it and darkens the ground; returns the seconds it took."""
    started = time.perf_counter()
    settings = bpy.context.scene.multibounce_ao
    settings.target = "VERTEX"
    settings.samples = VERTEX_SAMPLES
    _select(ruin.vertex_objects, ruin.vertex_objects[0])
    bpy.ops.multibounce_ao.bake()
    settings.target = "TEXTURE"
    settings.samples = TEXTURE_SAMPLES
    settings.resolution = TEXTURE_SIZE
    settings.output_directory = maps_folder
    _select(ruin.texture_objects, ruin.texture_objects[0])
    bpy.ops.multibounce_ao.bake()

    ruin.prop.hide_render = False
    settings.target, settings.samples = "VERTEX", VERTEX_SAMPLES
    _select([], ruin.prop)
    bpy.ops.multibounce_ao.bake()
    settings.samples = FIELD_SAMPLES
    bpy.ops.multibounce_ao.bake_field()
    _select(ruin.ground, ruin.prop)
    bpy.ops.multibounce_ao.apply_field()
    return time.perf_counter() - started


def _entry(scene_object: bpy.types.Object) -> dict:
    record = scene_object["multibounce_ao"].to_dict()
    if record["target"] == "VERTEX":
        outputs = ["Multibounce AO", "Bent Cone"]
    else:
        images = (bpy.data.images[f"{scene_object.name} {channel}"] for channel in ("Multibounce AO", "Bent Cone"))
        outputs = [bpy.path.abspath(image.filepath) for image in images]
    return {
        "name": scene_object.name,
        "target": record["target"],
        "points": int(record["points"]),
        "samples": int(record["samples"]),
        "rays": int(record["rays"]),
        "seconds": record["seconds"],
        "f0": record["f0"],
        "outputs": outputs,
        "warnings": list(record.get("warnings", [])),
        "error": None,
    }


def _field_entry(prop: bpy.types.Object, maps_folder: Path) -> dict:
    record = prop["multibounce_ao_field"].to_dict()
    files = sorted(str(path) for path in maps_folder.glob(f"{prop.name}_ao_field*"))
    return {
        "name": prop.name,
        "target": "FIELD",
        "resolution": record["resolution"],
        "points": int(record["rays"] / record["samples"]),
        "samples": record["samples"],
        "rays": int(record["rays"]),
        "seconds": record["seconds"],
        "a0": record["numbers"]["A0"],
        "p": record["numbers"]["p"],
        "outputs": [record["image"].name, *files],
        "warnings": list(record.get("warnings", [])),
        "error": None,
    }


def report(ruin: Ruin, seconds: float, scene_file: Path) -> dict:
    """What was baked, in the shape of the command line's JSON report."""
    objects = [*ruin.vertex_objects, *ruin.texture_objects, ruin.prop]
    return {
        "version": objects[0]["multibounce_ao"]["version"],
        "scene": str(scene_file),
        "seconds": round(seconds, 3),
        "objects": [
            *(_entry(scene_object) for scene_object in objects),
            _field_entry(ruin.prop, scene_file.parent / "maps"),
        ],
    }
