# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/benchmarks.md from a report, with its plots where matplotlib is installed."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import platform
from pathlib import Path

import bpy
from report import Plot, Report

# Paul Tol's "bright" scheme, which colour-blind readers can tell apart. The extension comes first, strongest.
COLOURS = ("#EE6677", "#4477AA", "#228833", "#CCBB44", "#66CCEE", "#AA3377")
MARKERS = "osD^vP"
PACKAGES = ("embreex", "numpy", "mitsuba", "open3d", "pymeshlab", "libigl")


def write_docs(report: Report, folder: Path) -> None:
    """Write `benchmarks.md` in ``folder``, and `pictures/benchmark_*.png` beside it."""
    pictures = _draw(report.plots, folder / "pictures")
    lines = [
        "# Benchmarks",
        "",
        f"Written by `make bench ARGS=--update-docs`{_added()}, on {_machine()}.",
        "",
        "What is compared was measured in turns in one run; times are medians. *Asked*: what the project aims at.",
        "",
    ]
    for name, doc, figures in report.sections:
        title, *rest = doc.strip().split("\n\n")
        lines += [f"## {name.replace('_', ' ').capitalize()}", "", title.replace("\n", " "), ""]
        lines += ["\n\n".join(rest), ""] if rest else []
        lines += ["| | measured | asked |", "|---|--:|--:|"]
        lines += [f"| {each.what} | {each.measured} | {each.asked} |" for each in figures]
        lines.append("")
        lines += [line for plot in pictures if plot.benchmark == name for line in (_image(plot), "")]
    (folder / "benchmarks.md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    print(f"wrote {folder / 'benchmarks.md'}")


def _image(plot: Plot) -> str:
    return f"![{plot.y_label} against {plot.x_label}: {plot.title}](pictures/benchmark_{plot.name}.png)"


def _added() -> str:
    stems = [Path(path).stem for path in os.environ.get("BENCH_MESHES", "").split()]
    return f" with BENCH_MESHES naming {' and '.join(stems)}" if stems else ""


def _machine() -> str:
    """What the figures depend on: processor, cores, versions."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            line.split(":")[1].strip() for line in cpuinfo.read_text().splitlines() if line.startswith("model name")
        ]
        model = names[0] if names else model
    versions = [f"Blender {bpy.app.version_string}"]
    for package in PACKAGES:
        if importlib.util.find_spec({"libigl": "igl"}.get(package, package)):
            versions.append(f"{package} {importlib.metadata.version(package)}")
    return f"{os.cpu_count()} cores of {model}, {platform.system()}, {', '.join(versions)}"


def _draw(plots: list[Plot], folder: Path) -> list[Plot]:
    """Store ``plots`` and return them; none where matplotlib is missing."""
    try:
        import matplotlib
    except ImportError:
        print("no plots: matplotlib is not installed (tools/bench_requirements.txt)")
        return []
    matplotlib.use("Agg")
    for plot in plots:
        _draw_one(plot, folder / f"benchmark_{plot.name}.png")
    return plots


def _plain(value: float, _position: int) -> str:
    return f"{value:g}" if value < 1e4 else f"{value:,.0f}"


def _plain_if_round(value: float, position: int) -> str:
    return _plain(value, position) if f"{value:e}"[0] in "235" else ""


def _draw_one(plot: Plot, path: Path) -> None:
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FuncFormatter, NullFormatter

    figure, axes = plt.subplots(figsize=(7.2, 4.5), dpi=140, layout="constrained")
    for index, (label, x, y) in enumerate(plot.curves):
        axes.loglog(
            x, y, label=label, color=COLOURS[index % len(COLOURS)], marker=MARKERS[index % len(MARKERS)],
            markersize=6 if index == 0 else 4.5, linewidth=2.6 if index == 0 else 1.5, zorder=3 if index == 0 else 2,
        )  # fmt: skip
    if plot.line:
        axes.axhline(plot.line[0], color="0.45", linewidth=1, linestyle="--", zorder=1)
        axes.annotate(
            plot.line[1], (1, plot.line[0]), xycoords=("axes fraction", "data"), xytext=(-4, 3),
            textcoords="offset points", ha="right", color="0.35", fontsize=9,
        )  # fmt: skip
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        axis.set_major_formatter(FuncFormatter(_plain))
        # Between powers of ten only where there are few of them.
        axis.set_minor_formatter(FuncFormatter(_plain_if_round) if high < 30.0 * low else NullFormatter())
    axes.grid(which="major", color="0.85", linewidth=0.8)
    axes.grid(which="minor", color="0.93", linewidth=0.5)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(plot.title, loc="left", fontsize=11)
    axes.set_xlabel(plot.x_label)
    axes.set_ylabel(plot.y_label)
    axes.legend(frameon=False)
    figure.savefig(path)
    plt.close(figure)
