# SPDX-License-Identifier: GPL-3.0-or-later
"""What all tests share. Tests of `core` need no Blender: only the fixtures that use bpy import it."""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

TESTS = Path(__file__).resolve().parent

if "bpy" not in sys.modules:
    # The bpy module reads this when it is imported: the user's own preferences stay out of it, both ways.
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp(prefix="multibounce_ao-")
    atexit.register(shutil.rmtree, os.environ["BLENDER_USER_RESOURCES"], ignore_errors=True)

sys.path.insert(0, str(TESTS))
from enable_extension import enable_extension, source_folder  # noqa: E402

sys.path.insert(0, str(source_folder()))  # for `from core import ...`


@pytest.fixture(scope="session")
def extension() -> ModuleType:
    """The enabled extension's package."""
    return enable_extension()


@pytest.fixture
def empty_scene(extension: ModuleType):
    """An empty factory scene, the extension still enabled. Returns the scene."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return bpy.context.scene


@pytest.fixture(scope="session")
def run_in_fresh_blender() -> Callable[[str], str]:
    """Runs Python code in a new process of the Blender, or of the bpy module, that the tests run in.

    There, `from enable_extension import enable_extension` works. Returns the standard output. An exception in the
    code is a failure.
    """

    def run(code: str) -> str:
        import bpy

        code = f"import sys; sys.path[:0] = {[str(TESTS), str(source_folder())]!r}\n{code}"
        if bpy.app.binary_path:
            command = [bpy.app.binary_path, "-b", "--python-exit-code", "1", "--python-expr", code]
        else:
            command = [sys.executable, "-c", code]
        result = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        assert result.returncode == 0, result.stdout + result.stderr
        return result.stdout

    return run
