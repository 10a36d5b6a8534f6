# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups ``AO Field <object>`` as data-blocks: one an object, named after it, readable, driven."""

import bpy


def test_one_group_an_object(modules, prop):
    group = modules[0]
    tree = group.ensure(prop)
    assert tree.name == "AO Field Prop"
    assert group.ensure(prop) == group.group_of(prop) == tree
    assert group.object_of(tree) == prop
    assert {each.name for each in bpy.data.node_groups} == {"Spherical Cap Occlusion", "AO Field Prop"}


def test_the_name_follows_the_object(modules, prop):
    group = modules[0]
    tree = group.ensure(prop)
    prop.name = "Old"
    newer = bpy.data.objects.new("Prop", None)
    other = group.ensure(newer)
    assert other != tree
    assert (tree.name, other.name) == ("AO Field Old", "AO Field Prop")
    assert (group.object_of(tree), group.object_of(other)) == (prop, newer)


def test_long_names_are_kept_apart(modules, empty_scene):
    group = modules[0]
    objects = [bpy.data.objects.new("é" * 29 + letter, None) for letter in "ab"]
    trees = [group.ensure(obj) for obj in objects]
    assert trees[0] != trees[1]
    assert [group.ensure(obj) for obj in objects] == trees


def test_an_artists_group_of_that_name_is_untouched(modules, prop):
    theirs = bpy.data.node_groups.new("AO Field Prop", "ShaderNodeTree")
    ours = modules[0].ensure(prop)
    assert ours != theirs and not theirs.nodes and theirs.name == "AO Field Prop"


def test_sockets_explain_themselves(modules, prop):
    for item in modules[0].ensure(prop).interface.items_tree:
        assert item.description and not item.description.endswith(".")


def test_drivers_need_no_python(modules, prop):
    """bpy as a module hangs at exit after those that do; and Blender would ask whether to trust the file."""
    drivers = modules[0].ensure(prop).animation_data.drivers
    assert len(drivers) == 6
    assert {curve.driver.type for curve in drivers} == {"AVERAGE"}
    assert all(curve.driver.is_valid for curve in drivers)


def test_reads_from_left_to_right(modules, prop):
    tree = modules[0].ensure(prop)

    def left(node):
        return node.location.x + (left(node.parent) if node.parent else 0)

    assert all(left(link.from_node) + link.from_node.width < left(link.to_node) for link in tree.links)
    assert all(node.parent or node.bl_idname in {"NodeFrame", "NodeGroupOutput"} for node in tree.nodes)


def test_labels_fit(modules, prop):
    """Blender cuts a label off at 63 bytes."""
    trees = modules[0].ensure(prop), bpy.data.node_groups["Spherical Cap Occlusion"]
    assert all(len(node.label.encode()) < 63 for tree in trees for node in tree.nodes)
