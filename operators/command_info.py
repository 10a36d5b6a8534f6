# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao info SCENE.blend ...``"""

from __future__ import annotations

import argparse
import sys

import bpy

from .bake_record import baked_source
from .command_files import write_report
from .command_scene import (
    DONE,
    NOT_ALL_DONE,
    add_command,
    named_objects,
    no_object,
    open_scene,
    print_table,
    scenes_of_objects,
)
from .field_record import FIELD, has_field
from .images import recorded_images
from .names import PROPERTY
from .report import count_text
from .version import extension_version


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``info``."""
    add_command(
        commands,
        "info",
        _info,
        help="tell what is baked in a .blend",
        description="List what bakes left on the objects of all scenes of SCENE.blend, on stdout and with --report as "
        "JSON.",
        object_help="tell of this object, or of all meshes that a pattern such as 'Wall*' names; may be given again",
        failure="an object that was asked for is not there, or has lost its bake",
        changes=False,
    )


def _info(options: argparse.Namespace) -> int:
    open_scene(options)
    scenes_of = scenes_of_objects()
    if options.object is None:
        objects, missing = [obj for obj in scenes_of if PROPERTY in obj or has_field(obj)], []
    else:
        objects, missing = named_objects(options.object, scenes_of)
    several = len(bpy.data.scenes) > 1
    entries = [_entry(obj) | ({"scene": scene.name} if several else {}) for obj in objects for scene in scenes_of[obj]]
    missing = [{"name": name, "bake": None, "field": None, "error": no_object(name, scenes_of)} for name in missing]
    written = True
    if options.report is not None:
        written = write_report(
            options.report, {"version": extension_version(), "scene": str(options.scene), "objects": entries + missing}
        )
    errors = list(dict.fromkeys(entry["error"] for entry in entries + missing if entry["error"]))
    for error in errors:
        print(f"Error: {error}", file=sys.stderr)
    if not options.quiet:
        head = ("object", "target", "bounces", "samples", "points", "mean AO", "field")
        rows = [_row(entry) for entry in entries]
        if several:
            head, rows = ("scene", *head), [(entry["scene"], *row) for entry, row in zip(entries, rows, strict=True)]
        print_table(head, rows, sys.stdout, names=1 + several)
    return DONE if written and not errors else NOT_ALL_DONE


def _entry(obj: bpy.types.Object) -> dict:
    """What ``obj`` has: its bake and its field, None where it has none, and what is wrong with them."""
    record, error, bake = obj.get(PROPERTY), None, None
    if record is not None and "f0" in record:
        bake = {name: _plain(record[name]) for name in record.keys() if name not in {"images", "fingerprint"}}  # noqa: SIM118
        bake["images"] = {channel: image.name for channel, image in recorded_images(obj).items()}
        if baked_source(obj) is None:
            error = f"Object '{obj.name}' has lost what its bake left: bake it again"
    field = None
    if has_field(obj):
        field = {name: _plain(obj[FIELD][name]) for name in ("resolution", "samples", "seed", "seconds", "version")}
    return {"name": obj.name, "bake": bake, "field": field, "error": error}


def _plain(value: object) -> object:
    """An ID property as JSON has it."""
    for convert in ("to_dict", "to_list"):
        if hasattr(value, convert):
            return getattr(value, convert)()
    return value


def _row(entry: dict) -> tuple[str, ...]:
    bake, field = entry["bake"], entry["field"]
    size = f"{field['resolution']} x {field['resolution']}" if field else "-"
    if bake is None:
        return entry["name"], "-", "-", "-", "-", "-", size
    points, ao = count_text(bake["points"]), f"{bake['f0']['mean']:.4f}"
    return entry["name"], bake["target"], bake["bounces"], str(bake["samples"]), points, ao, size
