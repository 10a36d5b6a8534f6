# SPDX-License-Identifier: GPL-3.0-or-later
"""``ensure()``: one copy of each group in a file, brought up to date in place, and nobody else's group touched."""

import importlib

import bpy
import pytest

NAMES = {
    "multibounce_fit": "Multibounce AO Fit",
    "multibounce_ao": "Multibounce AO",
    "multibounce_curve": "Multibounce AO Curve",
}


@pytest.fixture(params=NAMES)
def module(extension, empty_scene, request):
    return importlib.import_module(f"{extension.__name__}.shader_nodes.{request.param}")


@pytest.fixture
def name(module):
    return NAMES[module.__name__.rpartition(".")[2]]


def state(tree):
    """What an artist would notice: nodes, where they are, links, sockets."""
    nodes = {(node.name, node.label, node.parent and node.parent.label, *node.location) for node in tree.nodes}
    links = {(repr(link.from_socket), repr(link.to_socket)) for link in tree.links}
    interface = [(item.name, item.parent.name, repr(item)) for item in tree.interface.items_tree]
    return nodes, links, interface


def interface(tree):
    """All of each socket but its identifier, which a socket that was missing gets anew."""
    return [
        (item.in_out, item.name, item.parent.name, item.socket_type, item.description)
        for item in tree.interface.items_tree
    ]


def make_old(tree):
    """As an earlier version of the extension might have left the group: other nodes, other sockets in another order."""
    tree["multibounce_ao_version"] = 0
    tree.nodes.clear()
    tree.nodes.new("ShaderNodeMath").label = "old"
    interface = tree.interface
    interface.remove(interface.items_tree["Irradiance"])
    interface.remove(interface.items_tree["Factor"])
    interface.items_tree["Base Color"].description = "old"
    interface.new_socket("Albedo", in_out="INPUT", socket_type="NodeSocketColor")
    interface.move_to_parent(interface.items_tree["Base Color"], interface.new_panel("Old"), 0)


def test_named_as_promised(module, name):
    tree = module.ensure()
    assert module.NAME == name == tree.name
    assert tree.bl_idname == "ShaderNodeTree" and tree.library is None


def test_second_call_changes_nothing(module, name):
    tree = module.ensure()
    tree.nodes.new("NodeReroute").label = "an artist's own"
    before = state(tree)
    assert module.ensure() == tree
    assert state(tree) == before
    assert [group.name for group in bpy.data.node_groups] == [name]


def test_old_group_is_rebuilt_in_place(module, name):
    tree = module.ensure()
    fresh = state(tree)[:2], interface(tree)
    make_old(tree)
    assert module.ensure() == tree
    assert [group.name for group in bpy.data.node_groups] == [name]
    assert (state(tree)[:2], interface(tree)) == fresh


def test_rebuild_keeps_links_and_values_of_users(module):
    tree = module.ensure()
    make_old(tree)
    material = bpy.data.materials.new("Artist's")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5.0
    nodes, links = material.node_tree.nodes, material.node_tree.links
    user = nodes.new("ShaderNodeGroup")
    user.node_tree = tree
    color = nodes.new("ShaderNodeRGB")
    shader = nodes.new("ShaderNodeBsdfDiffuse")
    links.new(color.outputs[0], user.inputs["Base Color"])
    links.new(user.outputs["Color"], shader.inputs["Color"])
    other = next(socket for socket in user.inputs if socket.type == "VALUE")
    other.default_value = 0.375
    other_name = other.name

    module.ensure()

    assert user.inputs["Base Color"].links[0].from_node == color
    assert shader.inputs["Color"].links[0].from_socket == user.outputs["Color"]
    assert user.inputs[other_name].default_value == 0.375
    assert all(link.is_valid for link in links)
    assert "Albedo" not in user.inputs and "Irradiance" in user.inputs


def test_rebuild_keeps_links_where_a_socket_changes_its_type(module):
    tree = module.ensure()
    tree["multibounce_ao_version"] = 0
    tree.interface.items_tree["Base Color"].socket_type = "NodeSocketFloat"
    material = bpy.data.materials.new("Artist's")
    if material.node_tree is None:
        material.use_nodes = True  # before Blender 5.0
    user = material.node_tree.nodes.new("ShaderNodeGroup")
    user.node_tree = tree
    value = material.node_tree.nodes.new("ShaderNodeValue")
    material.node_tree.links.new(value.outputs[0], user.inputs["Base Color"])
    assert user.inputs["Base Color"].type == "VALUE"

    module.ensure()

    assert user.inputs["Base Color"].type == "RGBA"
    assert user.inputs["Base Color"].links[0].from_node == value


def test_newer_group_is_left_alone(module):
    tree = module.ensure()
    make_old(tree)
    tree["multibounce_ao_version"] = module.VERSION + 1
    before = state(tree)
    assert module.ensure() == tree
    assert state(tree) == before


@pytest.mark.parametrize("kind", ["ShaderNodeTree", "GeometryNodeTree"])
def test_artists_group_of_the_same_name_is_untouched(module, name, kind):
    theirs = bpy.data.node_groups.new(name, kind)
    theirs.nodes.new("NodeReroute").label = "an artist's own"
    theirs.interface.new_socket("Mine", in_out="INPUT", socket_type="NodeSocketFloat")
    before = state(theirs)
    ours = module.ensure()
    assert ours != theirs
    assert theirs.name == name and state(theirs) == before
    assert module.ensure() == ours
    assert len(bpy.data.node_groups) == 2
    assert not any(group.name.endswith(".001") for group in bpy.data.node_groups)


def test_copy_under_another_name_is_the_artists(module, name):
    module.ensure().name = "My own variant"
    ours = module.ensure()
    assert ours.name == name
    assert {group.name for group in bpy.data.node_groups} == {name, "My own variant"}


def test_linked_group_is_not_ours(module, name, tmp_path):
    library = str(tmp_path / "library.blend")
    bpy.data.libraries.write(library, {module.ensure()})
    bpy.data.node_groups.remove(bpy.data.node_groups[name])
    with bpy.data.libraries.load(library, link=True) as (_, wanted):
        wanted.node_groups = [name]
    linked = bpy.data.node_groups[name]
    assert linked.library is not None
    ours = module.ensure()
    assert ours.library is None and ours.name == name
    assert module.ensure() == ours
    assert linked.library is not None


def test_stays_one_after_saving_and_loading(module, name, tmp_path):
    module.ensure().use_fake_user = True
    path = str(tmp_path / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    before = state(bpy.data.node_groups[name])
    assert state(module.ensure()) == before
    assert [group.name for group in bpy.data.node_groups] == [name]


def test_sockets_explain_themselves(module):
    for item in module.ensure().interface.items_tree:
        assert item.description and not item.description.endswith(".")


def test_reads_from_left_to_right(module):
    tree = module.ensure()

    def left(node):
        return node.location.x + (left(node.parent) if node.parent else 0)

    assert all(left(link.from_node) + link.from_node.width < left(link.to_node) for link in tree.links)
    assert all(node.parent or node.bl_idname in {"NodeFrame", "NodeGroupOutput"} for node in tree.nodes)


def test_labels_fit(module):
    """Blender cuts a label off at 63 bytes."""
    assert all(len(node.label.encode()) < 63 for node in module.ensure().nodes)
