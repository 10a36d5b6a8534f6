# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups ``AO Field <object>`` rendered in Cycles and EEVEE against core.ao_field."""

from dataclasses import replace

import bpy
import numpy as np
import pytest

from .fields import random_field, smooth_field, with_volume
from .receivers import Plates, render_plates


def centred(field):
    """The same about the object's origin."""
    return replace(field, centre=np.zeros(3))


def group_with(modules, obj, field, proportions=(1, 1, 1)):
    group, atlas, volumes = modules
    tree = group.ensure(obj, field.volume is not None)
    volume = None
    if field.volume is not None:
        low, high = field.volume.low, field.volume.high
        volume = group.ShownVolume(image_of(volumes.volume_pixels(field.volume)), tuple(low), tuple(high - low))
    image = image_of(atlas.atlas_pixels(field))
    group.show(tree, image, group.field_numbers(field), tuple(field.centre), proportions, volume)
    return tree


def image_of(pixels):
    image = bpy.data.images.new("Atlas", pixels.shape[1], pixels.shape[0], alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    image.use_half_precision = False
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def render(group, plates, folder, engine="CYCLES", output="Occlusion", frame=1):
    def connect(tree):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        return node.outputs[output]

    return render_plates(plates, connect, folder, engine, frame)


def expected(field, obj, plates, proportions=(1, 1, 1)):
    """core's A; receivers into the object's space by its matrix, normals by the transpose's."""
    bpy.context.view_layer.update()
    matrix = np.diag((*proportions, 1)) @ np.linalg.inv(np.array(obj.matrix_world, float))
    positions = plates.positions() @ matrix[:3, :3].T + matrix[:3, 3]
    normals = plates.normals() @ np.linalg.inv(matrix[:3, :3])
    return field.occlusion(positions, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def transformed(obj, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    obj.location, obj.rotation_euler, obj.scale = location, rotation, scale
    bpy.context.view_layer.update()


def test_cycles(modules, prop, tmp_path):
    rng = np.random.default_rng(1)
    field = random_field(rng)
    plates = Plates.random(rng, 96, 6.0)
    found = render(group_with(modules, prop, field), plates, tmp_path)
    error = np.abs(found - expected(field, prop, plates))
    print(f"AO Field in Cycles against core.ao_field: largest {error.max():.1e}, rms {np.sqrt((error**2).mean()):.1e}")
    assert error.max() < 1e-5


@pytest.mark.parametrize("n", [8, 9, 64])
def test_resolutions(modules, prop, tmp_path, n):
    """A smooth field, as objects have: at 64 x 64 neighbours that differ at random would magnify rounding."""
    rng = np.random.default_rng(2)
    field = smooth_field(rng, n)
    plates = Plates.random(rng, 64, 6.0)
    error = np.abs(render(group_with(modules, prop, field), plates, tmp_path) - expected(field, prop, plates))
    print(f"AO Field, {n} x {n}: largest {error.max():.1e}")
    assert error.max() < 1e-5


def seams():
    """Flat plates in whose directions two coordinates are equal, and all three at four plates: edges and corners of
    the cube, with their neighbours on both sides."""
    return Plates.flat(65, 6.5, 0.8)


def test_edges_and_corners(modules, prop, tmp_path):
    field = centred(random_field(np.random.default_rng(3)))
    plates = seams()
    x, y, z = np.abs(plates.positions()).T
    on_edges = np.isclose(x, y) | np.isclose(x, z) | np.isclose(y, z)
    assert np.count_nonzero(on_edges) > 150
    assert np.count_nonzero(np.isclose(x, y) & np.isclose(y, z)) == 4
    error = np.abs(render(group_with(modules, prop, field), plates, tmp_path) - expected(field, prop, plates))
    print(f"AO Field at edges and corners in Cycles: largest {error[on_edges].max():.1e}, all {error.max():.1e}")
    assert error.max() < 1e-5


@pytest.mark.parametrize("plates", ["anywhere", "edges and corners"])
def test_eevee(modules, prop, tmp_path, eevee, plates):
    rng = np.random.default_rng(4)
    field = centred(random_field(rng))
    plates = Plates.random(rng, 96, 6.0) if plates == "anywhere" else seams()
    found = render(group_with(modules, prop, field), plates, tmp_path, "EEVEE")
    error = np.abs(found - expected(field, prop, plates))
    print(f"AO Field in EEVEE against core.ao_field: largest {error.max():.1e}, rms {np.sqrt((error**2).mean()):.1e}")
    assert error.max() < 2e-3


PLACED = {
    "moved": {"location": (0.4, -0.7, 0.3)},
    "turned": {"rotation": (0.3, -1.1, 2.4)},
    "scaled": {"scale": (1.7, 1.7, 1.7)},
    "all": {"location": (0.2, 0.3, -0.4), "rotation": (-0.8, 0.5, 1.2), "scale": (0.6, 0.6, 0.6)},
    "mirrored": {"rotation": (0.3, -1.1, 2.4), "scale": (1.2, -1.2, 1.2)},
    "mirrored in all": {"rotation": (0.3, -1.1, 2.4), "scale": (-1, -1, -1)},
}


@pytest.mark.parametrize("place", PLACED.values(), ids=PLACED)
def test_follows_its_object(modules, prop, tmp_path, place, engine):
    """Without another bake."""
    rng = np.random.default_rng(5)
    field = smooth_field(rng, 16)
    group = group_with(modules, prop, field)
    transformed(prop, **place)
    plates = Plates.random(rng, 32, 5.0)
    error = np.abs(render(group, plates, tmp_path, engine) - expected(field, prop, plates))
    assert error.max() < (2e-3 if engine == "EEVEE" else 1e-5)


def test_follows_its_parent(modules, prop, tmp_path):
    rng = np.random.default_rng(6)
    field = random_field(rng)
    group = group_with(modules, prop, field)
    parent = bpy.data.objects.new("Parent", None)
    bpy.context.scene.collection.objects.link(parent)
    transformed(parent, (0.3, 0.1, 0.2), (0.5, -0.4, 1.0), (1.3, 1.3, 1.3))
    prop.parent = parent
    transformed(prop, (0.1, -0.2, 0.3), (1.0, 0.6, -0.3), (0.8, 0.8, 0.8))
    plates = Plates.random(rng, 32, 5.0)
    error = np.abs(render(group, plates, tmp_path) - expected(field, prop, plates))
    assert error.max() < 1e-5


def test_follows_an_animation(modules, prop, tmp_path):
    """The drivers are evaluated at each frame."""
    rng = np.random.default_rng(7)
    field = smooth_field(rng, 16)
    group = group_with(modules, prop, field)
    plates = Plates.random(rng, 24, 5.0)
    for frame, angle in ((1, 0.0), (11, 2.0)):
        prop.rotation_euler = (angle, -angle, 0.5 * angle)
        prop.location = (0.2 * angle, 0, 0)
        prop.keyframe_insert("rotation_euler", frame=frame)
        prop.keyframe_insert("location", frame=frame)
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        found = render(group, plates, tmp_path, frame=frame)
        assert np.abs(found - expected(field, prop, plates)).max() < 1e-5


def test_hidden_in_renders_it_casts_nothing(modules, prop, tmp_path):
    """Now and then, as an animated prop comes and goes."""
    rng = np.random.default_rng(15)
    field = smooth_field(rng, 16)
    group = group_with(modules, prop, field)
    plates = Plates.random(rng, 24, 5.0)
    for frame, hidden in ((1, False), (2, True), (3, False)):
        prop.hide_render = hidden
        prop.keyframe_insert("hide_render", frame=frame)
    shown = expected(field, prop, plates)
    for frame, wanted in ((1, shown), (2, 0 * shown), (3, shown)):
        bpy.context.scene.frame_set(frame)
        assert np.abs(render(group, plates, tmp_path, frame=frame) - wanted).max() < 1e-5


def test_uneven_scale_that_it_was_baked_for(modules, prop, tmp_path):
    """The field's space is the object's with its proportions."""
    rng = np.random.default_rng(8)
    field = random_field(rng)
    proportions = np.array((2.0, 1.0, 0.5))
    group = group_with(modules, prop, field, tuple(proportions))
    transformed(prop, (0.1, 0.2, 0.3), (0.3, -1.1, 2.4), tuple(1.4 * proportions))
    plates = Plates.random(rng, 48, 6.0)
    error = np.abs(render(group, plates, tmp_path) - expected(field, prop, plates, proportions))
    assert error.max() < 1e-5


def test_volume(modules, prop, tmp_path, engine):
    """Within the hull and about it; the box's sides lie in what is looked at. Then without it again."""
    rng = np.random.default_rng(14)
    plain = smooth_field(rng, 16)
    field = with_volume(rng, plain)
    plates = Plates.random(rng, 64, 1.6)
    error = np.abs(render(group_with(modules, prop, field), plates, tmp_path, engine) - expected(field, prop, plates))
    print(f"AO Field with its volume in {engine}: largest {error.max():.1e}, rms {np.sqrt((error**2).mean()):.1e}")
    assert error.max() < (2e-3 if engine == "EEVEE" else 1e-5)
    if engine == "CYCLES":
        without = render(group_with(modules, prop, plain), plates, tmp_path)
        assert np.abs(without - expected(plain, prop, plates)).max() < 1e-5


def test_pictures_of_older_bakes(modules, prop, tmp_path):
    """They have 0 for d and for e, which was 1."""
    rng = np.random.default_rng(15)
    field = smooth_field(rng, 16)
    none = np.zeros_like(field.d)
    group = group_with(modules, prop, replace(field, d=none, e=none))
    plates = Plates.random(rng, 32, 5.0)
    error = np.abs(render(group, plates, tmp_path) - expected(replace(field, d=none, e=none + 1), prop, plates))
    assert error.max() < 1e-5


def test_connected_normal_counts(modules, prop, tmp_path):
    """Of any length; here against that of the plates."""
    rng = np.random.default_rng(9)
    field = random_field(rng)
    group = group_with(modules, prop, field)
    plates = Plates.flat(32, 5.0, 0.7)
    normal = np.array((0.6, -1.0, -0.3))

    def connect(tree):
        node = tree.nodes.new("ShaderNodeGroup")
        node.node_tree = group
        node.inputs["Normal"].default_value = normal
        return node.outputs["Occlusion"]

    normals = np.broadcast_to(normal / np.linalg.norm(normal), (32 * 32, 3))
    found = render_plates(plates, connect, tmp_path)
    assert np.abs(found - field.occlusion(plates.positions(), normals)).max() < 1e-5


def test_many_fields_in_one_material(modules, tmp_path):
    """Eight groups, multiplied."""
    rng = np.random.default_rng(13)
    plates, groups, product = Plates.random(rng, 32, 6.0), [], 1.0
    for index in range(8):
        obj = bpy.data.objects.new(f"Prop {index}", None)
        bpy.context.scene.collection.objects.link(obj)
        transformed(obj, rng.uniform(-2, 2, 3), rng.uniform(-3, 3, 3))
        field = smooth_field(rng, 8)
        groups.append(group_with(modules, obj, field))
        product *= 1 - expected(field, obj, plates)

    def connect(tree):
        found = None
        for group in groups:
            node = tree.nodes.new("ShaderNodeGroup")
            node.node_tree = group
            if found is None:
                found = node.outputs["AO"]
                continue
            times = tree.nodes.new("ShaderNodeMath")
            times.operation = "MULTIPLY"
            tree.links.new(found, times.inputs[0])
            tree.links.new(node.outputs["AO"], times.inputs[1])
            found = times.outputs[0]
        return found

    assert np.abs(render_plates(plates, connect, tmp_path) - product).max() < 1e-5


def test_ao_is_what_is_left(modules, prop, tmp_path):
    rng = np.random.default_rng(10)
    group = group_with(modules, prop, random_field(rng))
    plates = Plates.random(rng, 16, 5.0)
    ao, occlusion = (render(group, plates, tmp_path, output=name) for name in ("AO", "Occlusion"))
    np.testing.assert_allclose(ao + occlusion, 1, atol=1e-6)


def test_the_centre_itself(modules, prop, tmp_path):
    """A0; nothing is divided by 0."""
    field = centred(random_field(np.random.default_rng(11)))
    plates = Plates.flat(5, 1.0, 0.0)
    middle = 12
    np.testing.assert_array_equal(plates.positions()[middle], 0)
    found = render(group_with(modules, prop, field), plates, tmp_path)
    assert found[middle] == pytest.approx(field.a0, abs=1e-6)


def test_outside_r_far_there_is_none(modules, prop, tmp_path):
    field = random_field(np.random.default_rng(12))
    found = render(group_with(modules, prop, field), Plates.flat(8, 2.0, -4.3), tmp_path)
    np.testing.assert_array_equal(found, 0)
