# SPDX-License-Identifier: GPL-3.0-or-later
"""core/ is numpy alone: it can be used, and read, without Blender."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
from enable_extension import source_folder

CORE = source_folder() / "core"
MODULES = sorted(path for path in CORE.rglob("*.py"))

# Raises at any import of Blender's modules, whoever asks for it.
BLOCK = """
import sys
class NoBlender:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"bpy", "mathutils", "bmesh", "gpu", "bl_math", "addon_utils"}:
            raise ImportError(name + " is not for core")
sys.meta_path.insert(0, NoBlender())
"""


def dotted(path: Path) -> str:
    parts = path.relative_to(CORE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def test_core_has_modules():
    assert MODULES


@pytest.mark.parametrize("path", MODULES, ids=dotted)
def test_source_names_no_blender_module(path):
    imported = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imported |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            imported.add(node.module.partition(".")[0])
    assert not imported & {"bpy", "mathutils", "bmesh", "gpu", "core"}


def test_every_module_imports_without_blender():
    """Nor do heavy packages load before they are used, as the extension's start would wait for them."""
    code = (
        BLOCK
        + f"""
sys.path.insert(0, {str(CORE.parent)!r})
import importlib
for name in {[dotted(path) for path in MODULES]!r}:
    importlib.import_module(name)
loaded = {{"embreex", "scipy", "OpenEXR"}} & set(sys.modules)
assert not loaded, loaded
"""
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
