# SPDX-License-Identifier: GPL-3.0-or-later
"""`make demo`: builds a ruin, bakes it to vertices and to a texture, and renders it before and after, into out/demo/.

Then an urn is put down in it, whose AO field darkens the ground that was baked without it.

With --update-docs it also writes the README's pictures into docs/pictures/.
"""

import argparse
import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "demo"
STARTED = time.perf_counter()


def say(text: str) -> None:
    print(f"[{time.perf_counter() - STARTED:5.1f} s] {text}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--update-docs", action="store_true", help="also write docs/pictures/")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="multibounce_ao-") as user_folder:
        # The bpy module reads this when it is imported: the user's own Blender settings stay as they are.
        os.environ["BLENDER_USER_RESOURCES"] = user_folder
        run(arguments.update_docs)


def run(update_docs: bool) -> None:
    import bpy

    sys.path.insert(0, str(ROOT / "tests"))
    import bakes
    import pictures
    import renders
    import scene
    from enable_extension import enable_extension

    OUT.mkdir(parents=True, exist_ok=True)
    enable_extension()
    bpy.context.preferences.filepaths.save_version = 0
    say("building the ruin")
    ruin = scene.build()
    renders.set_up()
    # Saved before the bake too: only a saved file can keep its maps under a path relative to it.
    scene_file = OUT / "ruin.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene_file), compress=True)
    say("baking multibounce AO, and the AO field of an urn")
    seconds = bakes.bake_ruin(ruin, "//maps/")
    bpy.ops.wm.save_mainfile(compress=True)
    report = bakes.report(ruin, seconds, scene_file)
    (OUT / "report.json").write_text(json.dumps(report, indent=2))

    ruin.prop.hide_render = True
    say("rendering flat ambient, gray AO and multibounce AO")
    flat, grey, bounced = renders.ambient()
    say("rendering the urn, without its AO field and with it")
    without_field, with_field = renders.field(ruin.prop)
    say("rendering the sun")
    sunlight = renders.sunlight(ruin.sun)
    say(f"path tracing the reference: {renders.REFERENCE_BOUNCES} bounces, {renders.REFERENCE_SAMPLES} samples")
    reference = renders.path_traced(ruin.sun)
    say("writing the pictures")
    pictures.save_field(OUT, without_field, with_field)
    differences = pictures.save_all(OUT, flat, grey, bounced, reference, sunlight)
    (OUT / "differences.json").write_text(json.dumps(differences, indent=2))
    if update_docs:
        docs = ROOT / "docs" / "pictures"
        docs.mkdir(parents=True, exist_ok=True)
        for name in ("hero.png", "comparison.png"):
            shutil.copy(OUT / name, docs / name)
    tell(report, differences)


def tell(report: dict, differences: dict) -> None:
    """Print what was baked, and how far each picture is from the path-traced one."""
    points = sum(entry["points"] for entry in report["objects"])
    rays = sum(entry["rays"] for entry in report["objects"])
    baked = f"{len(report['objects'])} bakes, {points:,} points, {rays / 1e6:.0f} M rays"
    say(f"{baked} in {report['seconds']:.1f} s")
    print("Linear RGB against the path-traced reference, over the pixels of the ruin:")
    for name, difference in differences.items():
        print(f"  {name + '.png':12} rms {difference['rms']:.4f}   mean {difference['mean']:+.4f}")
    print(f"See {OUT}")


if __name__ == "__main__":
    main()
