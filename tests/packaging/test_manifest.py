# SPDX-License-Identifier: GPL-3.0-or-later
"""blender_manifest.toml: valid for Blender, and in step with what the tests run on."""

import re
import subprocess
import sys
import tomllib
from itertools import product
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MANIFEST = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
WHEELS = [Path(wheel).stem.split("-") for wheel in MANIFEST["wheels"]]  # name, version, Python, ABI, platform


def test_blender_finds_the_manifest_valid(tmp_path):
    import bpy

    scripts = Path(bpy.utils.system_resource("SCRIPTS"))
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    tags = scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    (tmp_path / "blender_manifest.toml").write_bytes((ROOT / "blender_manifest.toml").read_bytes())
    (tmp_path / "__init__.py").touch()
    command = [sys.executable, str(tool), "validate", f"--valid-tags={tags}", str(tmp_path)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr


def test_every_permission_has_a_reason():
    assert MANIFEST["permissions"]
    assert all(reason.strip() for reason in MANIFEST["permissions"].values())


def test_one_wheel_of_each_package_for_each_python_and_platform():
    """Blender looks at neither macOS' nor glibc's version: of two wheels that differ there it takes any."""
    systems = {"win": "windows-x64", "manylinux": "linux-x64", "macosx": "macos-arm64"}
    shipped = [(name, python, systems[tag.partition("_")[0]]) for name, _, python, _, tag in WHEELS]
    expected = product(("embreex", "openexr", "scipy"), ("cp311", "cp313"), MANIFEST["platforms"])
    assert sorted(shipped) == sorted(expected)


def test_the_tests_run_on_the_versions_that_are_shipped():
    text = (ROOT / "tools" / "requirements.txt").read_text(encoding="utf-8").lower()
    pins = dict(re.findall(r"^([\w-]+)==([\w.]+)$", text, re.MULTILINE))
    for name, version in {(name, version) for name, version, *_ in WHEELS}:
        assert pins[name] == version
