# SPDX-License-Identifier: GPL-3.0-or-later
"""`apply_field`: the nodes in the receivers' materials, what they say, and that `clear` takes them out again."""

import bpy
import numpy as np
import pytest

from .bakes import bake, change_settings, clear, operators, select
from .materials import bsdf, material, source, textured_material
from .meshes import add, plate
from .props import DRAFT, FIELD, RECEIVES, apply_field, bake_field, ball, fields_of, press_apply
from .refusals import error_of
from .snapshot import differences, snapshot


def mix_of(owner):
    """The node that multiplies the base colour: its inputs A and B."""
    node = source(bsdf(owner).inputs["Base Color"]).node
    assert (node.bl_idname, node.blend_type) == ("ShaderNodeMix", "MULTIPLY")
    sockets = {socket.identifier: socket for socket in node.inputs}
    assert sockets["Factor_Float"].default_value == 1
    return sockets["A_Color"], sockets["B_Color"]


@pytest.fixture
def prop():
    obj = ball()
    bake_field(obj)
    return obj


def test_base_colour_times_ao(prop):
    floor = plate("Floor", location=(0, 0, -1))
    floor.data.materials.append(textured_material())
    texture = source(bsdf(floor.active_material).inputs["Base Color"])
    press_apply(prop, floor)
    base_color, ao = mix_of(floor.active_material)
    assert source(base_color) == texture
    assert source(ao).name == "AO" and source(ao).node.node_tree == bpy.data.node_groups["AO Field Ball"]


def test_plain_colour(prop):
    floor = plate("Floor")
    floor.data.materials.append(material(colour=(0.1, 0.2, 0.3, 1)))
    press_apply(prop, floor)
    np.testing.assert_allclose(mix_of(floor.active_material)[0].default_value, (0.1, 0.2, 0.3, 1))


def test_many_receivers(prop):
    several = plate("Several")
    for each in (material("One"), None, material("Two")):
        several.data.materials.append(each)
    without = plate("Without")
    empty_slot = plate("Empty slot")
    empty_slot.data.materials.append(None)
    curve = add("Curve", bpy.data.curves.new("Curve", "CURVE"))
    assert apply_field(prop, several, without, empty_slot, curve) == []
    for obj in (several, without, empty_slot, curve):
        assert RECEIVES in obj
        materials = [slot.material for slot in obj.material_slots if slot.material]
        assert materials
        assert all(fields_of(each) == ["AO Field Ball"] for each in materials)


def test_applied_twice_is_applied_once(prop):
    floor = plate("Floor")
    floor.data.materials.append(material())
    for _ in range(2):
        press_apply(prop, floor)
    assert fields_of(floor.active_material) == ["AO Field Ball"]
    assert [n.bl_idname for n in floor.active_material.node_tree.nodes].count("ShaderNodeMix") == 1


def test_several_fields_multiply(prop):
    """Their product, in whatever order: followed from the shader back to the groups."""
    floor = plate("Floor")
    floor.data.materials.append(material())
    others = [ball(name, location=(3 * i, 0, 0)) for i, name in enumerate(("Two", "Three"), 1)]
    for obj in others:
        bake_field(obj)
    for obj in (prop, *others):
        press_apply(obj, floor)
    assert factors(mix_of(floor.active_material)[1]) == ["AO Field Ball", "AO Field Three", "AO Field Two"]
    clear(others[0])
    assert factors(mix_of(floor.active_material)[1]) == ["AO Field Ball", "AO Field Three"]


def factors(socket):
    """Names of the groups whose AO the value of ``socket`` is the product of."""
    output = source(socket)
    if output.node.bl_idname == "ShaderNodeGroup":
        assert output.name == "AO"
        return [output.node.node_tree.name]
    assert (output.node.bl_idname, output.node.operation) == ("ShaderNodeMath", "MULTIPLY")
    return sorted(name for each in output.node.inputs[:2] for name in factors(each))


def test_two_shaders_in_a_material(prop):
    floor = plate("Floor")
    double = textured_material()
    second = double.node_tree.nodes.new("ShaderNodeBsdfPrincipled")
    floor.data.materials.append(double)
    press_apply(prop, floor)
    ends = [
        source(node.inputs["Base Color"]).node
        for node in double.node_tree.nodes
        if node.bl_idname == "ShaderNodeBsdfPrincipled"
    ]
    assert len(set(ends)) == 2 and {node.bl_idname for node in ends} == {"ShaderNodeMix"}
    assert second.inputs["Base Color"].is_linked


def test_nodes_that_the_artist_put_behind(prop):
    floor = plate("Floor")
    floor.data.materials.append(material())
    press_apply(prop, floor)
    tree, shader = floor.active_material.node_tree, bsdf(floor.active_material)
    gamma = tree.nodes.new("ShaderNodeGamma")
    tree.links.new(source(shader.inputs["Base Color"]), gamma.inputs["Color"])
    tree.links.new(gamma.outputs["Color"], shader.inputs["Base Color"])
    press_apply(prop, floor)
    assert [n.bl_idname for n in tree.nodes].count("ShaderNodeMix") == 1
    clear(floor)
    assert source(shader.inputs["Base Color"]) == gamma.outputs["Color"]
    np.testing.assert_allclose(gamma.inputs["Color"].default_value, (0.8, 0.4, 0.2, 1))


def test_shared_material_is_told(prop):
    floor, wall, other = (plate(name, location=(9 * i, 0, 0)) for i, name in enumerate(("Floor", "Wall", "Other")))
    paint = material()
    for obj in (floor, wall, other, prop):
        obj.data.materials.append(paint)
    (warning,) = apply_field(prop, floor, wall)
    assert "'Paint'" in warning and "'Other'" in warning and "'Ball'" in warning and "darkens itself" in warning
    assert "'Floor'" not in warning and "single-user" in warning


def test_bad_receivers_are_told_and_the_rest_is_done(prop):
    floor, bare = plate("Floor"), plate("Bare")
    bare.data.materials.append(material("No shader"))
    bare.active_material.node_tree.nodes.clear()
    lamp = add("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    warnings = apply_field(prop, bare, lamp, floor)
    assert [w.split("'")[1] for w in warnings] == ["Bare", "Lamp"]
    assert "no Principled BSDF" in warnings[0] and "select meshes" in warnings[1]
    assert fields_of(floor.active_material) and RECEIVES not in bare and RECEIVES not in lamp
    select(prop, lamp)
    assert "Lamp" in error_of(bpy.ops.multibounce_ao.apply_field)


def test_no_field_or_no_receiver_no_button(prop):
    floor = plate("Floor")
    select(floor, prop)
    assert not bpy.ops.multibounce_ao.apply_field.poll()
    select(prop)
    assert not bpy.ops.multibounce_ao.apply_field.poll()
    select(prop, floor)
    assert bpy.ops.multibounce_ao.apply_field.poll()
    bpy.data.images.remove(prop[FIELD]["image"])
    assert not bpy.ops.multibounce_ao.apply_field.poll()


def test_uneven_scale_since_the_bake_is_told(prop):
    floor = plate("Floor")
    assert apply_field(prop, floor) == []
    prop.scale = (2, 2, 2)
    assert apply_field(prop, floor) == []
    prop.scale = (2, 2, 1)
    bpy.context.view_layer.update()
    (warning,) = apply_field(prop, floor)
    assert warning.startswith("Object 'Ball' ") and "bake it again" in warning


def test_linked_duplicates_cast_each_where_it_is(prop):
    twin = add("Twin", prop.data, location=(3, 0, 0))
    bake_field(prop)
    floor = plate("Floor")
    press_apply(prop, floor)
    press_apply(twin, floor)
    assert fields_of(floor.active_material) == ["AO Field Ball", "AO Field Twin"]
    groups = [bpy.data.node_groups[f"AO Field {name}"] for name in ("Ball", "Twin")]
    assert [group.nodes["Place"].object for group in groups] == [prop, twin]
    assert groups[0].nodes["Maps 1"].image == groups[1].nodes["Maps 1"].image


def test_duplicate_made_after_the_bake(prop):
    twin = prop.copy()
    bpy.context.scene.collection.objects.link(twin)
    twin.name = "Twin"
    floor = plate("Floor")
    press_apply(twin, floor)
    assert bpy.data.node_groups["AO Field Twin"].nodes["Place"].object == twin
    assert bpy.data.node_groups["AO Field Ball"].nodes["Place"].object == prop


def test_baked_again_receivers_follow(prop):
    floor = plate("Floor")
    press_apply(prop, floor)
    bake_field(prop, field_resolution=10)
    assert fields_of(floor.active_material) == ["AO Field Ball"]
    assert bpy.data.node_groups["AO Field Ball"].nodes["Maps 1"].image.size[1] == 4 * 12


MATERIALS = {
    "none": [],
    "empty slot": [None],
    "plain": [material],
    "textured": [textured_material],
    "several": [lambda: material("One"), None, textured_material],
}


@pytest.mark.parametrize("which", ["receiver", "occluder", "both"])
@pytest.mark.parametrize("materials", MATERIALS.values(), ids=MATERIALS)
def test_clear_puts_everything_back(materials, which):
    obj, floor = ball(), plate("Floor")
    for make in materials:
        floor.data.materials.append(make and make())
    select(*((floor,) if which == "receiver" else (obj,)), *((floor,) if which == "both" else ()))
    if which == "receiver":
        bake_field(obj)
        select(floor)
        before = snapshot()
    else:
        change_settings(**DRAFT)
        before = snapshot()
        bake_field(obj)
    apply_field(obj, floor)
    clear(*{"receiver": (floor,), "occluder": (obj,), "both": (obj, floor)}[which])
    cap = bpy.data.node_groups["Spherical Cap Occlusion"]
    if which != "receiver" and not bpy.data.user_map(subset=[cap])[cap]:
        bpy.data.node_groups.remove(cap)
    assert differences(before, snapshot()) == []


def test_clear_keeps_what_other_receivers_show(prop):
    floor, wall = plate("Floor"), plate("Wall", location=(9, 0, 0))
    paint = material()
    for obj in (floor, wall):
        obj.data.materials.append(paint)
    apply_field(prop, floor, wall)
    clear(floor)
    assert fields_of(paint) == ["AO Field Ball"]
    clear(wall)
    assert fields_of(paint) == []


@pytest.mark.parametrize("purged", [False, True])
def test_field_of_a_deleted_object_goes_with_the_next_step(prop, purged):
    other, third = ball("Other", location=(3, 0, 0)), ball("Third", location=(6, 0, 0))
    floor = plate("Floor")
    floor.data.materials.append(material())
    for obj in (other, third):
        bake_field(obj)
    for obj in (prop, other):
        press_apply(obj, floor)
    select(prop)
    if purged:
        bpy.data.objects.remove(prop)
    else:
        bpy.ops.object.delete()
    press_apply(third, floor)
    assert factors(mix_of(floor.active_material)[1]) == ["AO Field Other", "AO Field Third"]
    select(other)
    bpy.ops.object.delete()
    clear(third)
    assert fields_of(floor.active_material) == [] and len(floor.active_material.node_tree.nodes) == 2


def test_clear_of_a_curve(prop):
    curve = add("Curve", bpy.data.curves.new("Curve", "CURVE"))
    apply_field(prop, curve)
    clear(curve)
    assert not curve.material_slots and RECEIVES not in curve


@pytest.mark.parametrize("bounces", ["FITTED", "BAKED"])
@pytest.mark.parametrize("materials", [[], [material]], ids=["none", "plain"])
def test_beside_a_bake_of_the_receiver(prop, bounces, materials):
    """Baked first: the field darkens what the bake's group gives. Cleared, nothing is left of either."""
    floor = plate("Floor")
    for make in materials:
        floor.data.materials.append(make())
    select(floor)
    bpy.context.scene.multibounce_ao.bounces = bounces
    bpy.context.scene.multibounce_ao.samples = 1
    before = snapshot()
    bake(floor, samples=1)
    apply_field(prop, floor)
    base_color, _ = mix_of(floor.active_material)
    assert source(base_color).name == "Color"
    clear(floor)
    for tree, users in bpy.data.user_map(subset=list(bpy.data.node_groups)).items():
        if not users and "Multibounce" in tree.name:
            bpy.data.node_groups.remove(tree)
    assert differences(before, snapshot()) == []


@pytest.mark.parametrize("make", [material, textured_material])
@pytest.mark.parametrize("baked_first", [True, False], ids=["bake, field", "field, bake"])
@pytest.mark.parametrize("field_goes_first", [True, False], ids=["field goes", "bake goes"])
def test_bake_and_field_come_and_go_in_any_order(prop, fitted, make, baked_first, field_goes_first):
    """The bake's group has the plain base colour and the field multiplies last, whichever came first; each leaves the
    other as if it had been alone."""
    floor = plate("Floor")
    floor.data.materials.append(make(colour=(0.1, 0.2, 0.3, 1)) if make is material else make())
    paint, base = floor.active_material, bsdf(floor.active_material).inputs["Base Color"]
    plain = source(base)
    steps = [lambda: bake(floor, samples=1), lambda: press_apply(prop, floor)]
    for step in steps if baked_first else reversed(steps):
        step()
    group_color = source(mix_of(paint)[0])
    assert (group_color.name, group_color.node.node_tree.name) == ("Color", "Multibounce AO Fit")
    assert_fed_by(group_color.node.inputs["Base Color"], plain)
    assert fields_of(paint) == ["AO Field Ball"]
    if field_goes_first:
        clear(prop)
        assert fields_of(paint) == [] and source(base) == group_color
        clear(floor)
    else:
        operators("material_nodes").unplug(paint)
        assert_fed_by(mix_of(paint)[0], plain)
        clear(prop)
    assert_fed_by(base, plain)
    assert len(paint.node_tree.nodes) == (2 if plain is None else 3)


def assert_fed_by(socket, output):
    """By ``output``, or where that is None by the colour alone."""
    assert source(socket) == output
    if output is None:
        np.testing.assert_allclose(socket.default_value, (0.1, 0.2, 0.3, 1), rtol=1e-6)


@pytest.mark.parametrize("baked_first", [True, False], ids=["bake, field", "field, bake"])
@pytest.mark.parametrize("mesh_is_shared", [False, True])
def test_material_made_for_both_goes_with_the_last(fitted, baked_first, mesh_is_shared):
    floor = plate("Floor")
    floors = [floor, add("Twin", floor.data, location=(9, 0, 0))] if mesh_is_shared else [floor]
    obj = ball()
    change_settings(**DRAFT)
    select(*floors)
    before = snapshot()
    bake_field(obj)
    steps = [lambda: bake(*floors, samples=DRAFT["samples"]), lambda: apply_field(obj, *floors)]
    for step in steps if baked_first else reversed(steps):
        step()
    clear(obj)
    assert len(floor.material_slots) == 1
    clear(*floors)
    for tree, users in bpy.data.user_map(subset=list(bpy.data.node_groups)).items():
        if not users:
            bpy.data.node_groups.remove(tree)
    assert differences(before, snapshot()) == []


@pytest.mark.skipif(bpy.app.version >= (5, 0, 0), reason="since 5.0 the nodes of a material are always on")
@pytest.mark.parametrize("field_goes_first", [True, False])
def test_nodes_that_were_off_go_off_with_the_last(prop, fitted, field_goes_first):
    floor = plate("Floor")
    paint = bpy.data.materials.new("Paint")
    floor.data.materials.append(paint)
    bake(floor)
    press_apply(prop, floor)
    steps = [lambda: clear(prop), lambda: operators("material_nodes").unplug(paint)]
    for step in steps if field_goes_first else reversed(steps):
        assert paint.use_nodes
        step()
    assert not paint.use_nodes


def test_radiosity_reads_the_base_colour_through_the_field(prop):
    floor = plate("Floor")
    floor.data.materials.append(material(colour=(0.1, 0.2, 0.3, 1)))
    press_apply(prop, floor)
    colour, warning = operators("base_color").read_base_color(floor.active_material)
    assert warning is None
    np.testing.assert_allclose(colour.offset, (0.1, 0.2, 0.3), rtol=1e-6)
