# SPDX-License-Identifier: GPL-3.0-or-later
"""The record of a bake on its object: the settings, the numbers, and where materials find what was baked."""

from __future__ import annotations

import os

import bpy

from .images import image_files, recorded_images
from .map_owner import blend_name, map_owner
from .material_nodes import GROUPS, BakedSource
from .names import AO_MAP, PROPERTY
from .object_materials import plug_object, plug_object_occlusion
from .report import ObjectReport
from .settings import BakeSettings
from .version import extension_version


def record_bake(
    obj: bpy.types.Object, settings: BakeSettings, report: ObjectReport, mark: bytes, uv_map: str | None = None
) -> None:
    """Leave the record of a stored bake on ``obj`` and plug the nodes in where wanted; their warnings go to ``report``.

    ``mark`` is the fingerprint of what the bake was made from, empty where it is that of another object; ``uv_map`` of
    a texture bake. The images are in the record already; those of an earlier bake stay in it, so that
    they are replaced and cleared with this object.
    """
    record = settings.as_property() | {
        "version": extension_version(),
        "points": report.points,
        "rays": float(report.rays),  # ID properties have 32-bit integers
        "seconds": report.seconds,
        "memory": report.note,
        "f0": report.f0,
        "images": recorded_images(obj),
        "outputs": report.outputs,
        "fingerprint": mark.hex(),
    }
    if uv_map is not None:
        record["uv_map"], record["blend"] = uv_map, blend_name()
    obj[PROPERTY] = record
    report.warnings += plug_recorded(obj)
    obj[PROPERTY]["warnings"] = report.warnings


def plug_recorded(obj: bpy.types.Object) -> list[str]:
    """Plug the nodes in that the record of ``obj`` wants; returns warnings."""
    record, warnings = obj[PROPERTY], []
    if record["use_material_nodes"]:
        warnings += plug_object(obj, record["bounces"], baked_source(obj))
    has_map = record["target"] == "TEXTURE" and record["use_gltf_occlusion"]
    warnings += plug_object_occlusion(obj, recorded_images(obj)[AO_MAP] if has_map else None, record["uv_map"])
    return warnings


def baked_source(obj: bpy.types.Object, group: str | None = None) -> BakedSource | None:
    """Where materials find what the bake of ``obj`` left for a ``group`` of :data:`.material_nodes.GROUPS`, by default
    that of its bounces; None where it has nothing for it."""
    record = obj.get(PROPERTY)
    if obj.type != "MESH" or record is None or "target" not in record:
        return None
    channels = {channel for channel, _ in GROUPS[group or record["bounces"]][1].values()}
    if record["target"] == "VERTEX":
        return BakedSource() if channels <= set(obj.data.attributes.keys()) else None
    images = recorded_images(obj)
    return BakedSource(images, record["uv_map"]) if channels <= images.keys() else None


def curve_group(obj: bpy.types.Object) -> str:
    """Which of :data:`.material_nodes.GROUPS` shows the F0 of the last bake of ``obj`` by the curve."""
    return "CURVE_OF_RADIOSITY" if obj.get(PROPERTY, {}).get("bounces") == "RADIOSITY" else "CURVE"


def baked_fingerprint(obj: bpy.types.Object) -> bytes:
    """Of what the last bake of ``obj`` was made from; empty where there is none, or not all that it left: no maps that
    another .blend wrote over."""
    record = obj.get(PROPERTY, {})
    if not record.get("fingerprint") or baked_source(obj) is None:
        return b""
    files = [file for image in recorded_images(obj).values() if not image.packed_file for file in image_files(image)]
    # Not the open .blend's name: it may have been saved under another since.
    are_own = all(map(os.path.isfile, files)) and all(
        map_owner(file)[0] == record.get("blend", "") for file in files if file.endswith(".exr")
    )
    return bytes.fromhex(record["fingerprint"]) if are_own else b""


def tell_of_record(obj: bpy.types.Object, report: ObjectReport) -> None:
    """Fill the ``report`` of an object that has its bake already."""
    record = obj[PROPERTY]
    report.points, report.f0, report.outputs = record["points"], record["f0"].to_dict(), list(record["outputs"])
    report.warnings, report.left = list(record["warnings"]), True
