# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles tests its bakes with, as scenes of ours, in numbers: faces that share no vertices, layouts of thin
triangles, cages, colour attributes.

Elsewhere: margins across seams (Adjacent Faces) against rays in test_seams.py; the rasteriser against geometry, place
by place, in tests/core/test_rasterise.py; loose triangles at vertices in test_vertex_values.py; where rays of cages and
their lengths end in test_high_to_low.py; a texture of Cycles' in test_cycles.py.
"""

from functools import cache

import bpy
import numpy as np
import pytest

from .bakes import attribute, bake, change_settings, f0, pixels, reports, rms, select
from .closed_forms import faces_towards, form_factor
from .meshes import add_mesh, add_uv_map, apply_modifiers, box, plate, positions, read

pytestmark = pytest.mark.usefixtures("fitted")

TEXTURE = {"target": "TEXTURE", "margin": 0, "use_material_nodes": False}
SAMPLES = 1024


def image_f0(obj):
    return pixels(bpy.data.images[f"{obj.name} Multibounce AO"])[..., 0].astype(float)


def covered(obj):
    return pixels(bpy.data.images[f"{obj.name} Multibounce AO"]).any(axis=2)


def split(obj):
    """No two faces share a vertex from here on; the normals stay, as custom ones."""
    normals = read(obj.data.corner_normals, "vector", 3)
    obj.modifiers.new("Split", "EDGE_SPLIT").split_angle = 0
    apply_modifiers(obj)
    obj.data.normals_split_custom_set(normals.tolist())
    assert len(obj.data.vertices) == len(obj.data.loops)


def mark_sharp(obj):
    obj.data.edges.foreach_set("use_edge_sharp", np.ones(len(obj.data.edges), bool))
    obj.data.update()


def floor_below_a_box():
    """The floor, and F0 (h, w) at the centres of its texels as 60 of them lie along each side."""
    floor, occluder = plate("Floor", half=2.0, steps=8), box(low=(-0.6, -0.6, 0.4), high=(0.5, 0.4, 1.2))
    faces = tuple(tuple(face.vertices) for face in occluder.data.polygons)
    return floor, open_part(tuple(map(tuple, positions(occluder))), faces)


@cache
def open_part(corners, faces):
    """F0 (60, 60) of the floor below the solid of ``faces``, by form factors."""
    t = (np.arange(60) + 0.5) / 15 - 2

    def seen(point):
        return 1 - sum(form_factor(point, (0, 0, 1), face) for face in faces_towards(point, np.array(corners), faces))

    return np.array([[seen((x, y, 0.0)) for x in t] for y in t])


def test_split_faces_of_a_floor():
    """Edges that run within texels: nothing is seen of them, whether faces share their vertices or not."""
    floor, expected = floor_below_a_box()
    cut = np.isin(np.arange(60), (np.arange(1, 8) * 7.5).astype(int))  # rows and columns with an edge inside or beside
    at_edges = cut[:, None] | cut
    found = []
    for name, change in (("whole", None), ("sharp", mark_sharp), ("split", split)):
        if change is not None:
            change(floor)
        bake(floor, **TEXTURE, samples=256, resolution=60)
        found.append(image_f0(floor))
        error = found[-1] - expected
        print(f"{name}: rms {rms(error[at_edges]):.4f} at edges, {rms(error[~at_edges]):.4f} elsewhere", end="; ")
        print(
            f"mean at edges {error[at_edges].mean():+.5f}, most off the whole {np.abs(found[-1] - found[0]).max():.1e}"
        )
        assert rms(error[at_edges]) < 0.006
        assert abs(error[at_edges].mean()) < 0.001
        np.testing.assert_allclose(found[-1], found[0], atol=1e-5)


def test_split_faces_of_a_ball():
    """From outside it sees all of the sky, from inside none: a slit would be a dark or a bright line."""
    for inward, seen in ((False, 1.0), (True, 0.0)):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, rotation=(0.3, 0.5, 0.7))
        obj = bpy.context.active_object
        if inward:
            obj.data.flip_normals()
        obj.data.shade_smooth()
        values = []
        for change in (None, split):
            if change is not None:
                change(obj)
            bake(obj, **TEXTURE, samples=256, resolution=100, occluders="SELF")
            values.append(image_f0(obj)[covered(obj)] if not inward else image_f0(obj))
            print(
                f"inward {inward}, {len(obj.data.vertices)} vertices: F0 {values[-1].min():.4f} {values[-1].max():.4f}"
            )
        assert len(values[1]) == len(values[0]) > 50
        for each in values:
            assert np.abs(each - seen).max() < 0.005


def test_a_sharp_edge_shows_no_line():
    """A strip around a convex corner over an infinite floor: its top sees all, its side half, up to the edge. The
    edge lies in the middle of a texel, which shows both."""
    strip = add_mesh(
        "Strip", [(0, 0, 5), (0, 1, 5), (1, 0, 5), (1, 1, 5), (1, 0, 4), (1, 1, 4)], [(0, 2, 3, 1), (2, 4, 5, 3)]
    )
    add_uv_map(strip.data, [(0, 0), (0, 1), (0.5, 0), (0.5, 1), (1, 0), (1, 1)])
    for change in (mark_sharp, split):
        change(strip)
        bake(strip, **TEXTURE, samples=256, resolution=31, use_ground_plane=True)
        error = image_f0(strip) - np.where(np.arange(31) < 15, 1.0, np.where(np.arange(31) > 15, 0.5, 0.75))
        print(f"{change.__name__}: rms {rms(error):.4f}, most {np.abs(error).max():.4f}")
        assert rms(error) < 0.004
        assert np.abs(error).max() < 0.02


def test_watertight_layout_of_thin_triangles():
    """1,600 triangles, all thinner than a texel, fan out from one place and tile the square: each texel is baked once,
    and shows its part of the floor."""
    floor, expected = floor_below_a_box()
    bpy.data.objects.remove(floor)
    t = np.linspace(-2, 2, 401)
    down, up, none = np.full_like(t, -2), np.full_like(t, 2), np.zeros_like(t)
    # From the whole border to a place off the middle.
    sides = [(t, down), (up, t), (-t, up), (down, -t)]
    border = np.concatenate([np.column_stack((*side, none))[:-1] for side in sides])
    hub = len(border)
    around = np.arange(hub)
    vertices = np.vstack((border, (0.137, -0.291, 0)))
    thin = add_mesh("Thin", vertices, np.column_stack((around, np.roll(around, -1), np.full(hub, hub))))
    add_uv_map(thin.data, (vertices[:, :2] + 2) / 4)
    (report,) = reports(thin, **TEXTURE, samples=256, resolution=60)
    error = image_f0(thin) - expected
    print(f"{report.points} of 3600 texels, rms {rms(error):.4f}, most {np.abs(error).max():.4f}, {report.warnings}")
    assert report.points == covered(thin).sum() == 60 * 60
    assert report.warnings == []
    assert rms(error) < 0.006
    assert np.abs(error).max() < 0.03


def use_cycles():
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = SAMPLES
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.world = bpy.data.worlds.new("World")
    scene.world.light_settings.distance = 1e5


def cycles_onto(low, high, size, **options):
    """F0 (h, w) of Cycles' selected-to-active bake."""
    image = bpy.data.images.new("Cycles", size, size, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    material = bpy.data.materials.new("Cycles")
    if material.node_tree is None:  # before Blender 5.0
        material.use_nodes = True
    material.node_tree.nodes.active = material.node_tree.nodes.new("ShaderNodeTexImage")
    material.node_tree.nodes.active.image = image
    low.data.materials.clear()
    low.data.materials.append(material)
    select(low, high)
    assert bpy.ops.object.bake(type="AO", use_selected_to_active=True, margin=0, **options) == {"FINISHED"}
    return pixels(image)[..., 0].astype(float)


def test_cages():
    """Hills onto a bowed plate, rays along its normals, then from a cage that slants them."""
    size = 32
    high, low, cage = plate("High", half=1.6, steps=48), plate("Low", steps=4), plate("Cage", steps=4)
    x, y, _ = positions(high).T
    hills = np.column_stack((x, y, 0.25 * np.sin(7 * x) * np.cos(5 * y)))
    high.data.vertices.foreach_set("co", hills.astype(np.float32).ravel())
    x, y, _ = positions(low).T
    bowed = np.column_stack((x, y, -0.1 * (x**2 + y**2)))
    low.data.vertices.foreach_set("co", bowed.astype(np.float32).ravel())
    slanted = bowed * (1.3, 1.3, 1) + np.array((0.2, 0, 0.6))
    cage.data.vertices.foreach_set("co", slanted.astype(np.float32).ravel())
    for obj in (high, low, cage):
        obj.data.update()
    cage.hide_render = True
    use_cycles()
    change_settings(use_selected_to_active=True)
    images = []
    for name, ours, theirs in (
        ("extrusion", {"cage_extrusion": 0.6, "cage_object": None}, {"cage_extrusion": 0.6}),
        ("cage", {"cage_extrusion": 0.0, "cage_object": cage}, {"use_cage": True, "cage_object": cage.name}),
    ):
        expected = cycles_onto(low, high, size, **theirs)
        bake(low, high, **TEXTURE, samples=SAMPLES, resolution=size, **ours)
        difference = image_f0(low) - expected
        images.append(image_f0(low))
        print(f"{name}: mean {difference.mean():+.4f}, rms {rms(difference):.4f}, most {np.abs(difference).max():.3f}")
        assert np.ptp(expected) > 0.4
        assert abs(difference.mean()) < 0.005
        assert rms(difference) < 0.02
    print(f"between the two: rms {rms(images[1] - images[0]):.3f}")
    assert rms(images[1] - images[0]) > 0.05


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
def test_colour_attributes(domain):
    """A smooth floor has one value a vertex, flat hills have one a corner. Cycles bakes corners, and averages them to
    points."""
    obj = plate("Floor", half=2.0, steps=8)
    box(low=(-0.6, -0.6, 0.4), high=(0.5, 0.4, 1.2))
    if domain == "CORNER":
        x, y, _ = positions(obj).T
        relief = np.column_stack((x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)))
        obj.data.vertices.foreach_set("co", relief.astype(np.float32).ravel())
        obj.modifiers.new("Triangulate", "TRIANGULATE")  # bent quads are not flat
        apply_modifiers(obj)
        obj.data.shade_flat()
    use_cycles()
    obj.data.color_attributes.active_color = obj.data.color_attributes.new("Cycles", "FLOAT_COLOR", domain)
    obj.data.materials.append(bpy.data.materials.new("Floor"))
    select(obj)
    assert bpy.ops.object.bake(type="AO", target="VERTEX_COLORS") == {"FINISHED"}
    expected = attribute(obj, "Cycles")[:, 0]
    bake(obj, samples=SAMPLES, use_material_nodes=False)
    assert obj.data.attributes["Multibounce AO"].domain == domain
    difference = f0(obj) - expected
    print(f"{domain}: mean {difference.mean():+.4f}, rms {rms(difference):.4f}, most {np.abs(difference).max():.3f}")
    assert np.ptp(expected) > 0.4
    assert abs(difference.mean()) < 0.005
    assert rms(difference) < 0.02
