# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs straight-line GLSL on numpy arrays: functions of `type name = expression;` lines and a `return`.

Such lines are Python too once their types are gone, given GLSL's functions and vectors that answer to .x and .xyz.
"""

import re
from pathlib import Path

import numpy as np

TYPE = r"(?:float|vec[234]|sampler2D)"


class Vector:
    """vec2, vec3 or vec4 a row: values (k, 2 to 4)."""

    def __init__(self, values):
        self.values = values

    def __getattr__(self, names):
        if not names or not set(names) <= set("xyzw"):
            raise AttributeError(names)
        columns = [self.values[:, "xyzw".index(name)] for name in names]
        return columns[0] if len(names) == 1 else Vector(np.stack(columns, axis=-1))


def _arithmetic(name):
    def operate(self, other):
        if isinstance(other, Vector):
            other = other.values
        elif isinstance(other, np.ndarray):
            other = other[:, None]
        return Vector(getattr(self.values, name)(other))

    return operate


for _name in ("add", "sub", "mul", "truediv"):
    setattr(Vector, f"__{_name}__", _arithmetic(f"__{_name}__"))
    setattr(Vector, f"__r{_name}__", _arithmetic(f"__r{_name}__"))
Vector.__array_ufunc__ = None  # number arrays leave the arithmetic to Vector


def texture(pixels, at):
    """Bilinear lookup at ``at`` of ``pixels`` (h, w, 4), first row at v = 0, clamped: what a GPU's sampler does."""
    height, width = pixels.shape[:2]
    column = np.clip(at.x * width - 0.5, 0.0, width - 1.0)
    row = np.clip(at.y * height - 0.5, 0.0, height - 1.0)
    i, j = (np.minimum(each.astype(int), size - 2) for each, size in ((row, height), (column, width)))
    t, s = (row - i)[:, None], (column - j)[:, None]
    above = (1.0 - s) * pixels[i, j] + s * pixels[i, j + 1]
    below = (1.0 - s) * pixels[i + 1, j] + s * pixels[i + 1, j + 1]
    return Vector((1.0 - t) * above + t * below)


def _smoothstep(low, high, x):
    s = np.clip((x - low) / (high - low), 0.0, 1.0)
    return s * s * (3.0 - 2.0 * s)


def _length(v):
    return np.linalg.norm(v.values, axis=1)


FUNCTIONS = {
    "abs": lambda x: Vector(np.abs(x.values)) if isinstance(x, Vector) else np.abs(x),
    "atan": np.arctan2,
    "clamp": np.clip,
    "dot": lambda a, b: (a.values * b.values).sum(axis=1),
    "length": _length,
    "max": np.maximum,
    "min": np.minimum,
    "normalize": lambda v: v / _length(v),
    "pow": np.power,
    "sign": np.sign,
    "smoothstep": _smoothstep,
    "sqrt": np.sqrt,
    "step": lambda edge, x: (x >= edge).astype(float),
    "textureLod": lambda pixels, at, lod: texture(pixels, at),
    "vec2": lambda *parts: Vector(np.stack(np.broadcast_arrays(*map(np.atleast_1d, parts)), axis=-1)),
}


def load(path, **uniforms):
    """The functions of the GLSL file by name, its uniforms set to what is given."""
    source = re.sub(r"//.*", "", Path(path).read_text(encoding="utf-8"))
    missing = set(re.findall(rf"uniform {TYPE} (\w+);", source)) - set(uniforms)
    assert not missing, missing
    source = re.sub(rf"uniform {TYPE} \w+;", "", source)
    source = re.sub(rf"const {TYPE} ", "", source)
    source = re.sub(rf"^{TYPE} (\w+)\((.*)\)\s*\{{", r"def \1(\2):", source, flags=re.M)
    source = re.sub(rf"\b{TYPE} (?=\w)", "", source)
    source = source.replace(";", "").replace("}", "")
    names = FUNCTIONS | uniforms
    exec(source, names)
    return names
