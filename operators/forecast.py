# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake will do, told before it is begun, and what its artist should know first. Cheap enough to be drawn."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import bpy

from .high_to_low import pairs
from .overrides import Overrides
from .progress import duration_text
from .report import BakeError, ObjectReport, count_text
from .settings import BakeSettings
from .uv_checks import uv_check

# More of them would push the settings out of sight.
MOST_WARNINGS = 4
# With fewer vertices, as a floor of one face has, hardly a shadow falls on one.
FEW_VERTICES = 16


@dataclass
class Forecast:
    """``points`` and ``rays`` of a bake, its ``seconds`` where earlier bakes tell, how many objects have settings of
    their ``own``, and what to warn of, a line each."""

    objects: int = 0
    points: int = 0
    rays: int = 0
    seconds: float | None = None
    own: int = 0
    warnings: list[str] = field(default_factory=list)

    def text(self) -> str:
        """All in one line."""
        objects = "1 object" if self.objects == 1 else f"{self.objects} objects"
        parts = [objects, f"{count_text(self.points)} points", f"{count_text(self.rays)} rays"]
        if self.seconds is not None:
            parts.append("about " + duration_text(self.seconds) if self.seconds >= 1.0 else "under 1 s")
        if self.own:
            parts.append("with overrides" if self.own == self.objects else f"{self.own} with overrides")
        return ", ".join(parts)


def forecast(
    objects: list[bpy.types.Object],
    settings: BakeSettings,
    selected: Collection[bpy.types.Object] = (),
) -> Forecast:
    """Of a bake of mesh ``objects`` of the present view layer with ``settings``, and what else is ``selected``, as
    :func:`.bake_job.bake` takes them. Texels of UV maps that were not looked at yet count as if all were covered."""
    try:
        sources = pairs(objects, selected, settings)
    except BakeError as error:
        return Forecast(warnings=[str(error)])
    objects = objects if sources is None else list(sources)
    told, work, seen, overrides = Forecast(len(objects)), 0, set(), Overrides(bpy.context.view_layer)
    coarse = []
    for obj in objects:
        chosen = overrides.settings_for(obj, settings)
        told.own += chosen != settings
        points, warnings = (_texels if chosen.target == "TEXTURE" else _elements)(obj, chosen, seen)
        if chosen.occluders == "VISIBLE" and obj.hide_render and sources is None:
            warnings.append("is disabled in renders: it blocks no light on others")
        told.points += points
        rays = points * chosen.samples
        told.rays += rays
        work += work_of(points, chosen.samples, chosen.bounces)
        told.warnings += [f"'{obj.name}' {warning}" for warning in warnings]
        if chosen.target == "VERTEX":
            seen.add(obj.data)
            if 0 < len(obj.data.vertices) < FEW_VERTICES:
                coarse.append(obj.name)
    if coarse:
        others = f" and {len(coarse) - 1} more have" if len(coarse) > 1 else " has"
        told.warnings.append(
            f"'{coarse[0]}'{others} few vertices, and shadows between them are lost: "
            "subdivide, or set Target to Texture"
        )
    rate = _rates().get(settings.bounces)
    told.seconds = work / rate if rate else None
    return told


def work_of(points: int, samples: int, bounces: str) -> int:
    """What the time of one object's bake is in proportion to: its rays, and those that find its light."""
    from .tracer import light_rays  # here, with all of core: enabling the extension stays instant

    rays = points * samples
    return rays + (light_rays(rays) if points and bounces != "FITTED" else 0)


def remember(reports: list[ObjectReport], bounces: str) -> None:
    """Learn from a bake how fast this machine is; kept beside the preferences."""
    baked = [report for report in reports if report.rays]
    seconds = sum(report.seconds for report in baked)
    work = sum(work_of(report.points, report.samples, bounces) for report in baked)
    if seconds < 0.5:  # most of it was not tracing
        return
    _rates()[bounces] = work / seconds
    try:
        _file().parent.mkdir(parents=True, exist_ok=True)
        _file().write_text(json.dumps(_rates()), encoding="utf-8")
    except OSError:
        pass  # then it is learnt again


@cache
def _rates() -> dict[str, float]:
    """Work a second, by the kind of bounces."""
    try:
        return {str(kind): float(rate) for kind, rate in json.loads(_file().read_text(encoding="utf-8")).items()}
    except (OSError, ValueError, AttributeError):
        return {}


def _file() -> Path:
    return Path(bpy.utils.extension_path_user(__package__.rpartition(".")[0])) / "rates.json"


def _elements(obj: bpy.types.Object, settings: BakeSettings, seen: set) -> tuple[int, list[str]]:
    """Vertices, or face corners of a mesh that has flat faces or sharp edges."""
    mesh = obj.data
    if mesh in seen:
        return 0, ["shares its mesh with another: one bake serves both"]
    return len(mesh.vertices if mesh.normals_domain == "POINT" else mesh.loops), []


def _texels(obj: bpy.types.Object, settings: BakeSettings, seen: set) -> tuple[int, list[str]]:
    layers = obj.data.uv_layers
    uv_map = settings.uv_map or next((layer.name for layer in layers if layer.active_render), "")
    if uv_map not in layers:
        return 0, [f"has no UV map '{uv_map}'" if settings.uv_map else "has no UV map: unwrap it first"]
    found = uv_check(obj.data, uv_map, settings.use_udim)
    texels = int((1.0 if found is None else found.coverage) * settings.resolution**2)
    return texels, [f"overlaps itself in UV map '{uv_map}'"] if found is not None and found.overlap else []
