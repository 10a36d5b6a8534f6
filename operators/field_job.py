# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake of an AO field from start to end, as a generator: the operator, the command line and the tests drive it.

object -> triangles in its own space -> core.field_bake -> atlas, node group and record, and files. All is computed
before anything is written, so closing the generator at any yield leaves the file as it was.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Generator
from dataclasses import asdict, dataclass, field
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.ao_field import AOField
from ..core.field_bake import bake_field
from ..core.rays import Occluders
from ..core.workers import in_thread, mapped
from ..shader_nodes.ao_field import field_numbers
from .field_outputs import name_images, store_images, write_field
from .field_record import proportions_of, record_field
from .images import output_folder
from .mesh_reader import evaluated_mesh, linear_inverse
from .object_checks import check_evaluated, check_object
from .occluder_reader import read_occluders
from .overrides import Overrides
from .progress import Progress
from .report import BakeError
from .version import extension_version

# Distances from the object at which each direction of its field is measured.
RADII = 8


@dataclass(frozen=True)
class FieldSettings:
    """A copy of those settings that a field reads, at the moment its bake starts."""

    samples: int
    seed: int
    field_resolution: int
    use_field_volume: bool
    output_directory: str

    @classmethod
    def of(cls, scene: bpy.types.Scene) -> FieldSettings:
        return cls(**{name: getattr(scene.multibounce_ao, name) for name in cls.__dataclass_fields__})


@dataclass
class FieldReport:
    """The bake of one field; ``error`` is None where it was done. The JSON report lists these fields.

    resolution  texels along a side of the cubemaps' faces
    points      places around the object that the field is fitted to, texels times distances
    rays        ``samples`` for each of them; what else was traced, within the hull, does not count
    a0, p       occlusion at the centre, and how fast the hull's turns to it
    """

    name: str
    target: str = "FIELD"
    resolution: int = 0
    points: int = 0
    samples: int = 0
    rays: int = 0
    seconds: float = 0.0
    a0: float | None = None
    p: float | None = None
    outputs: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    error: str | None = None

    def as_dict(self) -> dict:
        return asdict(self)


def bake_object_field(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    settings: FieldSettings,
    threads: int | None = None,
    fixed: Collection[str] = (),
) -> Generator[Progress, None, FieldReport]:
    """Bake the AO field of ``obj``, a mesh object of the context's view layer, with ``settings``, and what it and its
    collections override of them; store it. Raises BakeError, which names the object or the output folder.

    threads  default one a core; it changes no bit of the result
    fixed    names of settings that nothing overrides
    """
    started = time.perf_counter()
    settings = Overrides(context.view_layer, fixed).settings_for(obj, settings)
    report = FieldReport(obj.name, resolution=settings.field_resolution, samples=settings.samples)
    yield Progress(0.0, obj.name)
    folder = output_folder(settings.output_directory)
    try:
        vertices, triangles, proportions = _read(context, obj, report.warnings)
        work = _trace(vertices, triangles, settings, threads)
        baked = yield from mapped(in_thread(work), partial(Progress, name=report.name))
        yield Progress(1.0, report.name, ready=True)
        check_object(obj, context.view_layer)
    except BakeError as error:
        raise BakeError(f"Object '{report.name}' {error}") from None
    except ValueError as error:
        raise BakeError(f"Object '{report.name}' cannot be baked: {error}") from None
    except ReferenceError:
        raise BakeError(
            f"Object '{report.name}' was deleted while the bake was running: bring it back with undo, and bake again"
        ) from None
    report.points = (6 * (baked.resolution - 1) ** 2 + 2) * RADII  # faces share the texels on their edges
    report.rays = report.points * settings.samples
    report.a0, report.p = float(baked.a0), float(baked.p)
    try:
        files = write_field(obj, baked, folder) if folder else []
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise BakeError(
            f"Object '{obj.name}' cannot be stored in '{folder}' ({reason}): choose another output folder"
        ) from None
    _store(obj, baked, settings, proportions, report, files, started)
    return report


def _trace(
    vertices: NDArray, triangles: NDArray, settings: FieldSettings, threads: int | None
) -> Generator[float, None, AOField]:
    yield 0.0
    occluders = Occluders(vertices, triangles)
    return (
        yield from bake_field(
            occluders,
            vertices,
            triangles,
            resolution=settings.field_resolution,
            samples=settings.samples,
            radii=RADII,
            volume=settings.use_field_volume,
            seed=settings.seed,
            threads=threads,
        )
    )


def _read(
    context: bpy.types.Context, obj: bpy.types.Object, warnings: list[str]
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """Triangles of ``obj`` and of the instances it makes, in its own space times its proportions, and these."""
    check_object(obj, context.view_layer)
    depsgraph = context.evaluated_depsgraph_get()
    evaluated = obj.evaluated_get(depsgraph)
    matrix = np.array(evaluated.matrix_world, np.float64)
    if not np.isfinite(matrix).all():
        raise BakeError("has a transform that is not finite: reset its location, rotation and scale")
    inverse = linear_inverse(matrix)
    proportions = proportions_of(matrix)
    if (proportions != 1.0).any():
        warnings.append(
            "Is scaled unevenly: its field holds for these proportions, and is to be baked again when they change; "
            "with the scale applied (Object > Apply > Scale) it needs no more than even scales"
        )
    vertices, triangles, found = read_occluders(depsgraph, {obj})
    warnings += found
    if not len(triangles):
        with evaluated_mesh(evaluated) as mesh:
            check_evaluated(mesh, matrix)
        raise BakeError("has no faces left after its modifiers: change or turn off the one that removes them")
    return ((vertices - matrix[:3, 3]) @ inverse.T) * proportions, triangles, proportions


def _store(
    obj: bpy.types.Object,
    baked: AOField,
    settings: FieldSettings,
    proportions: NDArray,
    report: FieldReport,
    files: list[str],
    started: float,
) -> None:
    images = store_images(baked)
    report.seconds = round(time.perf_counter() - started, 3)
    record = {
        **images,
        "numbers": field_numbers(baked),
        "centre": [float(value) for value in baked.centre],
        "proportions": [float(value) for value in proportions],
        "resolution": baked.resolution,
        "radius": float(baked.radius),
        "samples": report.samples,
        "rays": float(report.rays),  # ID properties have 32-bit integers
        "seed": settings.seed,
        "seconds": report.seconds,
        "warnings": report.warnings,
        "version": extension_version(),
    }
    record_field(obj, record)
    report.outputs = [*name_images(obj, images), *files]
