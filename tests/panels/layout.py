# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws panels where there is no window, with a layout that takes only what Blender's own would take."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MethodType, SimpleNamespace

import bpy

_FUNCTIONS = bpy.types.UILayout.bl_rna.functions
_PROPERTIES = bpy.types.UILayout.bl_rna.properties


@dataclass
class Drawn:
    """One thing that a panel shows. ``active`` is False where it is greyed out, by itself or by what holds it.

    ``options`` are what a button gives its operator.
    """

    kind: str
    name: str
    layout: Layout
    options: SimpleNamespace | None = None

    @property
    def active(self) -> bool:
        return self.layout.is_active


@dataclass
class Layout:
    """A stand-in for UILayout: checks names, arguments and icons against Blender's own, and records what is drawn."""

    drawn: list[Drawn] = field(default_factory=list)
    parent: Layout | None = None

    def __post_init__(self):
        self.__dict__["values"] = {"active": True, "enabled": True}

    def __setattr__(self, name, value):
        if name in ("drawn", "parent"):
            self.__dict__[name] = value
            return
        prop = _PROPERTIES[name]
        assert not prop.is_readonly, name
        if prop.type == "ENUM":
            assert value in prop.enum_items, f"{name} = {value}"
        self.values[name] = value

    @property
    def is_active(self) -> bool:
        above = self.parent.is_active if self.parent else True
        return above and self.values["active"] and self.values["enabled"]

    def __getattr__(self, name):
        function = _FUNCTIONS[name]

        def call(*arguments, **options):
            given = _arguments(function, arguments, options)
            if name == "prop":
                prop = given["data"].bl_rna.properties[given["property"]]
                self.drawn.append(Drawn("prop", prop.identifier, self))
            elif name == "template_ID":
                prop = given["data"].bl_rna.properties[given["property"]]
                assert prop.type == "POINTER"
                self.drawn.append(Drawn("prop", prop.identifier, self))
            elif name == "prop_search":
                assert given["search_property"] in given["search_data"].bl_rna.properties
                self.drawn.append(Drawn("prop", given["data"].bl_rna.properties[given["property"]].identifier, self))
            elif name == "operator":
                module, _, operator = given["operator"].partition(".")
                operator = getattr(getattr(bpy.ops, module), operator)
                chosen = SimpleNamespace(**dict.fromkeys(operator.get_rna_type().properties.keys()))
                self.drawn.append(Drawn("operator", given["operator"], self, chosen))
                return chosen
            elif name in ("label", "progress"):
                self.drawn.append(Drawn(name, given.get("text", ""), self))
            elif name in ("row", "column", "split", "box", "grid_flow"):
                return Layout(self.drawn, self)
            else:
                assert name in ("separator", "separator_spacer"), f"teach the stand-in {name}()"
            return None

        return call


def _arguments(function: bpy.types.Function, arguments, options) -> dict[str, object]:
    """The arguments by name, each of them one that Blender's function takes; icons and other choices exist."""
    parameters = {p.identifier: p for p in function.parameters if not p.is_output}
    names = [name for name, p in parameters.items() if p.is_required]
    assert len(arguments) <= len(names), f"{function.identifier}: pass what is optional by its name"
    given = dict(zip(names, arguments, strict=False)) | options
    assert set(names) <= set(given), (function.identifier, given)
    for name, value in given.items():
        parameter = parameters[name]  # KeyError: Blender does not know it
        if parameter.type == "ENUM":
            assert value in parameter.enum_items, f"{name}={value}"
        elif parameter.type in {"STRING", "BOOLEAN", "INT", "FLOAT"}:
            assert isinstance(
                value, {"STRING": str, "BOOLEAN": bool, "INT": int, "FLOAT": (int, float)}[parameter.type]
            )
    return given


class Context:
    """The present context with a region that is as wide as Blender's sidebar, on a screen of plain pixels."""

    region = SimpleNamespace(width=280)
    preferences = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))

    def __getattr__(self, name):
        return getattr(bpy.context, name)


def draw(panel: type[bpy.types.Panel]) -> list[Drawn]:
    """What ``panel`` shows in the present context; nothing where it does not show up at all."""
    if hasattr(panel, "poll") and not panel.poll(bpy.context):
        return []
    probe = SimpleNamespace(layout=Layout())
    for name in dir(panel):
        if not name.startswith("__") and callable(getattr(panel, name)) and name not in dir(bpy.types.Panel):
            setattr(probe, name, MethodType(getattr(panel, name), probe))
    if "draw_header" in vars(panel):
        panel.draw_header(probe, Context())
    panel.draw(probe, Context())
    return probe.layout.drawn
