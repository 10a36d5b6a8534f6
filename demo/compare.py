# SPDX-License-Identifier: GPL-3.0-or-later
"""`make compare`: every model of the bounced light beside Cycles' path tracing of the same scenes, into out/compare/.

--update-docs also writes docs/bounces.md with its pictures; --quick takes few samples, to see that all of it runs;
--again takes the renders that the last run left in out/compare/.
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "compare"
STARTED = time.perf_counter()
RAYS, SAMPLES = 512, 1024
QUICK_RAYS, QUICK_SAMPLES = 32, 16


def say(text: str) -> None:
    print(f"[{time.perf_counter() - STARTED:6.1f} s] {text}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few samples: to see that all of it runs")
    parser.add_argument("--again", action="store_true", help="only pictures and figures, of the last run's renders")
    parser.add_argument("--update-docs", action="store_true", help="write docs/bounces.md and its pictures")
    asked = parser.parse_args()
    if asked.quick and asked.update_docs:
        parser.error("--update-docs needs all samples")
    with tempfile.TemporaryDirectory(prefix="multibounce_ao-") as user_folder:
        # The bpy module reads this when it is imported: the user's own Blender settings stay as they are.
        os.environ["BLENDER_USER_RESOURCES"] = user_folder
        run(asked)


def run(asked: argparse.Namespace) -> None:
    import bpy  # noqa: F401  first: what follows needs it

    sys.path.insert(0, str(ROOT / "tests"))
    from comparison.measure import Comparison, compare
    from comparison.strips import save_strip
    from comparison.subjects import SUBJECTS
    from enable_extension import enable_extension

    folder = OUT / "quick" if asked.quick else OUT
    folder.mkdir(parents=True, exist_ok=True)
    package = enable_extension().__name__
    rays, samples = (QUICK_RAYS, QUICK_SAMPLES) if asked.quick else (RAYS, SAMPLES)
    comparisons = []
    for subject in SUBJECTS:
        made = compare(package, subject, rays, samples, say)
        if asked.again:
            made = (Comparison.load(folder, subject, own_colours) for own_colours in (False, True))
        for comparison in made:
            comparison.save(folder)
            save_strip(comparison, folder)
            tell(comparison)
            comparisons.append(comparison)
    if asked.update_docs:
        from comparison.page import write_page

        write_page(comparisons, rays, samples, folder, ROOT)
    say(f"see {folder}")


def tell(comparison) -> None:
    """Print how far each model is from the path-traced picture."""
    from comparison.models import MODELS

    print(f"{comparison.name}, off path tracing: mean |difference|, rms, bias; its own noise {comparison.noise:.4f}")
    for model in MODELS:
        off = comparison.difference(model.name)
        print(f"  {model.title:15} {off.absolute:.4f}  {off.rms:.4f}  {off.bias:+.4f}", flush=True)


if __name__ == "__main__":
    main()
