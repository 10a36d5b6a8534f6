# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs pytest inside Blender, against the installed extension.

blender -b --python tests/run_in_blender.py -- FOLDER_WITH_PYTEST [PYTEST ARGUMENT]...

The exit code is pytest's.
"""

import ctypes
import importlib.util
import os
import sys
from pathlib import Path

import bpy

PACKAGE = "bl_ext.user_default.multibounce_ao"
pytest_folder, *arguments = sys.argv[sys.argv.index("--") + 1 :]
sys.path.append(pytest_folder)
os.environ["MULTIBOUNCE_AO_PACKAGE"] = PACKAGE
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
sys.dont_write_bytecode = True

if PACKAGE not in bpy.context.preferences.addons:
    sys.exit(f"{PACKAGE} is not enabled: install the zip first, as `make test-blender` does")
extensions = Path(bpy.utils.user_resource("EXTENSIONS"))
for name in ("embreex", "OpenEXR", "scipy"):
    spec = importlib.util.find_spec(name)
    if spec is None or not Path(spec.origin).is_relative_to(extensions):
        sys.exit(f"{name} must come from the zip's wheels, but it comes from {spec and spec.origin}")

import pytest  # noqa: E402

os.chdir(Path(__file__).resolve().parent.parent)
ctypes.CDLL(None).fflush(None)  # what Blender has printed comes before the tests' output, not after it
sys.exit(pytest.main(arguments))
