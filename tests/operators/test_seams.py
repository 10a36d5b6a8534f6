# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders find at seams: bilinear lookups all over a mesh of many small islands, against the truth there."""

import bpy
import numpy as np
import pytest

from core.rays import Occluders
from core.sample_points import SurfacePoints
from core.sampling import hemisphere_pattern
from core.visibility import trace_visibility

from .bakes import bake, operators, pixels, rms
from .meshes import add_mesh, plate, positions, read

ACROSS, ALONG, STEPS = 20, 10, 6  # islands, and quads along each side of one
SIZE, GAP = 256, 4  # texels: the image, and what lies between islands
CELLS = 15  # along each side of the image
CELL = SIZE / CELLS
ROOF = [(-1.5, -9, 0.1), (1.5, -9, 2), (1.5, 9, 2), (-1.5, 9, 0.1)], [(0, 1, 2, 3)]


def waves():
    """A sheet of 200 islands, each with its own place in the image."""
    columns, rows = ACROSS * STEPS, ALONG * STEPS
    x, y = np.meshgrid(np.arange(columns + 1) / STEPS, np.arange(rows + 1) / STEPS)
    z = 0.7 * np.sin(1.9 * x) * np.cos(2.3 * y)
    column, row = (axis.ravel() for axis in np.meshgrid(np.arange(columns), np.arange(rows)))
    low = row * (columns + 1) + column
    faces = np.column_stack((low, low + 1, low + columns + 2, low + columns + 1))
    obj = add_mesh("Waves", np.column_stack((x.ravel(), y.ravel(), z.ravel())), faces)
    island = (row // STEPS) * ACROSS + column // STEPS
    corner = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    inside = np.stack((column % STEPS, row % STEPS), axis=-1)[:, None] + corner
    low_end = np.stack((island % CELLS, island // CELLS), axis=-1)[:, None] * CELL + 0.5 * GAP
    # Every other island lies on its side, so that its neighbours meet it from another direction.
    inside = np.where((island % 2 == 0)[:, None, None], inside, np.stack((inside[..., 1], STEPS - inside[..., 0]), -1))
    uv = (low_end + inside / STEPS * (CELL - GAP)) / SIZE
    layer = obj.data.uv_layers.new()
    layer.uv.foreach_set("vector", uv.astype(np.float32).ravel())
    return obj


def random_places(obj, count):
    """Points and normals (n, 3) all over the mesh, their UVs (n, 2)."""
    random = np.random.default_rng(0)
    mesh = obj.data
    mesh.calc_loop_triangles()
    loops = read(mesh.loop_triangles, "loops", 3, np.int32)
    vertex = read(mesh.loops, "vertex_index", 1, np.int32)
    v, w = random.random((2, count))
    over = v + w > 1
    v[over], w[over] = 1 - v[over], 1 - w[over]
    weights = np.column_stack((1 - v - w, v, w))
    corner = loops[random.integers(len(loops), size=count)]
    normals = np.einsum("nc,ncx->nx", weights, read(mesh.corner_normals, "vector", 3)[corner])
    points = np.einsum("nc,ncx->nx", weights, positions(obj)[vertex[corner]])
    uv = np.einsum("nc,ncx->nx", weights, read(mesh.uv_layers[0].uv, "vector", 2)[corner])
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True), uv


def lookup(image, uv):
    """As graphics cards do."""
    at = uv * image.shape[::-1] - 0.5
    low = np.floor(at).astype(int)
    x, y = (at - low).T
    left, right = (np.clip(low[:, 0] + step, 0, image.shape[1] - 1) for step in (0, 1))
    lower, upper = (np.clip(low[:, 1] + step, 0, image.shape[0] - 1) for step in (0, 1))
    below, above = (image[row, left] * (1 - x) + image[row, right] * x for row in (lower, upper))
    return below * (1 - y) + above * y


def truth(obj, points, normals):
    """F0 (n,) at points that ``obj`` is around, by 1024 rays each."""
    obj.data.calc_loop_triangles()
    occluders = Occluders(positions(obj), read(obj.data.loop_triangles, "vertices", 3, np.int32))
    tracing = trace_visibility(occluders, SurfacePoints(points, normals), hemisphere_pattern(1024), extent=20.0)
    return operators("progress").drive(tracing, lambda _: None).f0


@pytest.mark.usefixtures("fitted")
def test_lookups_all_over_two_hundred_islands():
    """At a margin of 2 nothing of the background is seen, and either type meets what lies across the seam about as
    well as the texels inside meet their own places."""
    obj = waves()
    points, normals, uv = random_places(obj, 3000)
    expected = truth(obj, points, normals)
    assert np.std(expected) > 0.1
    from_border = uv * SIZE % CELL - 0.5 * GAP
    at_border = np.minimum(from_border, CELL - GAP - from_border).min(axis=1) < 1
    assert at_border.mean() > 0.25
    for margin_type in ("EXTEND", "ADJACENT_FACES"):
        bake(obj, samples=64, target="TEXTURE", resolution=SIZE, margin=2, margin_type=margin_type)
        image = pixels(bpy.data.images["Waves Multibounce AO"])[..., 0].astype(float)
        error = lookup(image, uv) - expected
        print(
            f"{margin_type}: rms {rms(error):.4f}, within a texel of a border {rms(error[at_border]):.4f}, "
            f"elsewhere {rms(error[~at_border]):.4f}, most {np.abs(error).max():.3f}"
        )
        assert rms(error) < 0.03
        assert rms(error[at_border]) < 0.03


@pytest.mark.usefixtures("fitted")
def test_adjacent_faces_go_on_across_the_seam():
    """Two halves of a floor below a slanted roof lie apart in the image, one of them turned and at another scale. The
    margin of either shows what lies across; "Extend" repeats its own border."""
    floor = plate("Floor", steps=2)

    def place(x, y, is_right):
        return (0.9 - 0.15 * (y + 1), 0.6 + 0.15 * x) if is_right else (0.1 + 0.3 * (x + 1), 0.1 + 0.3 * (y + 1))

    faces = floor.data.polygons
    uv = [place(*positions(floor)[vertex, :2], face.center.x > 0) for face in faces for vertex in face.vertices]
    floor.data.uv_layers[0].uv.foreach_set("vector", np.float32(uv).ravel())
    roof = add_mesh("Roof", *ROOF)
    # Across x = 0, on the line y = 0: twelve texels beyond the left half, six beyond the right one.
    x = (np.arange(12) + 0.5) / 128 / 0.3
    expected = truth(roof, np.column_stack((x, 0 * x, 0 * x)), np.tile((0.0, 0.0, 1.0), (len(x), 1)))
    error = {}
    for margin_type in ("EXTEND", "ADJACENT_FACES"):
        bake(floor, samples=1024, target="TEXTURE", resolution=128, margin=12, margin_type=margin_type)
        image = pixels(bpy.data.images["Floor Multibounce AO"])[..., 0].astype(float)
        error[margin_type] = rms(lookup(image, np.column_stack((0.4 + 0.3 * x, 0.4 + 0 * x))) - expected)
    print(error)
    assert error["EXTEND"] > 0.02
    assert error["ADJACENT_FACES"] < 0.005


def test_margins_cross_borders_of_the_surface_nowhere():
    """A floor of one island: beyond its edge there is nothing, so that either type is "Extend"."""
    floor = plate("Floor", steps=2)
    layer = floor.data.uv_layers[0].uv
    layer.foreach_set("vector", np.float32(0.3 + 0.4 * read(layer, "vector", 2)).ravel())
    add_mesh("Roof", *ROOF)
    found = []
    for margin_type in ("EXTEND", "ADJACENT_FACES"):
        bake(floor, target="TEXTURE", resolution=32, margin=3, margin_type=margin_type)
        found.append(pixels(bpy.data.images["Floor Multibounce AO"]))
    assert (found[0][..., 0] > 0).sum() > 13**2
    np.testing.assert_array_equal(*found)
