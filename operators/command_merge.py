# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao merge SCENE.blend PART.blend ...``"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

import bpy
import numpy as np

from .bake_record import baked_source, plug_recorded
from .command_files import blend_files, keep
from .command_scene import add_command, exit_code, named_objects, no_object, open_scene, print_table, scenes_of_objects
from .images import check_image_names, keep_image, recorded_images
from .mesh_reader import read, read_corner_vertices, read_positions
from .names import CHANNELS, PROPERTY
from .report import BakeError
from .vertex_target import check_attribute_names, write_attribute


@dataclass
class MergeReport:
    """The bake of one object of a ``part``; ``error`` is None where it was taken over. The JSON report lists these
    fields."""

    name: str
    part: str = ""
    target: str = ""
    warnings: list[str] = field(default_factory=list)
    error: str | None = None

    def as_dict(self) -> dict:
        return asdict(self)


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``merge``."""
    command = add_command(
        commands,
        "merge",
        _merge,
        help="bring bakes of copies of a .blend together in it",
        description=(
            "Take over into SCENE.blend what bake left in the PARTs, copies of it that bake --share --save wrote: "
            "attributes, images, records, and the nodes in the materials. Of a PART all bakes are taken that "
            "SCENE.blend does not have already."
        ),
        object_help="take this object's bake alone, or those that a pattern such as 'Wall*' names; may be given again",
        failure="a bake could not be taken over (the rest is and is kept) or the .blend not saved",
        bakes=False,
    )
    command.add_argument(
        "parts",
        metavar="PART.blend",
        nargs="+",
        help="a file, or all that a pattern such as 'part_*.blend' or '*/part.blend' names",
    )


def _merge(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scene = options.scene.resolve()
    parts = [part for part in map(Path.resolve, blend_files(options.parts)) if part != scene]
    open_scene(options)
    everything = list(scenes_of_objects())
    objects, missing = (everything, []) if options.object is None else named_objects(options.object, everything)
    targets = _Targets(objects, are_all=options.object is None)
    reports = [MergeReport(name, error=no_object(name, everything)) for name in missing]
    for part in parts:
        reports += targets.take_part(part)
    # With the parts closed again, and in the order of a bake: nodes and materials come out as one bake makes them.
    for obj in objects:
        if obj.name in targets.taken:
            warnings = targets.taken[obj.name].warnings
            warnings += dict.fromkeys([*obj[PROPERTY]["warnings"], *plug_recorded(obj)])
            obj[PROPERTY]["warnings"] = warnings

    kept = keep(options, reports, started)
    _tell(reports, options, targets)
    return exit_code(kept, reports)


class _Targets:
    """The objects that bakes are taken to. ``taken`` has the reports of those that got theirs, ``there_already`` the
    names of those that had them."""

    def __init__(self, objects: list[bpy.types.Object], are_all: bool):
        """``are_all``: a bake of an object that is not among them is an error."""
        self._objects = {obj.name: obj for obj in objects}
        self._are_all = are_all
        self._before = {obj.name: _record(obj) for obj in objects}
        self.taken: dict[str, MergeReport] = {}
        self.there_already: set[str] = set()

    def take_part(self, part: Path) -> list[MergeReport]:
        """Store what was baked in ``part``: all but the nodes; a report each."""
        reports = []
        try:
            with _linked_objects(part) as sources:
                for source in sources:
                    if _is_baked(source) and self._is_wanted(source):
                        reports.append(MergeReport(source.name, part.name, source[PROPERTY]["target"]))
                        self._take(source, reports[-1])
        except OSError as error:
            reports.append(MergeReport("", part.name, error=f"'{part}' cannot be read: {str(error).strip()}"))
        return reports

    def _is_wanted(self, source: bpy.types.Object) -> bool:
        if source.name not in self._objects:
            return self._are_all
        before = self._before[source.name]
        if before and before == _record(source):  # the part has it from this file, or this file from the part
            self.there_already.add(source.name)
            return False
        return True

    def _take(self, source: bpy.types.Object, report: MergeReport) -> None:
        name = source.name
        try:
            if name not in self._objects:
                raise BakeError(f"is baked in '{report.part}': {no_object(name, self._objects.values())}")
            if name in self.taken:
                first = self.taken[name].part
                raise BakeError(f"was baked in both '{first}' and '{report.part}': leave one of them out")
            _take(self._objects[name], source, report.part)
            self.taken[name] = report
        except BakeError as error:
            report.error = f"Object '{name}' {error}"


@contextmanager
def _linked_objects(part: Path) -> Iterator[list[bpy.types.Object]]:
    """The objects of the .blend ``part``, only to be read, and gone afterwards. Raises OSError."""
    before = set(bpy.data.libraries)
    try:
        with bpy.data.libraries.load(str(part), link=True) as (there, here):
            here.objects = there.objects
        yield [obj for obj in here.objects if obj is not None]
    finally:
        bpy.data.batch_remove(set(bpy.data.libraries) - before)


def _is_baked(obj: bpy.types.Object) -> bool:
    return obj.type == "MESH" and "f0" in obj.get(PROPERTY, {})


def _record(obj: bpy.types.Object) -> dict:
    """What tells the bake of ``obj`` from another; empty where it has none, or lost what it left."""
    if not _is_baked(obj) or baked_source(obj) is None:
        return {}
    return {name: value for name, value in obj[PROPERTY].to_dict().items() if name != "images"}


def _take(obj: bpy.types.Object, source: bpy.types.Object, part: str) -> None:
    """Store the bake of ``source``, an object of ``part``, on ``obj``: all but the nodes. Raises BakeError."""
    record = _record(source)
    if not record:
        raise BakeError(f"has lost what its bake left in '{part}': bake it again")
    if obj.type != "MESH" or obj.library is not None or obj.data.library is not None:
        raise BakeError(f"is no local mesh as in '{part}': bake it again from this file")
    if not _same_surface(obj, source, record.get("uv_map")):
        raise BakeError(f"has another mesh, UV map or place than in '{part}': bake it again from this file")
    if record["target"] == "VERTEX":
        check_attribute_names(obj, record["bounces"])
        for name in CHANNELS[record["bounces"]]:
            attribute = source.data.attributes[name]
            write_attribute(obj.data, name, attribute.domain, read(attribute.data, "color", 4, np.float32))
    else:
        images = recorded_images(source)
        check_image_names(obj, images)
        for channel, image in images.items():
            keep_image(obj, channel, image.copy())
    obj[PROPERTY] = source[PROPERTY].to_dict() | {"images": recorded_images(obj)}


def _same_surface(obj: bpy.types.Object, other: bpy.types.Object, uv_map: str | None) -> bool:
    """Whether the bake of ``other`` is that of ``obj``, as far as their own data tells."""
    if obj.matrix_basis != other.matrix_basis:  # what a linked object has without a scene
        return False
    meshes = obj.data, other.data
    if not all(np.array_equal(*map(part_of, meshes)) for part_of in (read_corner_vertices, read_positions)):
        return False
    layers = [mesh.uv_layers.get(uv_map or "") for mesh in meshes]
    uvs = [None if layer is None else read(layer.uv, "vector", 2, np.float32) for layer in layers]
    return np.array_equal(*uvs)


def _tell(reports: list[MergeReport], options: argparse.Namespace, targets: _Targets) -> None:
    """Print on stderr what cannot be missed, then all in a table."""
    for report in reports:
        if report.error:
            print(f"Error: {report.error}", file=sys.stderr)
    if options.quiet:
        return
    rows = [(report.name, report.part, "failed" if report.error else report.target) for report in reports]
    if rows:
        print_table(("object", "from", "target"), rows, sys.stderr)
    there = len(targets.there_already - targets.taken.keys())
    already = f"{there} {'is' if there == 1 else 'are'} there already, " if there else ""
    failed = sum(report.error is not None for report in reports)
    print(f"{len(reports) - failed} taken over, {already}{failed} failed", file=sys.stderr)
    if targets.taken and options.save is None:
        print("The .blend was not saved: add --save to keep the bakes in it", file=sys.stderr)
