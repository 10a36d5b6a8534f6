# SPDX-License-Identifier: GPL-3.0-or-later
"""run.py [--quick] [--update-docs] [NAME]...: runs the benchmarks, or those named; ends with a table of figures.

A benchmark is a module of this folder with `main(report, quick)`, which takes what it compares in turns, in one
process. Beside a figure stands what is asked of it; a slow machine fails nothing. Environment:
BENCH_MESHES="a.obj b.obj" adds meshes to those that the benchmarks make.
"""

import argparse
import atexit
import importlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
NAMES = (
    *("vertex_bake", "texture_bake", "ray_rate", "error_vs_time", "error_of_random"),
    *("scaling", "memory", "density", "curves", "bounces_cost", "bent_cones", "white_world", "field"),
    *("kill", "terminator", "texel_error", "memory_8k", "time_left", "preview"),
)
# As for the tests: settings of its own, the package from the source tree.
os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="multibounce_ao-")
atexit.register(shutil.rmtree, os.environ["BLENDER_USER_RESOURCES"], ignore_errors=True)
sys.path[:0] = [str(FOLDER), str(FOLDER.parent), str(FOLDER.parent.parent)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", metavar="NAME", nargs="*", help=", ".join(NAMES))
    parser.add_argument("--quick", action="store_true", help="tiny and once each: to see that all runs")
    parser.add_argument("--update-docs", action="store_true", help="write docs/benchmarks.md and its plots")
    asked = parser.parse_args()
    if unknown := set(asked.names) - set(NAMES):
        parser.error(f"no benchmark {', '.join(sorted(unknown))}: choose among {', '.join(NAMES)}")
    if asked.update_docs and (asked.names or asked.quick):
        parser.error("--update-docs tells of all benchmarks in full")

    from bakes import warm_up
    from enable_extension import enable_extension
    from report import Report

    enable_extension()
    warm_up()
    report = Report()
    for name in asked.names or NAMES:
        module = importlib.import_module(name)
        report.begin(name, module.__doc__)
        module.main(report, asked.quick)
    print(f"\n{report.table()}")
    if asked.update_docs:
        from docs_page import write_docs

        write_docs(report, FOLDER.parent.parent / "docs")


if __name__ == "__main__":
    main()
