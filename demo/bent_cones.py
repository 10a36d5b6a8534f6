# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/bent_cones.jpg: a shelter under three Worlds, by AO, by bent cones and path traced, in direct light of
the World alone, on white surfaces. Prints the rms differences from path tracing, a World a line.

Writes out/bent_cones/; with --update-docs also docs/pictures/.
"""

import argparse
import os
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OUT = ROOT / "out" / "bent_cones"
SAMPLES = 256
# Rays through each pixel; path tracing needs them, and is denoised where Cycles can.
RENDER_SAMPLES = 96
SIZE = (460, 330)
# Edge of the cubes that the shelter is made of, metres.
CUBE = 0.08
ROW_HEADER, GAP = 58, 6
DARK, LIGHT = 0.012, 0.85
COLUMNS = ("AO", "Bent Cone", "Combined")
TITLES = {
    "constant": "Constant World",
    "sky": "Evening sky",
    "window": "Window HDRI",
}
# Top and low colour of what lies behind, for the eye only.
BACKDROPS = {
    "constant": ((0.75,) * 3, (0.75,) * 3),
    "sky": ((0.16, 0.30, 0.55), (0.62, 0.60, 0.52)),
    "window": ((0.030, 0.022, 0.015),) * 2,
}


def build() -> None:
    """A floor, walls and roof as one mesh without inner faces, Suzanne under the roof, a ball outside; a camera."""
    import bpy
    import numpy as np

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    at = np.stack(np.meshgrid(*(CUBE * (np.arange(n) + 0.5) + low for n, low in BOUNDS), indexing="ij"), axis=-1)
    solid = np.zeros(at.shape[:3], bool)
    for low, high in WALLS:
        solid |= ((at > low) & (at < high)).all(axis=-1)
    vertices, quads = _skin(np.pad(solid, 1))
    mesh = bpy.data.meshes.new("Shelter")
    low = np.array([low for _, low in BOUNDS])
    mesh.from_pydata((CUBE * (vertices - 1) + low).tolist(), [], quads.tolist())
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Shelter", mesh))
    bpy.ops.mesh.primitive_monkey_add(size=1.5, location=(0.7, 0.35, 0.72), rotation=(-0.3, 0, -0.35))
    bpy.context.object.modifiers.new("Subdivision", "SUBSURF").levels = 3
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=0.42, location=(-1.75, -0.9, 0.42))
    for obj in bpy.context.scene.objects:
        if obj.name != "Shelter":
            # A bake is of the mesh's own vertices.
            evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
            obj.data = bpy.data.meshes.new_from_object(evaluated)
            obj.modifiers.clear()
            obj.data.shade_smooth()
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (-1.9, -7.2, 2.5), (1.36, 0, -0.25)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


# Number of cubes and where they begin, x, y and z.
BOUNDS = ((110, -4.4), (80, -3.6), (36, -0.16))
# Lowest and highest corner: floor, back wall, side wall, roof, a post, a step and a bench.
WALLS = (
    ((-9, -9, -9), (9, 9, 0)),
    ((-2.4, 2.0, 0), (9, 2.3, 2.7)),
    ((2.0, -0.4, 0), (2.3, 2.2, 2.1)),
    ((-0.5, -0.6, 1.9), (2.3, 2.2, 2.1)),
    ((-0.5, -0.6, 0), (-0.25, -0.35, 2.0)),
    ((-2.4, 1.2, 0), (-0.9, 2.2, 0.3)),
    ((1.2, -2.2, 0), (2.2, -1.6, 0.4)),
)


def _skin(solid):
    """The faces between full and empty cubes: vertices (n, 3) in cubes, quads (m, 4) that look into the empty ones."""
    import numpy as np

    corners = []
    for axis in range(3):
        step = np.diff(solid.astype(np.int8), axis=axis)
        for sign in (1, -1):
            first = np.argwhere(step == -sign) + np.eye(3, dtype=int)[axis]
            across, along = np.roll(np.eye(3, dtype=int), -axis - 1, axis=0)[:2]
            around = (0 * across, across, across + along, along)
            corners.append(np.stack(around[:: 1 if sign > 0 else -1])[None] + first[:, None])
    vertices, index = np.unique(np.concatenate(corners).reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, index.reshape(-1, 4)


def bake() -> None:
    """Every object to vertices, as its user would."""
    import bpy

    settings = bpy.context.scene.multibounce_ao
    settings.samples, settings.bounces, settings.use_material_nodes = SAMPLES, "FITTED", False
    meshes = [obj for obj in bpy.context.scene.objects if obj.type == "MESH"]
    for obj in meshes:
        obj.select_set(True)
    bpy.context.view_layer.objects.active = meshes[0]
    bpy.ops.multibounce_ao.bake()


def clay():
    """White, diffuse, and what AO and the bent cone make of the World's light as two more passes."""
    import importlib

    import bpy
    from enable_extension import PACKAGE

    group = importlib.import_module(f"{PACKAGE}.shader_nodes.bent_cone").ensure()
    material = bpy.data.materials.new("Clay")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    cone, opened = nodes.new("ShaderNodeGroup"), nodes.new("ShaderNodeGroup")
    cone.node_tree = opened.node_tree = group
    bent, bounces = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeAttribute")
    bent.attribute_name, bounces.attribute_name = "Bent Cone", "Multibounce AO"
    links.new(bent.outputs["Color"], cone.inputs["Bent Cone"])
    links.new(bent.outputs["Alpha"], cone.inputs["Alpha"])
    f0, plain = nodes.new("ShaderNodeSeparateColor"), nodes.new("ShaderNodeVectorMath")
    plain.operation = "SCALE"
    links.new(bounces.outputs["Color"], f0.inputs[0])
    links.new(opened.outputs["Irradiance"], plain.inputs[0])  # no cone: that of an open surface
    links.new(f0.outputs["Red"], plain.inputs["Scale"])
    for name, socket in (("AO", plain.outputs[0]), ("Bent Cone", cone.outputs["Irradiance"])):
        bpy.context.view_layer.aovs.add().name = name
        output = nodes.new("ShaderNodeOutputAOV")
        output.aov_name = name
        links.new(socket, output.inputs["Color"])
    diffuse, end = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    links.new(diffuse.outputs[0], end.inputs["Surface"])
    bpy.context.view_layer.material_override = material


def use_world(kind: str) -> None:
    import bpy
    import numpy as np

    from core.spherical_harmonics import equirectangular

    world = bpy.data.worlds.new(kind)
    world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    background.inputs["Color"].default_value = (1, 1, 1, 1)
    if kind == "sky":
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sun_disc, sky.sun_elevation, sky.sun_rotation = False, np.radians(15), np.radians(230)
        tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    elif kind == "window":
        # A tall window to the left, as an HDRI of 512 x 256: blurred a little, as glass is by curtains.
        directions, _ = equirectangular(256, 512)
        x, y, z = np.moveaxis(directions, -1, 0)
        beside, up = np.degrees(np.arctan2(-y - 0.45, -x)), np.degrees(np.arcsin(z))
        cover = 1 / (1 + np.exp(np.maximum((np.abs(beside - 10) - 32) / 3, (np.abs(up - 32) - 30) / 3)))
        pixels = np.ones((256, 512, 4), np.float32)
        pixels[..., :3] = (0.10, 0.07, 0.045) + cover[..., None] * np.array((3.8, 4.3, 5.0))
        image = bpy.data.images.new("Window", 512, 256, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = image
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    bpy.context.scene.world = world


def main(update_docs: bool) -> None:
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT)]
    import bpy
    import numpy as np
    import renders
    from captions import render_text
    from enable_extension import enable_extension
    from pictures import against_reference, over_sky, save_picture

    enable_extension()
    OUT.mkdir(parents=True, exist_ok=True)
    build()
    renders.set_up()
    bpy.context.scene.render.resolution_x, bpy.context.scene.render.resolution_y = width, height = SIZE
    bpy.context.scene.cycles.use_denoising = True
    bpy.context.scene.cycles.denoising_prefilter = "FAST"
    bake()
    clay()
    page = np.full((len(TITLES) * (ROW_HEADER + height + GAP), len(COLUMNS) * (width + GAP) - GAP, 3), DARK)
    lines = []
    for row, (kind, title) in enumerate(TITLES.items()):
        use_world(kind)
        bpy.ops.multibounce_ao.project_world()
        passes = renders.render(RENDER_SAMPLES, bounces=0)
        truth = passes["Combined"]
        rms = {name: against_reference(passes[name], truth)["rms"] for name in COLUMNS[:2]}
        print(f"{kind}: rms from path tracing {rms['AO']:.4f} by AO, {rms['Bent Cone']:.4f} by bent cones", flush=True)
        gain = 0.75 / np.quantile(truth[truth[..., 3] > 0.999][:, :3], 0.98)
        y = row * (ROW_HEADER + height + GAP)
        notes = {name: f"rms difference {off:.3f}" for name, off in rms.items()} | {"Combined": "the reference"}
        names = {"AO": "AO", "Bent Cone": "Bent cones", "Combined": "Path traced"}
        for column, name in enumerate(COLUMNS):
            shown = passes[name].copy()
            shown[..., 3] = truth[..., 3]
            shown[..., :3] *= gain
            picture = over_sky(shown, *(np.array(each) for each in BACKDROPS[kind]))
            x = column * (width + GAP)
            page[y + ROW_HEADER : y + ROW_HEADER + height, x : x + width] = picture
            head = f"{title}. {names[name]}" if column == 0 else names[name]
            lines += [(head, x + 6, y + 26, 18), (notes[name], x + 6, y + 47, 15)]
    text = render_text(lines, page.shape[1], page.shape[0])[..., None]
    save_picture(page * (1 - text) + LIGHT * text, OUT / "bent_cones.jpg")
    if update_docs:
        shutil.copy(OUT / "bent_cones.jpg", ROOT / "docs" / "pictures")
    print(f"See {OUT}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--update-docs", action="store_true", help="also write docs/pictures/")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="multibounce_ao-") as user_folder:
        # The bpy module reads this when it is imported: the user's own Blender settings stay as they are.
        os.environ["BLENDER_USER_RESOURCES"] = user_folder
        main(arguments.update_docs)
