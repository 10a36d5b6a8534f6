# SPDX-License-Identifier: GPL-3.0-or-later
"""*Add Curve Nodes*: the curve of k_A in a material, fed from a bake or from the artist's own map."""

import bpy
import numpy as np
import pytest

from .bakes import MULTIBOUNCE_AO, attribute, bake, change_settings, clear, f0, pixels, select
from .materials import bsdf, group, material, source, textured_material
from .meshes import add, box, corner_vertices, plate, positions, read
from .refusals import error_of
from .snapshot import differences, snapshot
from .test_clear import forget_settings_and_unused_groups
from .test_materials import corner_values, diffuse_colour, under_a_box

RADIOSITY = "Multibounce Radiosity"


def add_curve(obj):
    select(obj)
    assert bpy.ops.multibounce_ao.add_curve_nodes() == {"FINISHED"}
    node = group(obj.active_material)
    assert node.node_tree.name == "Multibounce AO Curve"
    return node


def openness(node):
    return node.inputs["Openness"].default_value


def mean_of_blocked(k, area):
    """Mean of k, each weighted by its area and by 1 - k: what rays that are blocked end on."""
    return (area * (1 - k) * k).sum() / (area * (1 - k)).sum()


def vertex_areas(obj):
    """Of each vertex, a third of the triangles about it; of a mesh of flat quads in the xy plane."""
    mesh, at = obj.data, positions(obj)
    mesh.calc_loop_triangles()
    corner = corner_vertices(mesh)[read(mesh.loop_triangles, "loops", 3, np.int32)]
    a, b, c = np.moveaxis(at[corner], 1, 0)
    area = 0.5 * np.abs(np.cross((b - a)[:, :2], (c - a)[:, :2]))
    return np.bincount(corner.ravel(), np.repeat(area / 3, 3), minlength=len(at))


def textured_floor():
    floor = under_a_box()
    floor.data.materials.append(textured_material())
    return floor


def test_without_a_bake_the_ao_is_left_to_the_artist():
    floor = textured_floor()
    shader = bsdf(floor.active_material)
    texture = source(shader.inputs["Base Color"])
    node = add_curve(floor)
    assert source(shader.inputs["Base Color"]) == node.outputs["Color"]
    assert source(node.inputs["Base Color"]) == texture
    assert not node.inputs["AO"].is_linked and node.inputs["AO"].default_value == 1
    assert openness(node) == 0

    tree = floor.active_material.node_tree
    mine = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(mine.outputs[0], node.inputs["AO"])
    assert source(add_curve(floor).inputs["AO"]) == mine.outputs[0]


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
def test_from_a_vertex_bake(bounces):
    floor = textured_floor()
    shader = bsdf(floor.active_material)
    texture = source(shader.inputs["Base Color"])
    bake(floor, bounces=bounces, samples=256)
    node = add_curve(floor)
    assert source(shader.inputs["Base Color"]) == node.outputs["Color"]
    assert source(node.inputs["Base Color"]) == texture
    red = source(node.inputs["AO"])
    assert (red.name, red.node.bl_idname) == ("Red", "ShaderNodeSeparateColor")
    names = [n.attribute_name for n in floor.active_material.node_tree.nodes if n.bl_idname == "ShaderNodeAttribute"]
    assert names == [MULTIBOUNCE_AO]
    expected = mean_of_blocked(f0(floor), vertex_areas(floor))
    print(f"{bounces}: openness {openness(node):.6f} of {expected:.6f}")
    assert openness(node) == pytest.approx(expected, abs=1e-6)
    assert np.ptp(f0(floor)) > 0.1


def test_openness_of_face_corners_and_of_scaled_objects():
    """A value a corner: each is worth a third of its triangles, in the world."""
    crate = box("Crate", low=(-1, -1, -1), high=(1, 1, 1))
    crate.data.materials.append(material())
    crate.scale = (1, 2, 4)
    plate("Floor", half=5, location=(0, 0, -4.001))
    bake(crate, samples=64)
    k = attribute(crate)[:, 0]
    assert len(k) == 24
    crate.data.calc_loop_triangles()
    corner = read(crate.data.loop_triangles, "loops", 3, np.int32)
    a, b, c = np.moveaxis((positions(crate) * (1, 2, 4))[corner_vertices(crate.data)[corner]], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    expected = mean_of_blocked(k, np.bincount(corner.ravel(), np.repeat(area / 3, 3)))
    assert openness(add_curve(crate)) == pytest.approx(expected, abs=1e-6)


def test_from_an_image():
    """The plate's UV map fills the tile: all texels are worth the same. An island in a corner leaves the rest out."""
    floor = textured_floor()
    bake(floor, target="TEXTURE", resolution=64, samples=64)
    node = add_curve(floor)
    reader = source(source(node.inputs["AO"]).node.inputs[0]).node
    image = bpy.data.images["Floor Multibounce AO"]
    assert reader.image == image and source(reader.inputs["Vector"]).node.uv_map == "UVMap"
    k = pixels(image)[..., 0].astype(float)
    expected = mean_of_blocked(k, np.ones_like(k))
    print(f"openness {openness(node):.5f} of {expected:.5f}")
    assert openness(node) == pytest.approx(expected, abs=1e-4)

    layer = floor.data.uv_layers["UVMap"]
    layer.uv.foreach_set("vector", 0.5 * read(layer.uv, "vector", 2).ravel().astype(np.float32))
    bake(floor, target="TEXTURE", resolution=128, samples=64, margin=4)
    corner = pixels(bpy.data.images["Floor Multibounce AO"])[:64, :64, 0].astype(float)
    assert openness(add_curve(floor)) == pytest.approx(mean_of_blocked(corner, np.ones_like(corner)), abs=1e-4)


@pytest.mark.parametrize("target", ["VERTEX", "TEXTURE"])
def test_from_radiosity(target):
    """Its alpha is F0."""
    floor = textured_floor()
    bake(floor, bounces="RADIOSITY", target=target, resolution=32, samples=64)
    node = add_curve(floor)
    alpha = source(node.inputs["AO"])
    assert alpha.name == "Alpha"
    if target == "VERTEX":
        assert alpha.node.attribute_name == RADIOSITY
        expected = mean_of_blocked(attribute(floor, RADIOSITY)[:, 3], vertex_areas(floor))
    else:
        assert alpha.node.image == bpy.data.images[f"Floor {RADIOSITY}"]
        k = pixels(alpha.node.image)[..., 3].astype(float)
        expected = mean_of_blocked(k, np.ones_like(k))
    assert openness(node) == pytest.approx(expected, abs=1e-3)


def test_rendered_colour_is_that_of_the_curve():
    from core.multibounce import surface_curve

    floor = under_a_box()
    floor.data.materials.append(material(colour=(0.8, 0.4, 0.2, 1)))
    bake(floor, samples=256)
    node = add_curve(floor)
    rho = np.array([0.8, 0.4, 0.2])
    k = corner_values(floor, f0(floor))[:, None]
    expected = rho * surface_curve(k, openness(node), rho)
    error = np.abs(diffuse_colour(floor) - expected).max()
    print(f"largest difference of the rendered colour: {error:.1e}")
    assert error < 2e-3 and np.ptp(expected) > 0.1


@pytest.mark.parametrize("baked", [True, False])
def test_clear_takes_it_out(baked):
    floor = textured_floor()
    change_settings(samples=1)
    select(floor)
    before = snapshot()
    if baked:
        bake(floor, samples=1)
    add_curve(floor)
    assert differences(before, snapshot())
    clear(floor)
    forget_settings_and_unused_groups(before)
    assert differences(before, snapshot()) == []


def as_baked_and_as_curve(obj):
    yield group(obj.active_material)
    yield add_curve(obj)


def test_a_bake_puts_its_own_group_back():
    """What the artist linked and set stays where it is, whichever group is there."""
    floor = textured_floor()
    shader = bsdf(floor.active_material)
    texture = source(shader.inputs["Base Color"])
    add_curve(floor)
    group(floor.active_material).inputs["Irradiance"].default_value = (0.5, 0.25, 0.125, 1)
    names = []
    for bounces in ("FITTED", "BAKED", "RADIOSITY", "BAKED", "FITTED"):
        bake(floor, samples=1, bounces=bounces)
        for node in as_baked_and_as_curve(floor):
            names.append(node.node_tree.name)
            assert source(node.inputs["Base Color"]) == texture
            assert source(shader.inputs["Base Color"]) == node.outputs["Color"]
            assert not node.inputs["Irradiance"].is_linked
            assert tuple(node.inputs["Irradiance"].default_value) == (0.5, 0.25, 0.125, 1)
    assert set(names) == {"Multibounce AO Fit", "Multibounce AO", "Multibounce Radiosity", "Multibounce AO Curve"}
    # Texture, BSDF and output; the group, and what feeds it: attribute, the mix that shows meshes without it as open,
    # and F0 of it.
    assert len(floor.active_material.node_tree.nodes) == 8


def test_a_plain_colour_stays_the_base_colour():
    floor = under_a_box()
    floor.data.materials.append(material(colour=(0.1, 0.2, 0.3, 1)))
    for bounces in ("BAKED", "FITTED", "RADIOSITY"):
        bake(floor, samples=1, bounces=bounces)
        for node in as_baked_and_as_curve(floor):
            assert tuple(node.inputs["Base Color"].default_value) == pytest.approx((0.1, 0.2, 0.3, 1))
            assert tuple(node.inputs["Irradiance"].default_value) == (1, 1, 1, 1)


def test_of_a_material_that_several_objects_show():
    """One number for all of them, from all that are baked; one that is not is left out, and shows the others' curve."""
    floor, big = under_a_box(), plate("Big", half=3, location=(20, 0, 0))
    box("Roof", low=(19, -1, 0.2), high=(21, 1, 1))
    other = plate("Other", location=(50, 0, 0))
    shared = material()
    for obj in (floor, big, other):
        obj.data.materials.append(shared)
    bake(floor, big, samples=64)
    k, area = (np.concatenate([each(obj) for obj in (floor, big)]) for each in (f0, vertex_areas))
    expected = mean_of_blocked(k, area)
    for obj in (floor, other):
        node = add_curve(obj)
        assert obj.active_material == shared and openness(node) == pytest.approx(expected, abs=1e-6)
        assert source(node.inputs["AO"]).name == "Red"


def test_a_shared_material_is_copied_before_an_image_goes_in():
    floor, other = under_a_box(), plate("Other", location=(20, 0, 0))
    shared = material()
    for obj in (floor, other):
        obj.data.materials.append(shared)
    bake(floor, target="TEXTURE", resolution=8, use_material_nodes=False)
    add_curve(floor)
    assert other.active_material == shared and group(shared) is None


def test_where_all_is_open_nothing_asks_for_openness():
    floor = plate()
    floor.data.materials.append(material())
    bake(floor, samples=16)
    assert openness(add_curve(floor)) == 1


@pytest.mark.parametrize("lost", ["attribute", "image"])
def test_a_bake_that_was_removed_is_none(lost):
    floor = textured_floor()
    if lost == "attribute":
        bake(floor, samples=1, use_material_nodes=False)
        floor.data.attributes.remove(floor.data.attributes[MULTIBOUNCE_AO])
    else:
        bake(floor, samples=1, target="TEXTURE", resolution=8, use_material_nodes=False)
        bpy.data.images.remove(bpy.data.images["Floor Multibounce AO"])
    node = add_curve(floor)
    assert not node.inputs["AO"].is_linked and openness(node) == 0


def test_add_nodes_with_other_bounces_than_were_baked():
    """There is nothing to feed it from: it says so, and does not stumble."""
    floor = textured_floor()
    for target in ("VERTEX", "TEXTURE"):
        bake(floor, samples=1, target=target, resolution=8, bounces="BAKED", use_material_nodes=False)
        change_settings(bounces="RADIOSITY")
        assert bpy.ops.multibounce_ao.add_nodes() == {"FINISHED"}
        assert not group(floor.active_material).inputs["Radiosity"].is_linked


def test_when_it_cannot_be_pressed(tmp_path):
    poll = bpy.ops.multibounce_ao.add_curve_nodes.poll
    floor = plate()
    select(floor)
    assert not poll()
    assert "give it a material" in error_of(bpy.ops.multibounce_ao.add_curve_nodes)
    floor.data.materials.append(material())
    assert poll()
    bpy.ops.object.mode_set(mode="EDIT")
    assert not poll()
    assert "Object Mode" in error_of(bpy.ops.multibounce_ao.add_curve_nodes)
    bpy.ops.object.mode_set(mode="OBJECT")
    select(add("Empty", None))
    assert not poll()

    library = str(tmp_path / "library.blend")
    bpy.data.libraries.write(library, {material("Linked")})
    bpy.data.materials.remove(bpy.data.materials["Linked"])
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.materials = ["Linked"]
    floor.data.materials[0] = bpy.data.materials["Linked"]
    select(floor)
    assert not poll()
    assert "make it local" in error_of(bpy.ops.multibounce_ao.add_curve_nodes)


def test_a_material_without_a_shader():
    floor = plate()
    floor.data.materials.append(material("Empty"))
    floor.active_material.node_tree.nodes.clear()
    select(floor)
    assert "'Empty' has no Principled BSDF" in error_of(bpy.ops.multibounce_ao.add_curve_nodes)
    assert not floor.active_material.node_tree.nodes
