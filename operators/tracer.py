# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of a bake with its settings: what points see, and the light that bounces to them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.albedo import Albedo
from ..core.channels import bent_cone, fitted_bounces, measured_bounces, radiosity, to_object
from ..core.fill import straight_cones
from ..core.light_cache import LightCache, build_light_cache, cells_wanted
from ..core.rays import Obscurance, Occluders
from ..core.sample_points import SamplePoints, SurfacePoints
from ..core.sampling import hemisphere_pattern
from ..core.visibility import Visibility, Watch, trace_visibility
from ..core.workers import mapped
from .names import BENT_CONE, CHANNELS, MULTIBOUNCE_AO, RADIOSITY
from .settings import BakeSettings


@dataclass
class RayCount:
    """Rays that a whole bake has traced so far, from the points that it bakes."""

    rays: int = 0


# About what finding the light of a cell costs, and what a place of a point does besides its rays, in rays of the bake.
# Only what is told of the progress depends on it.
RAYS_OF_A_CELL, RAYS_OF_A_PLACE = 100, 2


def light_rays(rays: int) -> int:
    """What finding the light around a bake of so many ``rays`` costs, in such rays."""
    return RAYS_OF_A_CELL * cells_wanted(rays)


@dataclass(frozen=True)
class Tracer:
    """Traces against ``occluders`` as ``settings`` say, with so many ``threads`` (None: one a core); ``count`` goes on
    as it does, and ``albedo`` is of the occluders, for radiosity."""

    occluders: Occluders
    settings: BakeSettings
    threads: int | None
    count: RayCount
    albedo: Albedo | None = None

    def light_share(self, points: int, places: int = 1) -> float:
        """Part of the time of a bake of so many ``points``, each with so many ``places``, that :meth:`light` takes."""
        if self.settings.bounces == "FITTED":
            return 0.0
        light = light_rays(points * self.settings.samples)
        return light / (light + points * (self.settings.samples + RAYS_OF_A_PLACE * places))

    def light(
        self, probes: Callable[[], SurfacePoints], points: int, extent: float
    ) -> Generator[float, None, LightCache | None]:
        """The light around a bake of so many ``points`` that are like those ``probes`` makes; yields the fraction done.
        None where the bounces are fitted."""
        if self.settings.bounces == "FITTED":
            return None
        rays = points * self.settings.samples
        common = {"extent": extent, "albedo": self.albedo, **self._common()}
        return (yield from build_light_cache(self.occluders, probes(), rays, **common))

    def visibility(
        self, points: SamplePoints, extent: float, cache: LightCache | None, watch: Watch | None = None
    ) -> Generator[int, None, Visibility]:
        """What ``points`` see; yields the number of those done. ``cache`` is what :meth:`light` returned; ``watch`` is
        told what has been found so far."""
        pattern = hemisphere_pattern(self.settings.samples)
        before = self.count.rays

        def counted(done: int) -> int:
            self.count.rays = before + done * self.settings.samples
            return done

        common = {"extent": extent, "cache": cache, "watch": watch, **self._common()}
        return mapped(trace_visibility(self.occluders, points, pattern, **common), counted)

    def glance(self, points: SamplePoints, extent: float, samples: int) -> Generator[int, None, Visibility]:
        """As :meth:`visibility`, with so few ``samples``, without light, and not counted."""
        return trace_visibility(self.occluders, points, hemisphere_pattern(samples), extent=extent, **self._common())

    def channels(self, visibility: Visibility, world_to_object: NDArray) -> dict[str, NDArray[np.float32]]:
        """What is stored of n points, by name, each (n, 4). ``world_to_object`` as for
        :func:`core.channels.bent_cone`."""
        bounces = {"FITTED": fitted_bounces, "BAKED": measured_bounces, "RADIOSITY": radiosity}[self.settings.bounces]
        values = bounces(visibility), bent_cone(visibility, world_to_object)
        return dict(zip(CHANNELS[self.settings.bounces], values, strict=True))

    def fill_cones(
        self, channels: dict[str, NDArray[np.float32]], lost: NDArray, normals: NDArray, world_to_object: NDArray
    ) -> None:
        """In ``channels`` (n, 4), give points ``lost`` (k,), whose values are now those of others, bent directions
        along their own world ``normals`` (k, 3)."""
        f0 = channels[RADIOSITY][lost, 3] if RADIOSITY in channels else channels[MULTIBOUNCE_AO][lost, 0]
        cone = channels[BENT_CONE]
        cone[lost, :3] = to_object(straight_cones(f0, cone[lost, 3], normals), world_to_object)

    def _common(self) -> dict:
        chosen = self.settings
        obscurance = Obscurance(chosen.max_distance or np.inf, chosen.falloff, chosen.ignore_backfaces)
        return {"obscurance": obscurance, "seed": chosen.seed, "threads": self.threads}
