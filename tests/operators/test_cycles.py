# SPDX-License-Identifier: GPL-3.0-or-later
"""A texture bake against Cycles' own ambient occlusion bake, at 1024 samples each."""

import bpy
import numpy as np
from scipy.ndimage import binary_erosion

from .bakes import bake, pixels, select
from .meshes import suzanne

SIZE, SAMPLES = 128, 1024


def unwrap(obj):
    select(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.03)
    bpy.ops.object.mode_set(mode="OBJECT")


def cycles_ambient_occlusion(obj):
    """(h, w) F0 by Cycles, and which texels it covers (h, w)."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.world = bpy.data.worlds.new("World")
    scene.world.light_settings.distance = 1e5
    image = bpy.data.images.new("Cycles", SIZE, SIZE, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.full(SIZE * SIZE * 4, -1, np.float32))
    obj.data.materials.append(bpy.data.materials.new("Cycles"))
    tree = obj.data.materials[0].node_tree
    if tree is None:  # before Blender 5.0
        obj.data.materials[0].use_nodes = True
        tree = obj.data.materials[0].node_tree
    tree.nodes.active = tree.nodes.new("ShaderNodeTexImage")
    tree.nodes.active.image = image
    select(obj)
    bpy.ops.object.bake(type="AO", margin=0, use_clear=False)
    result = pixels(image)[..., 0].astype(float)
    return result, result >= 0


def test_suzanne():
    obj = suzanne(levels=2)
    unwrap(obj)
    expected, covered = cycles_ambient_occlusion(obj)
    bake(obj, samples=SAMPLES, target="TEXTURE", resolution=SIZE, margin=0, use_material_nodes=False)
    ours = pixels(bpy.data.images["Suzanne Multibounce AO"])[..., 0].astype(float)

    # Texels at island borders are only partly covered, and the two programs take other parts of them.
    inside = binary_erosion(covered, np.ones((3, 3)), iterations=2)
    assert inside.sum() > 2000
    assert np.ptp(expected[inside]) > 0.8
    difference = (ours - expected)[inside]
    print(
        f"against Cycles over {inside.sum()} texels: mean {difference.mean():+.4f}, "
        f"mean of magnitudes {abs(difference).mean():.4f}, rms {np.sqrt(np.mean(difference**2)):.4f}"
    )
    assert abs(difference.mean()) < 0.005
