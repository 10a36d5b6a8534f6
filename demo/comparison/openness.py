# SPDX-License-Identifier: GPL-3.0-or-later
"""The one number that the surface curve knows of a scene, from what was baked there."""

import importlib

import bpy
import numpy as np

POINTS = 200_000


def _values(collection, name: str, width: int) -> np.ndarray:
    values = np.empty(len(collection) * width, np.int32 if name.endswith(("vertices", "loops")) else np.float32)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


class _Baked:
    """F0 of one baked object anywhere on its triangles."""

    def __init__(self, obj: bpy.types.Object) -> None:
        mesh = obj.data
        self.corners = _values(mesh.loop_triangles, "loops", 3)
        vertices = _values(mesh.loop_triangles, "vertices", 3)
        matrix = np.array(obj.matrix_world)[:3, :3]
        a, b, c = np.moveaxis((_values(mesh.vertices, "co", 3) @ matrix.T)[vertices], 1, 0)
        self.areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
        if obj["multibounce_ao"]["target"] == "VERTEX":
            attribute = mesh.attributes["Multibounce AO"]
            index = vertices if attribute.domain == "POINT" else self.corners
            self._at_corners, self._image = _values(attribute.data, "color", 4)[index, :1], None
        else:
            image = bpy.data.images[f"{obj.name} Multibounce AO"]
            pixels = np.empty(4 * image.size[0] * image.size[1], np.float32)
            image.pixels.foreach_get(pixels)
            self._at_corners = _values(mesh.uv_layers.active.uv, "vector", 2)[self.corners]
            self._image = pixels.reshape(image.size[1], image.size[0], 4)[..., 0]

    def f0(self, triangle: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
        at = np.einsum("kc,kcn->kn", barycentric, self._at_corners[triangle])
        if self._image is None:
            return at[:, 0]
        height, width = self._image.shape
        column, row = np.clip(at * (width, height), 0, (width - 1, height - 1)).astype(int).T
        return self._image[row, column]


def scene_openness(package: str, objects: list[bpy.types.Object]) -> float:
    """core.multibounce.surface_openness of baked `objects` together, from random points spread over their area."""
    rng = np.random.default_rng(0)
    baked = [_Baked(obj) for obj in objects]
    total = sum(each.areas.sum() for each in baked)
    k_a = []
    for each in baked:
        count = round(POINTS * each.areas.sum() / total)
        triangle = rng.choice(len(each.areas), count, p=each.areas / each.areas.sum())
        k_a.append(each.f0(triangle, rng.dirichlet((1, 1, 1), count)))
    multibounce = importlib.import_module(f"{package}.core.multibounce")
    return multibounce.surface_openness(np.concatenate(k_a))
