# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups ``AO Field <object>``: what one object blocks of the sky, at any place around it, without a ray.

The same steps and symbols as ``core.ao_field.AOField.occlusion`` (the notes "Ambient Occlusion Fields", 4.
Implementation, "Run-Time"), with the maps in the picture of ``field_atlas`` and the volume, where a field has one, in
that of ``field_volume``. The object may move, turn, be scaled evenly, mirrored and parented: its place comes from a
Texture Coordinate node, its rotation from drivers.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import partial
from math import pi

import bpy

from ..core.ao_field import AOField
from . import field_volume, spherical_cap
from .environment import direction_of, texture
from .expression import Expression, Graph, clamp, maximum, minimum
from .field_atlas import BANDS, BORDER, COLUMNS, ROWS
from .field_drivers import follow
from .functions import (
    absolute,
    components,
    cross,
    dot,
    length,
    less_than,
    normalised,
    select,
    sign,
    sqrt,
    vector,
)
from .group import Socket, ensure_group, find_group, outdate_group, rename_group

NAME = "AO Field"
VERSION = 3

# Which object a group is of, its node "Place" tells: a pointer among a tree's custom properties would be miscounted
# when EEVEE compiles it.
_FIELD_KEY = "multibounce_ao_is_field"
# Whether the group was built for fields with a volume.
_VOLUME_KEY = "multibounce_ao_has_volume"
_LONGEST_NAME = 63

_INPUTS = (
    Socket(
        "Normal",
        "NodeSocketVector",
        "Normal of the surface in world space, such as a Bump node gives; unconnected, the surface's own",
        default_value=(0.0, 0.0, 0.0),
    ),
)
_OUTPUTS = (
    Socket("AO", "NodeSocketFloat", "What the object leaves of the light: 1 is open. Several objects multiply"),
    Socket("Occlusion", "NodeSocketFloat", "What the object takes of the light, 1 - AO"),
)


def ensure(obj: bpy.types.Object, has_volume: bool = False) -> bpy.types.ShaderNodeTree:
    """The group of ``obj``, built or brought up to date if need be, and named after it. It follows the object, whatever
    that is called; :func:`show` gives it its field.

    has_volume  for a field with a volume: more than half as many nodes again, which others do without
    """
    name = _group_name(obj)
    tree = group_of(obj)
    if tree is None:
        taken, _ = find_group(name)
        owner = object_of(taken) if taken is not None else None
        if owner is not None:  # it has the name from the time before its object was renamed
            ensure(owner, taken.get(_VOLUME_KEY, False))
    elif tree.name != name:
        rename_group(tree, name)
    if tree is not None and tree.get(_VOLUME_KEY, False) != has_volume:
        outdate_group(tree)
    tree = ensure_group(name, VERSION, _INPUTS, _OUTPUTS, partial(_build, has_volume=has_volume))
    tree[_FIELD_KEY], tree[_VOLUME_KEY] = True, has_volume
    tree.nodes["Place"].object = obj
    follow(tree, obj)
    return tree


def group_of(obj: bpy.types.Object) -> bpy.types.ShaderNodeTree | None:
    """The local group of ``obj``, or None where it has none."""
    for tree in bpy.data.node_groups:
        if tree.library is None and object_of(tree) == obj:
            return tree
    return None


def object_of(tree: bpy.types.NodeTree) -> bpy.types.Object | None:
    """Whose field ``tree`` is; None where it is no field, or its object is gone."""
    place = tree.nodes.get("Place") if _FIELD_KEY in tree else None
    return place.object if place is not None else None


@dataclass(frozen=True)
class ShownVolume:
    """A field's volume as shaders have it: the picture of ``field_volume``, and its box from the field's centre."""

    image: bpy.types.Image
    low: tuple[float, float, float]
    size: tuple[float, float, float]


def show(
    tree: bpy.types.ShaderNodeTree,
    image: bpy.types.Image,
    numbers: dict[str, float],
    centre: tuple[float, float, float],
    proportions: tuple[float, float, float],
    volume: ShownVolume | None = None,
) -> None:
    """Give the group a field: its atlas, its numbers by the names of :func:`field_numbers`, its centre, what the
    object's own coordinates are multiplied with to get the field's, and the volume of one that has it."""
    images = {f"Maps {band + 1}": image for band in range(BANDS)}
    vectors = {"Centre": centre, "Proportions": proportions}
    if volume is not None:
        images |= {f"Volume {index + 1}": volume.image for index in range(4)}
        vectors |= {"Volume Low": volume.low, "Volume Size": volume.size}
    for name, each in images.items():
        tree.nodes[name].image = each
    for name, value in numbers.items():
        tree.nodes[name].outputs[0].default_value = value
    for name, values in vectors.items():
        for socket, value in zip(tree.nodes[name].inputs, values, strict=True):
            socket.default_value = value


def field_numbers(field: AOField) -> dict[str, float]:
    """The numbers of a field that stand in nodes of their own, where an artist may change them, by their names. A
    volume has its own p, and takes the place of A0."""
    within = {"A0": float(field.a0), "p": float(field.p)} if field.volume is None else {"p": float(field.volume.p)}
    return {"Resolution": float(field.resolution), **within, "r near": float(field.r_near), "r far": float(field.r_far)}


def _group_name(obj: bpy.types.Object) -> str:
    """``AO Field <object>``; a longer one is cut, and kept apart from others."""
    name = f"{NAME} {obj.name}".encode()
    if len(name) <= _LONGEST_NAME:
        return name.decode()
    digest = f"_{zlib.crc32(obj.name.encode()):08x}"
    return name[: _LONGEST_NAME - len(digest)].decode(errors="ignore") + digest


def _build(tree: bpy.types.ShaderNodeTree, has_volume: bool) -> None:
    graph = Graph(tree)
    x, n = _place(graph)
    abc, abc_m, c0, r0_d_e = _look_up(graph, *_face(graph, x))
    with graph.frame("r; within the convex hull, r0, the field is that at the hull"):
        r = length(x).named("r")
        omega = (x / r).named("omega")
        r0, d, e = components(r0_d_e, "r0", "d", "e")
        r_clamp = maximum(r, r0).named("r clamp")
    with graph.frame("d r sqrt(r^2 - r0^2)"):
        root = (d * r_clamp * sqrt((r_clamp - r0) * (r_clamp + r0))).named("root")
    solid_angle = _radial(graph, "Omega", abc, r_clamp, root)
    solid_angle_m = _radial(graph, "Omega M", abc_m, r_clamp, root)
    with graph.frame("Upsilon = normalize((r0 / r)^e C0 - r0 omega); k = n . Upsilon"):
        # Of pictures that older bakes left there is no e, but 0; in these it is 1.
        near = ((r0 / r_clamp) ** maximum(e, 1)).named("(r0 / r)^e")
        upsilon = normalised(near * c0 - r0 * omega).named("Upsilon")
        k = dot(n, upsilon).named("k")
    with graph.frame("|M| of Omega M"):
        half = solid_angle_m / (2 * pi)
        moment = (half * (2 - half)).named("|M|")
    at_hull = _blocked(graph, solid_angle, moment, k).named("A at r clamp")
    if has_volume:
        a0 = _within_volume(graph, x, n).named("A0 at x")
    with graph.frame("within: t = (r / r0)^p, A = t A + (1 - t) A0"):
        p = graph.value("p", 1.0)
        if not has_volume:
            a0 = graph.value("A0", 0.0)
        inward = (minimum(r / r0, 1) ** p).named("t")
        within = (a0 + inward * (at_hull - a0)).named("A within")
    with graph.frame("the shadow fades from r near to r far, as a smoothstep"):
        near, far = graph.value("r near", 1.0), graph.value("r far", 2.0)
        u = clamp((r - near) / (far - near), 0, 1).named("u")
        faded = within * (1 - u * u * (3 - 2 * u))
    with graph.frame("nothing where renders hide the object"):
        occlusion = clamp(faded * (1 - graph.value("Hidden", 0.0)), 0, 1).named("A")
        ao = (1 - occlusion).named("AO")
    graph.output("AO", ao)
    graph.output("Occlusion", occlusion)
    graph.arrange()


def _place(graph: Graph) -> tuple[Expression, Expression]:
    """x, from the field's centre, and n, both in the field's space."""
    with graph.frame("x: the place in the object's space, from the field's center"):
        place = graph.node("ShaderNodeTexCoord", "")
        place.name = "Place"
        position = Expression(graph, place.outputs["Object"], "place")
        x = (position * _constant(graph, "Proportions", 1.0) - _constant(graph, "Centre", 0.0)).named("x")
    with graph.frame("n: the normal there, by the object's rotation (w, v)"):
        normal, surface = graph.input("Normal"), graph.node("ShaderNodeNewGeometry", "")
        own = less_than(length(normal), 1e-6) * Expression(graph, surface.outputs["Normal"], "own normal")
        world = normalised(normal + own).named("world n")
        v, w = _constant(graph, "Rotation", 0.0).named("Rotation"), graph.value("w", 1.0)
        once = cross(v, world).named("v x n")
        turned = world + 2 * (cross(v, once) - w * once)
        n = (sign(graph.value("Scale", 1.0)) * turned).named("n")
    return x, n


def _face(graph: Graph, x: Expression) -> tuple[Expression, ...]:
    """Coordinates s and t in [-1, 1] on the face of the cube that the direction of ``x`` meets, and that face's column
    and row in the atlas."""
    with graph.frame("the cube: which face x meets, and where (core/cubemap.py)"):
        ax, ay, az = components(absolute(x), "|x|", "|y|", "|z|")
        others = maximum(ay, az)
        is_x = less_than(others, ax).named("is x")
        is_z = (less_than(ay, az) * (1 - is_x)).named("is z")
        axis = vector(is_x, 1 - is_x - is_z, is_z).named("axis")
        on_cube = (x / maximum(ax, others)).named("on cube")
        px, py, pz = components(on_cube, "x/max", "y/max", "z/max")
        s = select(is_x, py, px).named("s")
        t = select(is_z, py, pz).named("t on face")
        column = dot(axis, (0.0, 1.0, 2.0)).named("column")
        row = (1.5 + dot(axis, on_cube) / 2).named("row")
    return s, t, column, row


def _look_up(graph: Graph, s: Expression, t: Expression, column: Expression, row: Expression) -> list[Expression]:
    """The colours of the four bands of the atlas."""
    with graph.frame("the atlas: the direction of that texel (field_atlas.py)"):
        n = graph.value("Resolution", 16.0)
        side = (n + 2 * BORDER).named("side")
        steps = ((n - 1) / 2).named("steps")
        right = column + (BORDER + 0.5 + (s + 1) * steps) / side
        up = row + (BORDER + 0.5 + (t + 1) * steps) / side
        first, second, height = direction_of(right, up, BANDS * COLUMNS, ROWS)
        # A band is a quarter of the picture's width, and so of a turn about z.
        third, fourth = -first, -second
        turns = ((first, second), (second, third), (third, fourth), (fourth, first))
    with graph.frame("the maps: a, b, c of Omega; of Omega M; C0; r0, d, e"):
        return [texture(graph, f"Maps {band + 1}", *turn, height) for band, turn in enumerate(turns)]


def _radial(graph: Graph, name: str, coefficients: Expression, r: Expression, root: Expression) -> Expression:
    with graph.frame(f"{name} = 1 / (a r^2 + b r + c + root)"):
        a, b, c = components(coefficients, "a", "b", "c")
        return (1 / ((a * r + b) * r + c + root)).named(name)


def _within_volume(graph: Graph, x: Expression, n: Expression) -> Expression:
    """A by the volume, at ``x`` for the normal ``n``."""
    with graph.frame("the volume's box, from the field's center"):
        low, size = _constant(graph, "Volume Low", -1.0), _constant(graph, "Volume Size", 2.0)
    moment, solid_angle = field_volume.look_up(graph, x, low, size)
    with graph.frame("Upsilon there is M's direction"):
        length_of_moment = length(moment).named("|M| inside")
        k = dot(n, normalised(moment)).named("k inside")
    return _blocked(graph, solid_angle, length_of_moment, k)


def _blocked(graph: Graph, solid_angle: Expression, moment: Expression, k: Expression) -> Expression:
    """A of what has the ``solid_angle`` and |M|, ``moment``, about an axis of cosine ``k`` with the normal."""
    with graph.frame("a larger cap, blocked in part, keeps both Omega and |M|"):
        larger = maximum(4 * pi * (1 - pi * moment / solid_angle), solid_angle).named("larger")
        part = (solid_angle / larger).named("part")
        return part * _cap(graph, larger, k)


def _cap(graph: Graph, solid_angle: Expression, k: Expression) -> Expression:
    node = graph.node("ShaderNodeGroup", "")
    node.node_tree = spherical_cap.ensure()
    graph.link(solid_angle, node.inputs["Solid Angle"])
    graph.link(k, node.inputs["Cosine"])
    return Expression(graph, node.outputs["Occlusion"], "cap")


def _constant(graph: Graph, name: str, value: float) -> Expression:
    """A vector in a node of its own."""
    node = graph.node("ShaderNodeCombineXYZ", name)
    node.name = name
    for socket in node.inputs:
        socket.default_value = value
    return Expression(graph, node.outputs[0], name)
