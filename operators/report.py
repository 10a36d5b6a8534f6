# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake tells: one entry an object, for the panel, the object's property and the JSON report."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

# Bytes from which on a bake tells what it takes.
MUCH_MEMORY = 1e9


class BakeError(Exception):
    """One object, or a whole bake, cannot be done; the message names it and says what to do."""


@dataclass
class ObjectReport:
    """The bake of one object; ``error`` is None where it was done. The JSON report lists these fields, but for
    ``memory``, the bytes that images take while they are baked, for ``file`` and ``scene``, where it is, where there is
    one of these alone, and for ``left``, where it was baked now: else that is True, and the bake is an earlier one."""

    name: str
    target: str
    points: int = 0
    samples: int = 0
    rays: int = 0
    seconds: float = 0.0
    f0: dict[str, float] | None = None
    outputs: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    error: str | None = None
    memory: float = 0.0
    file: str | None = None
    scene: str | None = None
    left: bool | None = None

    @property
    def note(self) -> str:
        """What memory it takes, where that is much."""
        return f"needs about {self.memory / 1e9:.1f} GB of memory" if self.memory >= MUCH_MEMORY else ""

    def tell_f0(self, f0: NDArray[np.float32], what: str, projected: bool = False) -> None:
        """Set :attr:`f0` from the F0 (k,) of those points that can be seen, and tell how many cannot; ``what`` they are
        called, and whether they are ``projected`` onto other surfaces. Raises BakeError where none of those meets any.
        """
        lost = self.points - len(f0)
        if projected and not len(f0):
            raise BakeError(
                "meets none of the surfaces that it should show: raise Cage Extrusion until it encloses them, and Max "
                "Ray Distance if that is set"
            )
        self.f0 = statistics(f0 if len(f0) else np.zeros(1, np.float32))
        if self.f0["max"] == 0.0:
            self.warnings.append(
                "Sees no sky at all: if it should, its faces may be turned inwards (Mesh > Normals > Recalculate "
                "Outside in Edit Mode), or it lies inside another object"
            )
        elif lost:
            how = "meet no surface that they should show" if projected else "lie inside of other surfaces"
            remedy = ". Raise Cage Extrusion, or Max Ray Distance if that is set" if projected else ""
            self.warnings.append(
                f"{count_text(lost)} of {count_text(self.points)} {what} {how}: they have the values of their "
                f"neighbors{remedy}"
            )

    def as_dict(self) -> dict:
        left_out = {"memory", *(name for name in ("file", "scene", "left") if getattr(self, name) is None)}
        return {name: value for name, value in asdict(self).items() if name not in left_out}


def statistics(f0: NDArray[np.float32]) -> dict[str, float]:
    """min, mean and max of F0 over the baked points."""
    return {"min": float(f0.min()), "mean": float(f0.mean(dtype=np.float64)), "max": float(f0.max())}


def count_text(count: float) -> str:
    """A count as people read it: 6,144 or 33.4 M."""
    return f"{count / 1e6:.1f} M" if count >= 1e6 else f"{count:,.0f}"


def bake_report(version: str, scene: str, seconds: float, objects: list[ObjectReport]) -> dict:
    """The report of the command line, ready for JSON."""
    return {
        "version": version,
        "scene": scene,
        "seconds": round(seconds, 3),
        "objects": [report.as_dict() for report in objects],
    }
