# SPDX-License-Identifier: GPL-3.0-or-later
"""``blender --command multibounce_ao bake SCENE.blend ...``"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .bake_job import bake
from .command_files import UsageError, blend_files, keep, save_scene
from .command_jobs import bake_files
from .command_scene import (
    add_command,
    exit_code,
    given_settings,
    meshes_in_collections,
    named_objects,
    names_set,
    no_collection,
    no_object,
    open_scenes,
    progress_for,
)
from .command_tell import tell
from .occluder_reader import rendered_objects
from .progress import Progress, drive
from .report import BakeError, ObjectReport
from .settings import BakeSettings


def add_to(commands: argparse._SubParsersAction) -> None:
    """Add the command ``bake``."""
    command = add_command(
        commands,
        "bake",
        _bake,
        help="bake the meshes of a .blend, or of several",
        description=(
            "Bake the meshes of SCENE.blend that are enabled in renders, or those named by --object and --collection. "
            "Several files are baked side by side with --jobs."
        ),
        object_help="bake this object, or all meshes that a pattern such as 'Wall*' names; may be given again",
        failure="something could not be baked (the rest is done and kept)",
        several=True,
    )
    command.add_argument(
        "--collection",
        metavar="NAME",
        action="append",
        help="bake the meshes in this collection, or in all that a pattern names; may be given again",
    )
    command.add_argument(
        "--scene",
        dest="scenes",
        metavar="NAME",
        action="append",
        help="bake this scene of the .blend, or all that a pattern names, in place of the active one; may be given "
        "again",
    )
    command.add_argument(
        "--all-scenes", dest="scenes", action="append_const", const="*", help="bake all scenes of the .blend"
    )
    command.add_argument(
        "--resume",
        action="store_true",
        help="leave objects as they are that have their bake already, with the same settings and geometry",
    )
    command.add_argument(
        "--checkpoint",
        metavar="MINUTES",
        type=float,
        default=5.0,
        help="with --save, save whenever so much time has passed too, for --resume to go on from; 0: at the end alone",
    )
    command.add_argument(
        "--share",
        metavar="I/N",
        type=_share,
        default=(1, 1),
        help="bake the I-th of N shares of these objects alone, for N machines; the command merge unites them",
    )
    command.add_argument(
        "--jobs",
        metavar="N",
        type=_count,
        default=1,
        help="with several files, bake N of them at a time, each in a Blender of its own; default: 1",
    )
    command.add_argument(
        "--threads",
        metavar="N",
        type=_count,
        help="trace with so many threads, which jobs share; default: one a core. They change no bit of the result",
    )


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) >= 1):
        raise argparse.ArgumentTypeError(f"write a whole number from 1 on, not '{text}'")
    return int(text)


def _share(text: str) -> tuple[int, int]:
    index, _, count = text.partition("/")
    if not (index.isdecimal() and count.isdecimal() and 1 <= int(index) <= int(count)):
        raise argparse.ArgumentTypeError(f"'{text}' is no share: write it as I/N, such as 1/8 for the first of eight")
    return int(index), int(count)


def _bake(options: argparse.Namespace) -> int:
    files = blend_files(options.files)
    if len(files) > 1:
        return bake_files(files, options)
    (options.scene,) = files
    return _bake_file(options)


def _bake_file(options: argparse.Namespace) -> int:
    started = time.perf_counter()
    scenes = open_scenes(options, options.scenes)
    settings_of = {}
    for scene in scenes:
        with given_settings(scene, options):
            settings_of[scene] = BakeSettings.of(scene)
    objects_of, missing = _objects(scenes, options)
    checkpoints = _Checkpoints(options)
    reports = []
    for scene, objects in objects_of.items():
        checkpoints.begin()
        with _in_scene(scene):
            own = _bake_objects(objects, settings_of[scene], options, checkpoints)
        if options.scenes is not None:
            _tell_scene(own, scene, objects_of)
        reports += own
    target = settings_of[scenes[0]].target
    reports += [ObjectReport(name, target, error=message) for name, message in missing]

    kept = keep(options, reports, started)
    tell(reports, options, time.perf_counter() - started)
    return exit_code(kept, reports)


@contextmanager
def _in_scene(scene: bpy.types.Scene) -> Iterator[None]:
    """The context is that of ``scene``: the view layer that its window has, or else its first."""
    if scene == bpy.context.scene:
        yield
    else:
        with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            yield


def _bake_objects(
    objects: list[bpy.types.Object], settings: BakeSettings, options: argparse.Namespace, checkpoints: _Checkpoints
) -> list[ObjectReport]:
    """Bake ``objects`` of the context's scene as asked; a report for each."""
    show = progress_for(options)

    def step(progress: Progress) -> None:
        show(progress)
        checkpoints.step(progress)

    try:
        common = {"store_each": True, "resume": options.resume, "share": options.share, "fixed": names_set(options)}
        return drive(bake(bpy.context, objects, settings, options.threads, **common), step)
    except BakeError as error:
        return [ObjectReport(obj.name, settings.target, error=str(error)) for obj in objects]


def _tell_scene(
    reports: list[ObjectReport],
    scene: bpy.types.Scene,
    objects_of: dict[bpy.types.Scene, list[bpy.types.Object]],
) -> None:
    """Name the ``scene`` in its ``reports``, and warn of those that took the place of an earlier scene's bake."""
    earlier = {}
    for other in list(objects_of)[: list(objects_of).index(scene)]:
        for obj in objects_of[other]:
            earlier[obj] = earlier[obj.data] = other.name
    for report in reports:
        report.scene = scene.name
        obj = scene.objects.get(report.name)
        place = obj if obj is None or report.target == "TEXTURE" else obj.data
        if place in earlier and not report.error and not report.left:
            report.warnings.append(
                f"Is in scene '{earlier[place]}' too, whose bake this one replaced: give one of them a copy "
                "(Object > Relations > Make Single User > Object & Data)"
            )


class _Checkpoints:
    """Saves the .blend now and then between two objects, so that a night's work is not lost with its last minute."""

    def __init__(self, options: argparse.Namespace):
        self._every = 60.0 * options.checkpoint if options.save is not None and options.checkpoint > 0.0 else None
        self._name = options.save
        self._saved_at, self._saved_rays, self._object = time.perf_counter(), 0, None

    def begin(self) -> None:
        """The rays of another scene are counted anew."""
        self._saved_rays = 0

    def step(self, progress: Progress) -> None:
        """What came before the object at work is stored, and worth saving if rays were traced for it."""
        if self._every is None or progress.name == self._object:
            return
        self._object = progress.name
        if progress.rays > self._saved_rays and time.perf_counter() - self._saved_at > self._every:
            save_scene(self._name)
            self._saved_at, self._saved_rays = time.perf_counter(), progress.rays


def _objects(
    scenes: list[bpy.types.Scene], options: argparse.Namespace
) -> tuple[dict[bpy.types.Scene, list[bpy.types.Object]], list[tuple[str, str]]]:
    """The objects to bake by scene; and what was asked for that none of these has, with what to say. Raises
    UsageError where there is nothing to bake by itself."""
    objects_of, missing_of = {}, []
    for scene in scenes:
        with _in_scene(scene):
            objects, missing = _objects_here(options)
        missing_of.append(dict(missing))
        if objects:
            objects_of[scene] = objects
    if options.object is None and options.collection is None and not objects_of:
        names = ", ".join(f"'{scene.name}'" for scene in scenes)
        raise UsageError(
            f"scene{'s' if len(scenes) > 1 else ''} {names}: no mesh with faces is visible and enabled in renders"
        )
    first, *others = missing_of
    return objects_of, [(name, told) for name, told in first.items() if all(name in other for other in others)]


def _objects_here(options: argparse.Namespace) -> tuple[list[bpy.types.Object], list[tuple[str, str]]]:
    """Those of the context's view layer; and what was asked for that it does not have, with what to say."""
    view_layer = bpy.context.view_layer
    if options.object is None and options.collection is None:
        rendered = rendered_objects(view_layer)
        return [obj for obj in view_layer.objects if obj.type == "MESH" and obj.data.polygons and obj in rendered], []
    objects, unknown = named_objects(options.object or ())
    inside, unknown_collections = meshes_in_collections(options.collection or ())
    missing = [(name, no_object(name)) for name in unknown]
    missing += [(name, no_collection(name)) for name in unknown_collections]
    return list(dict.fromkeys([*objects, *inside])), missing
