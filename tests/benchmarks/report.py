# SPDX-License-Identifier: GPL-3.0-or-later
"""What benchmarks hand in: figures, each with what is asked of it, and curves to plot. A figure never fails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np


@dataclass(frozen=True)
class Figure:
    """``measured`` and ``asked`` as they are printed; ``asked`` is empty where nothing is."""

    what: str
    measured: str
    asked: str = ""


@dataclass(frozen=True)
class Plot:
    """Curves (label, x, y) on two logarithmic axes, stored as `benchmark_<name>.png`.

    line        y of a horizontal line, and what to write on it
    curves[0]   is the extension's, drawn strongest
    benchmark   which one it belongs to, filled in by the report
    """

    name: str
    title: str
    x_label: str
    y_label: str
    curves: Sequence[tuple[str, Sequence[float], Sequence[float]]]
    line: tuple[float, str] | None = None
    benchmark: str = ""


@dataclass
class Report:
    """The figures of each benchmark in turn, as (its name, docstring, figures), and all plots."""

    sections: list[tuple[str, str, list[Figure]]] = field(default_factory=list)
    plots: list[Plot] = field(default_factory=list)

    def begin(self, name: str, doc: str) -> None:
        self.sections.append((name, doc, []))
        print(f"\n== {name}: {doc.splitlines()[0]}", flush=True)

    def add(self, what: str, measured: str, asked: str = "") -> None:
        self.sections[-1][2].append(Figure(what, measured, asked))
        print(f"  {what}: {measured}" + (f"   (asked {asked})" if asked else ""), flush=True)

    def note(self, text: str) -> None:
        """Print what explains the figures but is none."""
        print(f"  {text}", flush=True)

    def plot(self, plot: Plot) -> None:
        self.plots.append(replace(plot, benchmark=self.sections[-1][0]))

    def table(self) -> str:
        """All figures in three columns, under the names of their benchmarks."""
        rows = [("", "measured", "asked")]
        for name, _, figures in self.sections:
            rows += [(name, "", ""), *((f"  {each.what}", each.measured, each.asked) for each in figures)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return "\n".join(f"{a:{widths[0]}}  {b:>{widths[1]}}  {c:>{widths[2]}}".rstrip() for a, b, c in rows)


def time_to(error: float, seconds: Sequence[float], errors: Sequence[float]) -> float:
    """Seconds until ``error``, on straight lines between the measurements in logarithms, or the nearest one's line.

    ``errors`` fall as ``seconds`` rise; (k,) each, k at least 2. Infinite where the last is still far above ``error``:
    the method may have a bias of its own, which no time takes away.
    """
    if errors[-1] > 1.5 * error:
        return float("inf")
    x, y = -np.log(errors), np.log(seconds)
    target = -np.log(error)
    left = int(np.clip(np.searchsorted(x, target) - 1, 0, len(x) - 2))
    slope = (y[left + 1] - y[left]) / (x[left + 1] - x[left])
    return float(np.exp(y[left] + slope * (target - x[left])))
