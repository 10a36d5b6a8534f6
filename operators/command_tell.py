# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``bake`` prints on stderr when it is done."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence

from .command_scene import print_table
from .report import ObjectReport, count_text


def tell(
    reports: list[ObjectReport],
    options: argparse.Namespace,
    seconds: float,
    files: Mapping[str, str | None] | None = None,
) -> None:
    """Print what cannot be missed, then all in a table. ``files``, where there are several: what is wrong with each."""
    broken = {file: error for file, error in (files or {}).items() if error}
    for file, error in broken.items():
        print(f"Error: '{file}' {error}", file=sys.stderr)
    for report in reports:
        if report.error:
            where = f"'{report.file}': " if files else ""
            print(f"Error: {where}{report.error}", file=sys.stderr)
    if options.quiet:
        return
    for file in files or [None]:
        own = [report for report in reports if report.file == file and not report.error and not report.left]
        _print_warnings(own, f"'{file}': " if files else "")
    names = [name for name, is_told in (("file", files), ("scene", options.scenes), ("object", True)) if is_told]
    rows = [
        (
            *({"file": report.file, "scene": report.scene or "-", "object": report.name}[name] for name in names),
            count_text(report.points),
            count_text(report.rays),
            f"{report.seconds:.2f}",
            _result(report),
        )
        for report in reports
    ]
    rows += [(file, *["-"] * (len(names) + 2), "failed") for file in broken]
    print_table((*names, "points", "rays", "seconds", "mean AO"), rows, sys.stderr, len(names))
    failed = sum(report.error is not None for report in reports)
    left = sum(bool(report.left) for report in reports if not report.error)
    baked = len(reports) - failed - left
    counted = f"{baked} baked, " + (f"{left} left as they are, " if left else "") + f"{failed} failed"
    if files:
        counted += f", {len(broken)} of {len(files)} files failed"
    print(f"{counted}, in {seconds:.1f} s", file=sys.stderr)
    if baked and options.save is None:
        saved = "files were" if files else "was"
        print(f"The .blend {saved} not saved: add --save to keep the bake in it", file=sys.stderr)


def _print_warnings(reports: Sequence[ObjectReport], where: str) -> None:
    """Those of all ``reports``, on stderr: one that several objects have, word for word, once. ``where`` they are."""
    names: dict[str, list[str]] = {}
    for report in reports:
        for warning in dict.fromkeys(report.warnings):
            names.setdefault(warning, []).append(report.name)
    for warning, of in names.items():
        named = ", ".join(f"'{name}'" for name in of[:3]) + (", ..." if len(of) > 3 else "")
        objects = named if len(of) == 1 else f"{len(of)} objects ({named})"
        print(f"Warning: {where}{objects}: {warning}", file=sys.stderr)


def _result(report: ObjectReport) -> str:
    """The last column of the table."""
    if report.error or not report.f0:
        return "failed"
    return "as it was" if report.left else f"{report.f0['mean']:.4f}"
