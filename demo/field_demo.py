# SPDX-License-Identifier: GPL-3.0-or-later
"""`make demo-field`: props on a floor darken each other by AO fields, in EEVEE and in Cycles, beside ray-traced AO.

Each field is baked once, and then the props move and turn. Writes into out/demo-field/.
"""

import json
import os
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "demo-field"
STARTED = time.perf_counter()


def say(text: str) -> None:
    print(f"[{time.perf_counter() - STARTED:5.1f} s] {text}", flush=True)


def main() -> None:
    with tempfile.TemporaryDirectory(prefix="multibounce_ao-") as user_folder:
        # The bpy module reads this when it is imported: the user's own Blender settings stay as they are.
        os.environ["BLENDER_USER_RESOURCES"] = user_folder
        run()


def run() -> None:
    import bpy

    sys.path.insert(0, str(ROOT / "tests"))
    import field_props
    import field_renders
    from enable_extension import enable_extension

    OUT.mkdir(parents=True, exist_ok=True)
    enable_extension()
    bpy.context.preferences.filepaths.save_version = 0
    stage = field_props.build()
    bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "field.blend"), compress=True)
    bake(stage)
    bpy.ops.wm.save_mainfile(compress=True)

    field_renders.set_up()
    with_eevee = field_renders.has_opengl()
    if not with_eevee:
        say("no OpenGL here that Blender can draw with headless: EEVEE is left out")
    pictures = field_renders.render_all(field_props.FRAMES, with_eevee, say)
    differences = {
        frame: {
            name: field_renders.difference(picture, found["Ray-traced"])
            for name, picture in found.items()
            if name != "Ray-traced"
        }
        for frame, found in pictures.items()
    }
    field_renders.save_sheet(list(pictures.values()), differences, OUT / "field.png")
    (OUT / "differences.json").write_text(json.dumps(differences, indent=2))
    print("Linear RGB against ray-traced AO, rms over the picture:")
    for frame, found in differences.items():
        print(f"  frame {frame:2}   " + "   ".join(f"{name} {value:.4f}" for name, value in found.items()))
    print(f"See {OUT}")


def bake(stage) -> None:
    """As a user would: choose settings, select objects, press the buttons."""
    import bpy

    settings, operators = bpy.context.scene.multibounce_ao, bpy.ops.multibounce_ao

    def select(active, others=()) -> None:
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj == active or obj in others)
        bpy.context.view_layer.objects.active = active

    say("baking AO of the props to their vertices")
    settings.occluders, settings.use_material_nodes, settings.samples = "SELF", False, 256
    settings.bounces = "FITTED"
    for prop in (*stage.standing, *stage.flying):
        settings.use_ground_plane = prop in stage.standing
        select(prop)
        operators.bake()
    settings.output_directory, settings.samples, settings.field_resolution = "//fields", 512, 24
    settings.use_field_volume = True
    for prop in stage.props:
        say(f"baking the AO field of '{prop.name}'")
        select(prop)
        operators.bake_field()
        select(prop, [obj for obj in (stage.floor, *stage.props) if obj != prop])
        operators.apply_field()


if __name__ == "__main__":
    main()
