# SPDX-License-Identifier: GPL-3.0-or-later
"""Fallen bricks and stones: flat-shaded, one heap of them a collection that is instanced again beside it."""

import bpy
import numpy as np

from . import palette
from .noise import fractal_noise
from .patches import Patch, add_object, merged


def _sphere() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (n, 3) and triangles (m, 3) of an icosphere."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=4, radius=1)
    ball = bpy.context.object
    mesh = ball.data
    vertices = np.empty(len(mesh.vertices) * 3, np.float32)
    mesh.vertices.foreach_get("co", vertices)
    triangles = np.empty(len(mesh.polygons) * 3, np.int32)
    mesh.polygons.foreach_get("vertices", triangles)
    bpy.data.objects.remove(ball)
    bpy.data.meshes.remove(mesh)
    return vertices.reshape(-1, 3).astype(float), triangles.reshape(-1, 3)


def _chunk(sphere: np.ndarray, size: np.ndarray, seed: int) -> np.ndarray:
    """A broken block: a sphere cut flat by random planes, stretched to half sizes `size`."""
    rng = np.random.default_rng(seed)
    planes = np.concatenate([np.eye(3), -np.eye(3), rng.normal(size=(5, 3))])
    planes /= np.linalg.norm(planes, axis=1, keepdims=True)
    distances = np.concatenate([np.full(6, 0.62), rng.uniform(0.6, 0.85, 5)])
    reach = (sphere @ planes.T) / distances
    cut = sphere / np.maximum(reach.max(axis=1), 1)[:, None]
    return cut * (1 + 0.04 * fractal_noise(cut * 4, 2, seed))[:, None] * size / 0.62


def _rotation(rng: np.random.Generator) -> np.ndarray:
    tilt, turn = rng.uniform(-0.35, 0.35), rng.uniform(0, 2 * np.pi)
    c, s, ct, st = np.cos(turn), np.sin(turn), np.cos(tilt), np.sin(tilt)
    return np.array([[c, -s * ct, s * st], [s, c * ct, -c * st], [0, st, ct]])


def add_heap(name: str, centre, spread: float, count: int, seed: int, material) -> bpy.types.Object:
    """A heap of chunks resting on the paving around `centre`, biggest in the middle."""
    sphere, triangles = _sphere()
    rng = np.random.default_rng(seed)
    patches = []
    for i in range(count):
        outward = spread * np.sqrt((i + 0.5) / count)
        angle = i * 2.39996 + rng.uniform(-0.4, 0.4)
        size = rng.uniform(0.6, 1.2) * np.array([0.19, 0.11, 0.075]) * (1.25 - 0.75 * i / count)
        chunk = _chunk(sphere, size, seed * 100 + i) @ _rotation(rng).T
        lift = -chunk[:, 2].min() - 0.015 + max(0, 0.16 * (1 - 2.2 * i / count))
        at = np.array([outward * np.cos(angle), outward * np.sin(angle) * 0.7, lift])
        vertices = chunk + at
        tones = np.concatenate([palette.BRICKS[:2], [palette.SANDSTONE, palette.TERRACOTTA, palette.GLAZE]])
        tone = tones[rng.choice(5, p=[0.27, 0.25, 0.28, 0.12, 0.08])]
        colours = palette.mottled(np.broadcast_to(tone, vertices.shape), vertices, seed + i, scale=7)
        patches.append(Patch(vertices, colours, [triangles]))
    heap = add_object(name, merged(patches), material, smooth=False)
    heap.location = centre
    return heap


def add_instances(heap: bpy.types.Object, places) -> None:
    """Put the heap into a collection of its own and instance that at (x, y, turn) places."""
    scene_collection = bpy.context.scene.collection
    collection = bpy.data.collections.new("Rubble")
    scene_collection.children.link(collection)
    scene_collection.objects.unlink(heap)
    collection.objects.link(heap)
    collection.instance_offset = heap.location
    for x, y, turn in places:
        empty = bpy.data.objects.new("Rubble Instance", None)
        empty.instance_type = "COLLECTION"
        empty.instance_collection = collection
        empty.location = (x, y, heap.location.z)
        empty.rotation_euler[2] = turn
        empty.empty_display_size = 0.3
        scene_collection.objects.link(empty)
