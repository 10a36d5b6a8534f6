# SPDX-License-Identifier: GPL-3.0-or-later
"""A fit of bounce curves from start to end, as a generator: the operator, the command line and the tests drive it.

object or height map -> simulation -> curves -> fit and plot -> the scene, files or data-blocks, the node group. All is
computed before anything is written, so closing the generator at any yield leaves the file as it was.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Generator
from dataclasses import asdict, dataclass, field
from functools import partial

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.bounce_curves import BounceCurves, BounceFit, bin_bounces, csv_text, fit_curves
from ..core.curve_plot import draw_curves
from ..core.simulation import Simulation
from ..core.workers import calling, in_thread, mapped
from ..shader_nodes.multibounce_fit import STORED_FIT, show_fit
from .curve_outputs import check_names, store_curves
from .fit_sources import FitSettings, simulate_image, simulate_object
from .images import output_folder
from .progress import Progress
from .report import BakeError
from .version import extension_version

# Part of the work that is the simulation; fitting and drawing take about a second.
SIMULATION_SHARE = 0.9


@dataclass
class FitReport:
    """What a fit was made from, and what it found; ``error`` is None where it was done. The JSON report lists these
    fields. ``fit`` has the coefficients and the rms residuals of :class:`core.bounce_curves.BounceFit`."""

    name: str
    source: str
    points: int = 0
    samples: int = 0
    bounces: int = 0
    bins: int = 0
    seconds: float = 0.0
    fit: dict[str, float] | None = None
    outputs: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    error: str | None = None

    @classmethod
    def of(cls, source: bpy.types.Object | bpy.types.Image, **values) -> FitReport:
        """The report of a fit on ``source``, with these ``values``."""
        return cls(source.name, "HEIGHT_MAP" if isinstance(source, bpy.types.Image) else "MESH", **values)

    def as_dict(self) -> dict:
        return asdict(self)


def fit_bounces(
    context: bpy.types.Context,
    source: bpy.types.Object | bpy.types.Image,
    settings: FitSettings,
    threads: int | None = None,
    *,
    selected: Collection[bpy.types.Object] = (),
) -> Generator[Progress, None, FitReport]:
    """Simulate and fit the bounces on ``source``, a mesh object of the context's view layer or a height map, and store
    the fit on the context's scene. Raises BakeError, which names ``source`` or the output folder.

    threads   default one a core; it changes no bit of the result
    selected  what else blocks and reflects light with the occluders 'SELECTED'
    """
    started = time.perf_counter()
    report = FitReport.of(source, samples=settings.samples)
    kind = "Object" if report.source == "MESH" else "Image"
    yield Progress(0.0, report.name)
    folder = output_folder(settings.output_directory)
    try:
        check_names(source, folder)
        simulation = yield from mapped(
            _simulate(context, source, settings, selected, report.warnings, threads),
            partial(_progress, name=report.name),
        )
        fitting = in_thread(calling(_fit, simulation, report.name))
        curves, fit, plot = yield from mapped(fitting, lambda _: Progress(SIMULATION_SHARE, report.name))
        yield Progress(1.0, report.name, ready=True)
        check_names(source, folder)
    except BakeError as error:
        raise BakeError(f"{kind} '{report.name}' {error}") from None
    except ReferenceError:
        raise BakeError(
            f"{kind} '{report.name}' was deleted while it was simulated: bring it back with undo, and fit again"
        ) from None

    report.points, report.bounces, report.bins = len(simulation.alpha), len(curves.mean) - 1, len(curves.ao)
    report.fit = asdict(fit)
    image, report.outputs = store_curves(source, csv_text(curves, fit), plot, folder)
    report.seconds = round(time.perf_counter() - started, 3)
    # Blender saves the image for this, where nothing else has it.
    context.scene[STORED_FIT] = report.fit | {
        "source": report.name,
        "points": report.points,
        "samples": report.samples,
        "bounces": report.bounces,
        "bins": report.bins,
        "seed": settings.seed,
        "seconds": report.seconds,
        "version": extension_version(),
        "image": image,
    }
    show_fit(context.scene)
    return report


def _simulate(
    context: bpy.types.Context,
    source: bpy.types.Object | bpy.types.Image,
    settings: FitSettings,
    selected: Collection[bpy.types.Object],
    warnings: list[str],
    threads: int | None,
) -> Generator[float, None, Simulation]:
    if isinstance(source, bpy.types.Image):
        return simulate_image(source, settings, warnings, threads)
    return simulate_object(context, source, settings, selected, warnings, threads)


def _fit(simulation: Simulation, name: str) -> tuple[BounceCurves, BounceFit, NDArray[np.float32]]:
    """The curves of a simulation, their fit, and the plot of both."""
    curves = bin_bounces(simulation)
    try:
        fit = fit_curves(curves)
    except ValueError as error:
        raise BakeError(f"cannot be fitted: {error}") from None
    return curves, fit, draw_curves(curves, fit, f"{name}: light of each bounce against AO")


def _progress(part: float, name: str) -> Progress:
    return Progress(SIMULATION_SHARE * part, name)
