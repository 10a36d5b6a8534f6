# SPDX-License-Identifier: GPL-3.0-or-later
"""Which hits share a cell of the light cache, how many cells there are, and what they take."""

import tracemalloc

import numpy as np

from core.cells import CellKeys, Cells, Grid, side_of
from core.faces import BACK_OF, Faces, facing_of
from core.light_cache import FEWEST_CELLS, build_light_cache
from core.rays import Occluders
from core.sample_points import SurfacePoints
from core.workers import Workers

from .shapes import bumpy, join, plate, vertex_normals
from .tracing import finish

GRID = Grid(np.zeros(3), 2.0, 0.1)


def faces_of(occluders):
    with Workers(2) as workers:
        return Faces.of(occluders, workers)


def keys_of(mesh, triangle, positions, behind=False, grid=GRID):
    """Keys of hits at ``positions``, which are in the units of the scene: the mesh is 2 wide about the origin."""
    occluders = Occluders(*mesh, centre=(0, 0, 0))
    assert occluders.scale == 1.0
    side = side_of(np.full(len(positions), triangle), np.full(len(positions), behind))
    return CellKeys(faces_of(occluders), grid).of_hits(side, np.asarray(positions, np.float32))


def test_a_large_triangle_is_cut_into_squares():
    """Points of a plate 20 cells wide: as many cells as squares of the grid, each of its side."""
    at = np.random.default_rng(0).uniform(-0.999, 0.999, (20000, 2))
    keys = keys_of(plate(), 0, np.pad(at, ((0, 0), (0, 1))))
    names, cell = np.unique(keys, return_inverse=True)
    assert 20**2 <= len(names) <= 21**2
    for axis in at.T:
        low, high = np.full(len(names), np.inf), np.full(len(names), -np.inf)
        np.minimum.at(low, cell, axis)
        np.maximum.at(high, cell, axis)
        assert (high - low).max() <= 0.1


def test_sides_and_layers_share_no_cell():
    two = join(plate(), plate(z=1e-4))
    at = [(0.33, 0.44, 0.0)]
    keys = [keys_of(two, triangle, at, behind)[0] for triangle in (0, 2) for behind in (False, True)]
    assert len(set(keys)) == 4


def test_tiny_triangles_share_one_with_neighbours_that_face_the_same_way():
    mesh = bumpy(201, height=0.0)  # nearly flat, triangles of a tenth of a cell
    occluders = Occluders(mesh[0] * (1.0, 1.0, 0.001), mesh[1], centre=(0, 0, 0))
    front, back = CellKeys(faces_of(occluders), GRID).of_faces(np.arange(len(mesh[1])))
    assert (front >= 0).all() and not set(front) & set(back)
    assert 20**2 <= len(np.unique(front)) <= 22**2


def test_further_away_the_grid_is_coarser():
    """A floor of 200 sizes: cells grow with the distance, so that each doubling of it brings as many."""
    wide = Grid(np.zeros(3), 0.005, 0.0005)
    at = np.random.default_rng(0).uniform(-0.99, 0.99, (200000, 2))
    keys = keys_of(plate(), 0, np.pad(at, ((0, 0), (0, 1))), grid=wide)
    assert len(np.unique(keys)) < 9 * 21**2


def test_cells_are_found_again_and_others_are_not():
    mesh = join(plate(), bumpy(60))
    occluders = Occluders(*mesh, ground_height=-2.0)
    random = np.random.default_rng(1)
    side = random.integers(0, 2 * (len(mesh[1]) + 1), 5000)
    positions = random.uniform(-1, 1, (5000, 3)).astype(np.float32)
    faces = faces_of(occluders)
    of_hits = CellKeys(faces, GRID).of_hits(side, positions)
    keys = np.unique(of_hits)
    with Workers(2) as workers:
        every, half = (Cells(faces, GRID, some, workers) for some in (keys, keys[::2]))
    np.testing.assert_array_equal(keys[every.find(side, positions)], of_hits)
    found = half.find(side, positions)
    is_kept = np.isin(of_hits, keys[::2])
    np.testing.assert_array_equal(found >= 0, is_kept)


def test_facing_is_the_nearest_of_26_and_turns_over():
    random = np.random.default_rng(2)
    normals = random.normal(size=(1000, 3))
    np.testing.assert_array_equal(facing_of(-normals), BACK_OF - facing_of(normals))
    np.testing.assert_array_equal(facing_of(3.0 * normals), facing_of(normals))
    code = facing_of(normals).astype(int)
    steps = np.stack((code // 9, code // 3 % 3, code % 3), axis=1) - 1
    cosine = (normals * steps).sum(axis=1) / np.linalg.norm(normals, axis=1) / np.linalg.norm(steps, axis=1)
    assert cosine.min() > 0.8


def test_memory_is_bounded_by_the_cells():
    """About 3 kB a wanted cell while the cache is built, however many points and rays there are."""
    mesh = bumpy()
    occluders, points = Occluders(*mesh), SurfacePoints(mesh[0], vertex_normals(*mesh))
    tracemalloc.start()
    cache = finish(build_light_cache(occluders, points, 1, extent=2.0))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    print(f"{cache.light.shape[1] - 1} cells for {FEWEST_CELLS}: {peak / FEWEST_CELLS:.0f} bytes each at the peak")
    assert peak < 3500 * FEWEST_CELLS
    assert cache.light.shape[1] < 2 * FEWEST_CELLS
