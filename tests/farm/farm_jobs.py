# SPDX-License-Identifier: GPL-3.0-or-later
"""The job templates of farm/, run by the Open Job Description runner, in this Blender: `make test-farm`."""

import json
import os
import subprocess
from pathlib import Path

import bpy
import numpy as np
import pytest

FARM = Path(__file__).resolve().parents[2] / "farm"
OPENJD = os.environ["OPENJD"]


def openjd(verb, template, *arguments, **parameters):
    """What the runner prints; ``parameters`` of the job."""
    command = [OPENJD, verb, str(FARM / template / "template.yaml"), *arguments]
    if parameters:
        command += ["--job-param", json.dumps(parameters)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def blender(*arguments):
    command = [bpy.app.binary_path, "--command", "multibounce_ao", *map(str, arguments), "--quiet"]
    subprocess.run(command, check=True)


def save_scene(path, target):
    """Five meshes that see each other over a ground plane, two of them the same; all are baked to ``target``."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    for index in range(4):
        bpy.ops.mesh.primitive_monkey_add(location=(1.7 * index, 0, 0.1 * index), rotation=(0, 0, index))
    twin = bpy.context.object.copy()
    twin.location.y = 2.0
    bpy.context.collection.objects.link(twin)
    settings = bpy.context.scene.multibounce_ao
    settings.samples, settings.resolution, settings.target, settings.use_ground_plane = 32, 64, target, True
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def baked(path):
    """All that bakes left in the .blend ``path``: bytes by name, the records without the times."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    found = {}
    for obj in bpy.data.objects:
        record = obj["multibounce_ao"].to_dict() | {"seconds": 0.0}
        found[obj.name] = repr(record).encode()
        found[obj.name, "materials"] = repr([slot.material.name for slot in obj.material_slots]).encode()
        for attribute in obj.data.color_attributes:
            values = np.empty((len(attribute.data), 4), np.float32)
            attribute.data.foreach_get("color", values.ravel())
            found[obj.name, attribute.name] = values.tobytes()
    for material in bpy.data.materials:
        links = sorted((link.from_node.name, link.to_node.name) for link in material.node_tree.links)
        found[material.name, "links"] = repr(links).encode()
    for image in bpy.data.images:
        values = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(values)
        found[image.name, "pixels"] = values.tobytes()
    return found


@pytest.mark.parametrize("template", ["bake_objects", "bake_files"])
def test_the_template_is_valid(template):
    assert "passes validation checks" in openjd("check", template)


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_objects_of_one_file(extension, tmp_path, target):
    scene, whole = save_scene(tmp_path / "a scene.blend", target), tmp_path / "whole.blend"
    blender("bake", scene, "--save", whole)
    parameters = {"Scene": str(scene), "Parts": str(tmp_path / "parts"), "Shares": 3, "Blender": bpy.app.binary_path}
    (tmp_path / "parts").mkdir()
    assert "Total tasks: 4" in openjd("summary", "bake_objects", **parameters)
    told = openjd("run", "bake_objects", "--step", "Merge", "--run-dependencies", **parameters)
    print(told)
    parts = sorted(path.name for path in (tmp_path / "parts").glob("*.blend"))
    assert parts == [f"share_{index}_of_3.blend" for index in (1, 2, 3)]
    single, merged = baked(whole), baked(scene)
    size = sum(map(len, single.values()))
    print(f"{target}: {len(single)} results of {len(parts)} parts, {size:,} bytes, compared with one single bake")
    assert single == merged
    assert size > 1e5


def test_a_list_of_files(extension, tmp_path):
    scenes = [save_scene(tmp_path / f"scene {index}.blend", "VERTEX") for index in range(2)]
    whole = tmp_path / "whole.blend"
    blender("bake", scenes[0], "--save", whole)
    parameters = {"Scenes": [str(path) for path in scenes], "Blender": bpy.app.binary_path}
    print(openjd("run", "bake_files", **parameters))
    single = baked(whole)
    assert all(baked(scene) == single for scene in scenes)
    assert all(json.loads(Path(f"{scene}.json").read_text())["objects"] for scene in scenes)
