# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that an object or a collection has of its own: which of them wins, and that every path bakes with it."""

import json

import bpy
import numpy as np
import pytest

from .bakes import attribute, bake, change_settings, generator, operators, pixels, reports, select
from .commands import reported, run
from .meshes import add_uv_map, box, plate, positions
from .props import bake_field
from .snapshot import differences, snapshot


def override(owner, **values):
    """Let ``owner`` have these settings of its own."""
    for name, value in values.items():
        setattr(owner.multibounce_ao_overrides, name, value)
        setattr(owner.multibounce_ao_overrides, f"override_{name}", True)


def collection(name, *objects, inside=None):
    made = bpy.data.collections.new(name)
    (inside or bpy.context.scene.collection).children.link(made)
    for obj in objects:
        made.objects.link(obj)
    bpy.context.view_layer.update()
    return made


def chosen(obj, *names, fixed=()):
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    found = operators("overrides").Overrides(bpy.context.view_layer, fixed).settings_for(obj, settings)
    return tuple(getattr(found, name) for name in names)


def test_each_setting_can_be_overridden_and_is_as_in_the_scene():
    obj, overridable = plate(), operators("overridable_settings").OVERRIDABLE
    overrides = obj.multibounce_ao_overrides.bl_rna.properties
    of_scene = bpy.context.scene.multibounce_ao.bl_rna.properties
    own = {prop.identifier for prop in overrides} - {"rna_type", "name"}
    assert own == {*overridable, *(f"override_{name}" for name in overridable)}
    for name in overridable:
        for told in ("type", "name", "description", "subtype"):
            assert getattr(overrides[name], told) == getattr(of_scene[name], told)
        assert getattr(overrides[name], "default", None) == getattr(of_scene[name], "default", None)
        switch = overrides[f"override_{name}"]
        assert of_scene[name].name.lower() in switch.name.lower()
        assert len(switch.description) > 10 and not switch.description.endswith(".")
    # A value without its switch does nothing.
    obj.multibounce_ao_overrides.samples = 7
    assert chosen(obj, "samples") == (256,)


def test_which_one_wins():
    hero, other = plate("Hero"), plate("Other")
    outer = collection("Outer")
    inner = collection("Inner", hero, inside=outer)
    second = collection("Second", hero, other)
    third = collection("Third", hero)
    assert chosen(hero, "samples") == (256,)
    override(third, samples=3, margin=3, max_distance=3.0)
    override(second, samples=2, margin=2)
    assert chosen(hero, "samples", "margin", "max_distance") == (2, 2, 3.0)  # the first in the Outliner
    override(outer, samples=1)
    assert chosen(hero, "samples") == (1,)  # as high in the Outliner, and before the others
    override(second, margin=2)
    override(inner, samples=10)
    assert chosen(hero, "samples", "margin") == (10, 2)  # further in; a setting at a time
    override(hero, samples=20)
    assert chosen(hero, "samples", "margin", "max_distance") == (20, 2, 3.0)
    assert chosen(other, "samples", "margin", "max_distance") == (2, 2, 0.0)
    assert chosen(hero, "samples", "margin", fixed={"samples"}) == (256, 2)
    layer = bpy.context.view_layer.layer_collection.children["Second"]
    layer.exclude = True
    assert chosen(hero, "margin") == (3,)


def test_a_bake_is_that_with_the_scene_set_so():
    """Bit for bit, vertices and textures in one bake; and the records tell what each was baked with."""
    floor, wall = plate("Floor"), box("Wall", low=(-1, -0.1, 0), high=(1, 0.1, 1))
    hero = plate("Hero", location=(0, 0, 0.5))
    walls, expected = collection("Walls", wall), {}
    bake(floor, wall, hero, samples=16)
    expected["Floor"] = attribute(floor)
    bake(wall, samples=8, max_distance=0.5, falloff="LINEAR", occluders="SELF", ignore_backfaces=True)
    expected["Wall"] = attribute(wall)
    bpy.ops.multibounce_ao.reset_settings()
    bake(hero, samples=32, target="TEXTURE", resolution=24, margin=2)
    expected["Hero"] = pixels(bpy.data.images["Hero Multibounce AO"])
    expected_record = hero["multibounce_ao"].to_dict()
    select(floor, wall, hero)
    bpy.ops.multibounce_ao.clear()
    bpy.ops.multibounce_ao.reset_settings()

    override(walls, samples=8, max_distance=0.5, falloff="LINEAR", occluders="SELF")
    override(wall, ignore_backfaces=True)
    override(hero, samples=32, target="TEXTURE", resolution=24, margin=2)
    bake(floor, wall, hero, samples=16)
    np.testing.assert_array_equal(attribute(floor), expected["Floor"])
    np.testing.assert_array_equal(attribute(wall), expected["Wall"])
    np.testing.assert_array_equal(pixels(bpy.data.images["Hero Multibounce AO"]), expected["Hero"])
    assert "Multibounce AO" not in hero.data.attributes
    record = hero["multibounce_ao"].to_dict()
    own = {"seconds", "images", "warnings"}
    assert {key: value for key, value in record.items() if key not in own} == {
        key: value for key, value in expected_record.items() if key not in own
    }
    assert [obj["multibounce_ao"]["samples"] for obj in (floor, wall, hero)] == [16, 8, 32]
    assert wall["multibounce_ao"]["falloff"] == "LINEAR"
    # Clear takes the bakes back, and leaves the settings to the artist; so does the reset of the scene's.
    select(floor, wall, hero)
    bpy.ops.multibounce_ao.clear()
    bpy.ops.multibounce_ao.reset_settings()
    assert chosen(hero, "samples", "resolution") == (32, 24)


def test_the_forecast_counts_what_is_baked(monkeypatch):
    monkeypatch.setattr(operators("forecast"), "_rates", dict)
    plain, hero, many = plate("Plain"), plate("Hero", location=(3, 0, 0)), plate("Many", location=(6, 0, 0))
    override(hero, target="TEXTURE", resolution=16, samples=2)
    override(many, samples=8)
    objects = [plain, hero, many]
    change_settings(samples=4)
    settings = operators("settings").BakeSettings.of(bpy.context.scene)
    told = operators("forecast").forecast(objects, settings)
    done = reports(*objects, samples=4)
    assert (told.points, told.rays) == (25 + 256 + 25, 4 * 25 + 2 * 256 + 8 * 25)
    assert (told.points, told.rays) == (sum(each.points for each in done), sum(each.rays for each in done))
    assert told.text() == "3 objects, 306 points, 812 rays, 2 with overrides"
    assert operators("forecast").forecast([many], settings).text() == "1 object, 25 points, 200 rays, with overrides"
    assert operators("forecast").forecast([plain], settings).own == 0


def test_a_shared_mesh_has_the_settings_that_it_was_baked_with():
    first, second = plate("First"), plate("Second", location=(3, 0, 0))
    second.data = first.data
    override(second, samples=8, use_material_nodes=False)
    bake(first, second, samples=4)
    assert [obj["multibounce_ao"]["samples"] for obj in (first, second)] == [4, 4]
    assert [obj["multibounce_ao"]["use_material_nodes"] for obj in (first, second)] == [1, 0]


def test_each_pair_has_its_own_cage():
    lows = [plate(f"{name}_low", steps=2, location=(5 * x, 0, 0)) for x, name in enumerate("ab")]
    for x, name in enumerate("ab"):
        plate(f"{name}_high", location=(5 * x, 0, 0.3 * (1 + x)))
    change_settings(use_selected_to_active=True, use_match_names=True, max_ray_distance=0.35)
    objects = [obj for obj in bpy.context.scene.objects]
    # Rays start at the extrusion and go in: the second's partner lies outside of the first's.
    override(lows[1], cage_extrusion=0.7)
    change_settings(cage_extrusion=0.35)
    first, second = reports(*objects, samples=4)
    assert (first.error, second.error) == (None, None)
    lows[1].multibounce_ao_overrides.override_cage_extrusion = False
    first, second = reports(*objects, samples=4)
    assert first.error is None
    assert "meets none of the surfaces" in second.error


def test_uv_map_and_field():
    obj = box("Crate")
    add_uv_map(obj.data, (positions(obj)[:, :2] + 1) / 2, "First")
    add_uv_map(obj.data, (positions(obj)[:, :2] + 1) / 4, "Second")
    override(obj, uv_map="Second", field_resolution=8, samples=4)
    bake(obj, target="TEXTURE", resolution=8, samples=2)
    assert obj["multibounce_ao"]["uv_map"] == "Second"
    bake_field(obj)
    assert (obj["multibounce_ao_field"]["resolution"], obj["multibounce_ao_field"]["samples"]) == (8, 4)


@pytest.fixture
def blend(scene, tmp_path):
    """A floor that follows the scene, a prop that does not, a roof over both."""
    change_settings(samples=4, resolution=8, output_directory="//maps")
    plate("Floor")
    override(plate("Prop", location=(0, 0, 0.5)), samples=8)
    roof = plate("Roof", location=(0, 0, 1))
    override(collection("Roofs", roof), target="TEXTURE", use_material_nodes=False)
    path = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def samples(blend, *arguments):
    return {entry["name"]: entry["rays"] and entry["samples"] for entry in reported(blend, *arguments)["objects"]}


def test_commands(blend):
    """--set holds for all, whatever they override; --resume bakes what other overrides would make another."""
    assert samples(blend) == {"Floor": 4, "Prop": 8, "Roof": 4}
    assert (blend.parent / "maps" / "Roof_multibounce_ao.exr").is_file()
    assert samples(blend, "--set", "samples=2", "--set", "target=VERTEX") == {"Floor": 2, "Prop": 2, "Roof": 2}
    assert "Multibounce AO" in bpy.data.objects["Roof"].data.attributes
    assert samples(blend, "--save", "--resume") == {"Floor": 4, "Prop": 8, "Roof": 4}
    assert samples(blend, "--resume") == {"Floor": 0, "Prop": 0, "Roof": 0}
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    override(bpy.data.objects["Prop"], samples=16)
    override(bpy.data.collections["Roofs"], margin=0)
    bpy.ops.wm.save_mainfile()
    assert samples(blend, "--resume") == {"Floor": 0, "Prop": 16, "Roof": 4}
    report = blend.parent / "field.json"
    assert run("field", blend, "--object", "Prop", "--set", "field_resolution=8", "--report", report) == 0
    assert json.loads(report.read_text())["objects"][0]["samples"] == 16
    assert run("field", blend, "--object", "Prop", "--set", "samples=5", "--report", report) == 0
    assert json.loads(report.read_text())["objects"][0]["samples"] == 5


def test_shares_and_merge(blend):
    def left(path):
        bpy.ops.wm.open_mainfile(filepath=str(path))
        found = snapshot()
        return {key: value for key, value in found.items() if "session" not in key and "filepath" not in key}

    assert run("bake", blend, "--quiet", "--save", blend.parent / "whole.blend") == 0
    parts = [blend.parent / f"part_{index}.blend" for index in (1, 2)]
    for index, part in enumerate(parts, 1):
        assert run("bake", blend, "--quiet", "--share", f"{index}/2", "--save", part) == 0
    assert run("merge", blend, *parts, "--quiet", "--save") == 0
    changed = differences(left(blend.parent / "whole.blend"), left(blend))
    assert not [line for line in changed if "multibounce_ao']:" not in line and "users" not in line], changed
    told = [bpy.data.objects[name]["multibounce_ao"] for name in ("Floor", "Prop", "Roof")]
    assert [(each["samples"], each["target"]) for each in told] == [(4, "VERTEX"), (8, "VERTEX"), (4, "TEXTURE")]


def test_library_data(blend, scene, tmp_path):
    """What a linked collection has of its own holds for objects that were made local, and a library override of an
    object may have settings of its own."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(blend), link=True) as (_, here):
        here.objects = ["Prop"]
    linked = here.objects[0]
    assert operators("overrides").overridden(linked) == {"samples": 8}
    bpy.context.scene.collection.objects.link(linked)
    local = linked.override_create(remap_local_usages=True)
    local.data = local.data.make_local() if local.data.library else local.data
    assert chosen(local, "samples") == (8,)
    override(local, samples=3, margin=5)
    bake(local, samples=2)
    assert local["multibounce_ao"]["samples"] == 3
    path = tmp_path / "shot.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert chosen(bpy.data.objects["Prop", None], "samples", "margin") == (3, 5)


def test_closing_a_bake_leaves_no_trace():
    obj = plate()
    override(obj, target="TEXTURE", resolution=8)
    override(collection("Props", obj), samples=4)
    change_settings(samples=64)
    select(obj)
    before = snapshot()
    work = generator(obj)
    next(work)
    work.close()
    assert differences(before, snapshot()) == []


def test_clear_overrides():
    owners = plate(), collection("Props")
    for owner in owners:
        override(owner, samples=7, target="TEXTURE")
        with bpy.context.temp_override(multibounce_ao_overrides=owner.multibounce_ao_overrides):
            assert bpy.ops.multibounce_ao.clear_overrides() == {"FINISHED"}
        assert operators("overrides").overridden(owner) == {}
        assert owner.multibounce_ao_overrides.samples == 256
    assert not bpy.ops.multibounce_ao.clear_overrides.poll()
