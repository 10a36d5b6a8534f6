# SPDX-License-Identifier: GPL-3.0-or-later
"""run.py [NAME]...: runs the benchmarks of this folder, or those named, and ends with a table of their ratios.

A benchmark is a module with `main()`, which prints what it measures and may return ratios: what is compared -> how many
times faster than the other. A slow machine fails nothing.
"""

import atexit
import importlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
# As for the tests: settings of its own, the package from the source tree.
os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="multibounce_ao-")
atexit.register(shutil.rmtree, os.environ["BLENDER_USER_RESOURCES"], ignore_errors=True)
sys.path[:0] = [str(FOLDER), str(FOLDER.parent), str(FOLDER.parent.parent)]


def main() -> None:
    here = sorted(path.stem for path in FOLDER.glob("*.py") if path != Path(__file__).resolve())
    names = sys.argv[1:] or here
    unknown = set(names) - set(here)
    if unknown:
        sys.exit(f"no benchmark {', '.join(sorted(unknown))}: choose among {', '.join(here)}")
    ratios: dict[str, float] = {}
    for name in names:
        print(f"== {name}", flush=True)
        ratios |= importlib.import_module(name).main() or {}
        print(flush=True)
    if ratios:
        width = max(map(len, ratios))
        print(f"{'':{width}}  times faster")
        for what, ratio in ratios.items():
            print(f"{what:{width}}  {ratio:12.2f}")


if __name__ == "__main__":
    main()
