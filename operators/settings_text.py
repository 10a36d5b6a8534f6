# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings from the command line's text: ``--set PROPERTY=VALUE``."""

from __future__ import annotations

import bpy


def set_from_text(settings: bpy.types.PropertyGroup, name: str, text: str) -> None:
    """Set the property ``name`` from ``text``. Raises ValueError that says what would be right."""
    names = [prop.identifier for prop in settings.bl_rna.properties if prop.identifier not in {"rna_type", "name"}]
    if name not in names:
        raise ValueError(f"there is no setting '{name}': choose among {', '.join(names)}")
    prop = settings.bl_rna.properties[name]
    if prop.type == "BOOLEAN":
        words = {
            "1": True,
            "true": True,
            "on": True,
            "yes": True,
            "0": False,
            "false": False,
            "off": False,
            "no": False,
        }
        if text.lower() not in words:
            raise ValueError("write on or off")
        value = words[text.lower()]
    elif prop.type == "ENUM":
        choices = [item.identifier for item in prop.enum_items]
        if text.upper() not in choices:
            raise ValueError(f"choose among {', '.join(choices)}")
        value = text.upper()
    elif prop.type in {"INT", "FLOAT"}:
        kind, noun = (int, "a whole number") if prop.type == "INT" else (float, "a number")
        try:
            value = kind(text)
        except ValueError:
            raise ValueError(f"write {noun}") from None
        if not prop.hard_min <= value <= prop.hard_max:
            raise ValueError(f"write {noun} from {prop.hard_min:g} to {prop.hard_max:g}")
    elif prop.type == "POINTER":
        kind = prop.fixed_type.identifier.lower() + "s"
        blocks = getattr(bpy.data, kind)
        value = blocks.get(text)
        if value is None and text:
            names = ", ".join(f"'{block.name}'" for block in blocks)
            raise ValueError(f"choose among the {kind} of the .blend: {names or 'it has none'}")
    else:
        value = text
    setattr(settings, name, value)
