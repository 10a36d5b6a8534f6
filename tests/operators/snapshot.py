# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that the open file holds, as plain values, to see what an operator changed."""

from __future__ import annotations

import hashlib
import warnings

import bpy

# What Blender keeps to itself, works out when asked or makes when read (Cycles' settings), and what no bake comes near.
_DERIVED = {
    "rna_type", "session_uid", "preview", "depsgraph", "is_evaluated", "is_updated", "is_updated_data", "tag",
    "has_data", "storage_type", "bindcode", "is_dirty", "loop_triangles", "loop_triangle_polygons", "corner_normals",
    "polygon_normals", "vertex_normals", "bound_box", "dimensions", "is_library_indirect",
    "cycles", "cycles_custom", "cycles_curves", "cycles_visibility",
    "tool_settings", "sequence_editor", "display",
    "users",  # wrong before 4.5: copying a material counts its images twice; ``bpy.data.user_map`` says who they are
}  # fmt: skip
_LIBRARY = (
    "cameras", "collections", "images", "libraries", "lights", "materials", "meshes", "node_groups", "objects",
    "scenes", "textures", "worlds",
)  # fmt: skip


def snapshot() -> dict[str, object]:
    """Path -> value of every property of every data-block, with node links, selection and custom properties."""
    bpy.context.view_layer.update()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # every property is read, the old ones too
        return _snapshot()


def _snapshot() -> dict[str, object]:
    found: dict[str, object] = {}
    for name in _LIBRARY:
        blocks = getattr(bpy.data, name)
        found[name] = sorted(block.name_full for block in blocks)
        for block, users in bpy.data.user_map(subset=list(blocks)).items():
            found[f"{name}[{block.name_full!r}] users"] = sorted(user.name_full for user in users)
        for block in blocks:
            _walk(f"{name}[{block.name_full!r}]", block, found, {block.as_pointer()})
    found["active"] = getattr(bpy.context.view_layer.objects.active, "name", None)
    found["selected"] = sorted(obj.name for obj in bpy.context.selected_objects)
    found["mode"] = bpy.context.mode
    return found


def differences(before: dict[str, object], after: dict[str, object]) -> list[str]:
    """What changed, a line each; none where the file is as it was."""
    missing = "nothing"
    return [
        f"{path}: {before.get(path, missing)} -> {after.get(path, missing)}"
        for path in sorted({*before, *after})
        if before.get(path, missing) != after.get(path, missing)
    ]


def _walk(path: str, thing: bpy.types.bpy_struct, found: dict[str, object], seen: set[int]) -> None:
    for key, value in _custom_properties(thing).items():
        found[f"{path}[{key!r}]"] = value
    for prop in thing.bl_rna.properties:
        name = prop.identifier
        if name in _DERIVED or name.startswith("bl_"):
            continue
        here = f"{path}.{name}"
        value = getattr(thing, name)
        if prop.type == "POINTER":
            _visit(here, value, found, seen)
        elif prop.type == "COLLECTION" and name == "links":
            found[here] = sorted(_link(link) for link in value)
        elif prop.type == "COLLECTION":
            found[here] = len(value)
            for index, item in enumerate(value):
                _visit(f"{here}[{index}]", item, found, seen)
        else:
            found[here] = _plain(value)


def _visit(path: str, value, found: dict[str, object], seen: set[int]) -> None:
    if value is None or (isinstance(value, bpy.types.ID) and not value.is_embedded_data):
        found[path] = value and f"{type(value).__name__} {value.name_full}"
    elif value.as_pointer() not in seen or not value.as_pointer():
        _walk(path, value, found, seen | {value.as_pointer()})


def _link(link: bpy.types.NodeLink) -> str:
    ends = (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
    return " ".join((*ends, "muted" * link.is_muted))


def _plain(value) -> str:
    if hasattr(value, "__len__") and not isinstance(value, (str, bytes, set)):
        value = [tuple(item) if hasattr(item, "__len__") else item for item in value]
    text = repr(value)
    return text if len(text) < 1000 else hashlib.sha256(text.encode()).hexdigest()


def _custom_properties(thing) -> dict[str, str]:
    try:
        keys = list(thing.keys())
    except (AttributeError, TypeError):
        return {}
    values = {}
    for key in set(keys) - _DERIVED - set(thing.bl_rna.properties.keys()):
        value = thing[key]
        for convert in ("to_dict", "to_list"):
            value = getattr(value, convert, lambda value=value: value)()
        values[key] = repr(value)
    return values
