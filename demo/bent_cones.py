# SPDX-License-Identifier: GPL-3.0-or-later
"""out/bent_cones.png, of which docs/bent_cones.md tells: Suzanne in a niche under three Worlds, by AO, by bent cones
and path traced.

Direct light of the World alone, on white surfaces. Prints the rms differences from path tracing, a World a line.
"""

import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SIZE = (400, 300)
SAMPLES, TRUTH_SAMPLES = 256, 128


def box(name, low, high):
    import bpy

    corners = [tuple((low, high)[bit][axis] for axis, bit in enumerate(bits)) for bits in CORNERS]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], FACES)
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    obj.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    obj.modifiers[0].levels = 6
    return obj


CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def build():
    """Floor, back wall, slab on a side wall, and Suzanne under its edge; a camera."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    objects = [
        box("Floor", (-4, -4, -0.1), (4, 3, 0)),
        box("Back", (-4, 2, 0), (4, 2.2, 3)),
        box("Side", (2, -1, 0), (2.2, 2, 2)),
        box("Slab", (-0.6, -1.2, 2), (2.2, 2, 2.15)),
    ]
    bpy.ops.mesh.primitive_monkey_add(size=1.5, location=(-0.2, 0.2, 0.75), rotation=(-0.3, 0, -0.3))
    suzanne = bpy.context.object
    suzanne.modifiers.new("Subdivision", "SUBSURF").levels = 3
    suzanne.data.shade_smooth()
    material = bpy.data.materials.new("White")
    material.use_nodes = True
    for obj in (*objects, suzanne):
        # A bake is of the mesh's own vertices.
        bpy.context.view_layer.update()
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        obj.data = bpy.data.meshes.new_from_object(evaluated)
        obj.modifiers.clear()
        obj.data.materials.clear()
        obj.data.materials.append(material)
        obj.select_set(True)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (-1.6, -6.2, 2.3), (1.36, 0, -0.27)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    return material


def use_world(kind):
    import bpy
    import numpy as np

    world = bpy.data.worlds.new(kind)
    world.use_nodes = True
    tree = world.node_tree
    background = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeBackground")
    if kind == "white":
        background.inputs["Color"].default_value = (1, 1, 1, 1)
    elif kind == "sky":
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sun_disc, sky.sun_elevation, sky.sun_rotation = False, np.radians(15), np.radians(230)
        tree.links.new(sky.outputs["Color"], background.inputs["Color"])
        background.inputs["Strength"].default_value = 0.25
    else:
        # A bright window to the left in a dim, warm room, as an HDRI of 512 x 256.
        from core.spherical_harmonics import equirectangular

        directions, _ = equirectangular(256, 512)
        towards = np.array((-0.75, -0.35, 0.55)) / np.linalg.norm((-0.75, -0.35, 0.55))
        pixels = np.full((256, 512, 4), (0.16, 0.12, 0.08, 1.0), np.float32)
        pixels[directions @ towards > np.cos(np.radians(35))] = (4.0, 4.4, 5.0, 1.0)
        image = bpy.data.images.new("Window", 512, 256, float_buffer=True)
        image.colorspace_settings.name = "Non-Color"
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        texture = tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = image
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    bpy.context.scene.world = world


def render(samples, folder):
    import bpy
    import numpy as np

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.render.film_transparent = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = str(Path(folder) / "picture.exr")
    scene.cycles.samples, scene.cycles.max_bounces = samples, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty((SIZE[1], SIZE[0], 4), np.float32)
    image.pixels.foreach_get(pixels.reshape(-1))
    bpy.data.images.remove(image)
    return pixels


def emit(material, socket):
    nodes, links = material.node_tree.nodes, material.node_tree.links
    emission = nodes.new("ShaderNodeEmission")
    links.new(socket, emission.inputs["Color"])
    links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])


def main():
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT)]
    import bpy
    import numpy as np
    from enable_extension import PACKAGE, enable_extension

    enable_extension()
    material = build()
    settings = bpy.context.scene.multibounce_ao
    settings.samples = SAMPLES
    bpy.ops.multibounce_ao.bake()
    bpy.ops.multibounce_ao.add_world_light()
    tree = material.node_tree
    by_name = {node.node_tree.name: node for node in tree.nodes if node.bl_idname == "ShaderNodeGroup"}
    cone, bounces = by_name["Bent Cone Irradiance"], by_name["Multibounce AO"]
    opened = tree.nodes.new("ShaderNodeGroup")  # no cone: the plain irradiance
    opened.node_tree = cone.node_tree
    plain = tree.nodes.new("ShaderNodeVectorMath")
    plain.operation = "MULTIPLY"
    tree.links.new(opened.outputs["Irradiance"], plain.inputs[0])
    tree.links.new(bounces.outputs["AO"], plain.inputs[1])
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("white", "sky", "window"):
            use_world(kind)
            bpy.ops.multibounce_ao.project_world()
            emit(material, plain.outputs[0])
            ours = render(16, folder)
            emit(material, cone.outputs["Irradiance"])
            bent = render(16, folder)
            tree.links.new(diffuse.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
            truth = render(TRUTH_SAMPLES, folder)
            inside = truth[..., 3] > 0.999
            errors = [np.sqrt(np.mean((each - truth)[inside][:, :3] ** 2)) for each in (ours, bent)]
            print(f"{kind}: rms from path tracing {errors[0]:.4f} by AO, {errors[1]:.4f} by bent cones", flush=True)
            rows.append(np.concatenate((ours, bent, truth), axis=1) * (0.8 / np.quantile(truth[inside][:, :3], 0.98)))
    picture = np.concatenate(rows[::-1], axis=0)
    linear = np.clip(picture[..., :3] + 0.05 * (1 - picture[..., 3:].clip(0, 1)), 0, 1)
    picture[..., :3] = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    picture[..., 3] = 1
    image = bpy.data.images.new("Bent Cones", picture.shape[1], picture.shape[0])
    image.pixels.foreach_set(np.ascontiguousarray(picture, np.float32).ravel())
    image.file_format = "PNG"
    (ROOT / "out").mkdir(exist_ok=True)
    image.filepath_raw = str(ROOT / "out" / "bent_cones.png")
    image.save()
    print(f"written: {image.filepath_raw} ({PACKAGE})")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="multibounce_ao-") as user_folder:
        # The bpy module reads this when it is imported: the user's own Blender settings stay as they are.
        os.environ["BLENDER_USER_RESOURCES"] = user_folder
        main()
