# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the installable zips with Blender's own extension tool, one a platform.

The wheels that `blender_manifest.toml` names are fetched by pip into `wheels/`. Without options the
release is built: every platform, each zip with the wheels of every supported Python. `--platform` builds
that one alone, and `--python` puts in the wheels of that one Python, also one that no release supports: some
systems' own Blender has another Python than the official one, and can test the extension all the same.
"""

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path, PurePosixPath
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = "blender_manifest.toml"
WHEELS = ROOT / "wheels"
RUNTIME = {MANIFEST, "LICENSE", "__init__.py", "core", "operators", "panels", "shader_nodes", "wheels"}


class Wheel(NamedTuple):
    """The fields of a wheel's file name, as the binary distribution format defines them."""

    name: str
    version: str
    python: str
    abi: str
    tag: str

    @classmethod
    def parse(cls, path: str) -> "Wheel":
        return cls(*PurePosixPath(path).stem.split("-"))

    @property
    def filename(self) -> str:
        return "-".join(self) + ".whl"

    @property
    def platform(self) -> str:
        """The same platform in Blender's words."""
        if self.tag == "win_amd64":
            return "windows-x64"
        if self.tag.startswith("macosx_") and self.tag.endswith("_arm64"):
            return "macos-arm64"
        if self.tag.startswith("manylinux") and self.tag.endswith("_x86_64"):
            return "linux-x64"
        raise ValueError(f"{self.filename}: no Blender platform is known for {self.tag}")


def pip_download(requirement: str, python: str, tags: set[str], folder: Path) -> str:
    """Fetches one wheel for CPython `python` ("311") and one of the platform `tags`.

    Returns pip's complaint, empty if the wheel is there.
    """
    command = [
        sys.executable,
        "-m",
        "pip",
        "download",
        "--quiet",
        "--no-deps",
        "--only-binary=:all:",
        "--implementation=cp",
        f"--python-version={python}",
        f"--dest={folder}",
        requirement,
    ]
    command += [f"--platform={tag}" for tag in sorted(tags)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    return result.stderr if result.returncode else ""


def fetch(wheels: list[Wheel]) -> None:
    """Fetches those of the manifest's wheels that `wheels/` does not hold yet."""
    for wheel in wheels:
        if not (WHEELS / wheel.filename).exists():
            print(f"fetching {wheel.filename}", flush=True)
            tags = set(wheel.tag.split("."))
            complaint = pip_download(f"{wheel.name}=={wheel.version}", wheel.python[2:], tags, WHEELS)
            if not (WHEELS / wheel.filename).exists():
                sys.exit(f"pip did not bring {wheel.filename}, which {MANIFEST} names\n{complaint}")


def fetch_for_python(wheels: list[Wheel], python: str) -> list[Wheel]:
    """The wheels' counterparts for another Python: of the same version, else of the newest one."""
    tags = {tag for wheel in wheels for tag in wheel.tag.split(".")}
    found = []
    for name, version in sorted({(wheel.name, wheel.version) for wheel in wheels}):
        with tempfile.TemporaryDirectory() as folder:
            for requirement in (f"{name}=={version}", f"{name}>{version}"):
                complaint = pip_download(requirement, python, tags, Path(folder))
                if not complaint:
                    break
            else:
                sys.exit(f"no wheel of {name} {version} or newer for Python {python}\n{complaint}")
            (path,) = Path(folder).iterdir()
            shutil.copy(path, WHEELS / path.name)
            found.append(Wheel.parse(path.name))
    return found


def toml_list(key: str, values: list[str]) -> str:
    return f"{key} = [\n" + "".join(f'  "{value}",\n' for value in values) + "]\n"


def stage(folder: Path, platforms: list[str], wheels: list[Wheel]) -> None:
    """Copies the source to `folder`, with these platforms and wheels in its manifest.

    The source itself stays as it is, and wheels of another Python never get into it.
    """
    ignore = shutil.ignore_patterns(".git", ".venv", "__pycache__", "build", "dist", "out", "wheels")
    shutil.copytree(ROOT, folder, ignore=ignore)
    (folder / "wheels").mkdir()
    for wheel in wheels:
        (folder / "wheels" / wheel.filename).symlink_to(WHEELS / wheel.filename)
    text = (ROOT / MANIFEST).read_text(encoding="utf-8")
    for key, values in {"platforms": platforms, "wheels": [f"./wheels/{w.filename}" for w in wheels]}.items():
        text, count = re.subn(rf"(?ms)^{key} = \[.*?\]\n", toml_list(key, values), text)
        if count != 1:
            sys.exit(f"{MANIFEST}: one list `{key}` is needed")
    (folder / MANIFEST).write_text(text, encoding="utf-8")


def extension_tool(blender: str | None) -> tuple[list[str], list[str]]:
    """The extension tool of this Blender, else of the installed bpy: its command and its verbs' options."""
    if blender:
        return [blender, "--command", "extension"], []
    bpy = importlib.util.find_spec("bpy")
    if bpy is None:
        sys.exit("give --blender, or run this with the Python of `make test`'s venv, which has bpy")
    (scripts,) = Path(bpy.origin).parent.glob("*/scripts")
    tags = scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    tool = scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"
    return [sys.executable, str(tool)], [f"--valid-tags={tags}"]


def check_windows_libraries(wheels: list[Wheel]) -> None:
    """Every DLL in a wheel's `.data` folder, which Blender 4.2 does not spread, must be in another wheel too.

    OpenEXR's wheel for Windows keeps its C++ runtime in such a folder. embreex has the same file in
    `embreex.libs`, which importing embreex puts on the DLL search path, and no bake writes an EXR before it
    has traced rays.
    """
    hidden, findable = set(), set()
    for wheel in wheels:
        if wheel.platform == "windows-x64" and wheel.python == "cp311":
            with zipfile.ZipFile(WHEELS / wheel.filename) as archive:
                for path in map(PurePosixPath, archive.namelist()):
                    if path.suffix == ".dll":
                        (hidden if path.parts[0].endswith(".data") else findable).add(path.name)
    if hidden - findable:
        sys.exit(f"Blender 4.2 on Windows would not find {sorted(hidden - findable)}")


def check(path: Path, wheels: list[Wheel]) -> None:
    """The zip holds the wheels of its platform, all of them and no other, and nothing that does not run."""
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read(MANIFEST).decode())
    generated = manifest.get("build", {}).get("generated", {})
    (platform,) = generated.get("platforms", manifest["platforms"])
    expected = {f"wheels/{wheel.filename}" for wheel in wheels if wheel.platform == platform}
    shipped = {name for name in names if name.endswith(".whl")}
    declared = {str(PurePosixPath(wheel)) for wheel in generated.get("wheels", manifest["wheels"])}
    if not expected or shipped != expected or declared != expected:
        sys.exit(f"{path}: wheels {sorted(shipped)}, declares {sorted(declared)}, not {sorted(expected)}")
    if alien := {PurePosixPath(name).parts[0] for name in names} - RUNTIME:
        sys.exit(f"{path}: does not belong in the zip: {sorted(alien)}")
    if any("__pycache__" in name or name.startswith("wheels/numpy") for name in names):
        sys.exit(f"{path}: byte code or numpy got in")
    print(f"{path}  {path.stat().st_size / 1e6:.1f} MB, {len(shipped)} wheels", flush=True)


def build(output: Path, platforms: list[str], wheels: list[Wheel], blender: str | None) -> None:
    """Validates the source, builds a zip a platform into `output`, validates and checks each."""
    command, options = extension_tool(blender)
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "multibounce_ao"
        stage(source, platforms, wheels)
        subprocess.run([*command, "validate", *options, str(source)], check=True)
        folders = [f"--source-dir={source}", f"--output-dir={output}"]
        subprocess.run([*command, "build", *options, *folders, "--split-platforms"], check=True)
    zips = sorted(output.glob("*.zip"))
    if len(zips) != len(platforms):
        sys.exit(f"{len(zips)} zips for {len(platforms)} platforms in {output}")
    for path in zips:
        subprocess.run([*command, "validate", *options, str(path)], check=True)
        check(path, wheels)


def main() -> None:
    with (ROOT / MANIFEST).open("rb") as file:
        manifest = tomllib.load(file)
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--platform", choices=manifest["platforms"], help="build for this platform alone")
    parser.add_argument("--python", metavar="3.N", help="put in the wheels of this Python alone")
    parser.add_argument("--output", type=Path, default=ROOT / "dist", help="emptied first (default: dist)")
    parser.add_argument("--blender", help="the Blender whose tool builds (default: that of the bpy module)")
    arguments = parser.parse_args()

    platforms = [arguments.platform] if arguments.platform else manifest["platforms"]
    wheels = [wheel for wheel in map(Wheel.parse, manifest["wheels"]) if wheel.platform in platforms]
    WHEELS.mkdir(exist_ok=True)
    if arguments.python:
        python = arguments.python.replace(".", "")
        supported = [wheel for wheel in wheels if wheel.python == f"cp{python}"]
        wheels = supported or [
            wheel
            for platform in platforms
            for wheel in fetch_for_python([wheel for wheel in wheels if wheel.platform == platform], python)
        ]
    fetch(wheels)
    check_windows_libraries(wheels)
    build(arguments.output.resolve(), platforms, wheels, arguments.blender)


if __name__ == "__main__":
    main()
