# SPDX-License-Identifier: GPL-3.0-or-later
"""Enables the extension in this process: in the bpy module the source tree, in Blender what is installed.

Environment: `MULTIBOUNCE_AO_PACKAGE` names an installed package to take instead of the source tree.
"""

import importlib.util
import os
from pathlib import Path
from types import ModuleType

INSTALLED = os.environ.get("MULTIBOUNCE_AO_PACKAGE")
PACKAGE = INSTALLED or "bl_ext.dev.multibounce_ao"
SOURCE = Path(__file__).resolve().parent.parent


def source_folder() -> Path:
    """The folder that the package is loaded from, without loading it; it holds `core`."""
    if INSTALLED:
        return Path(importlib.util.find_spec(INSTALLED).origin).parent
    return SOURCE


def _link_source() -> None:
    """Makes the source tree an extension of a repository `dev` among the user's extensions.

    Its wheels stay out: Blender would unpack them, and the bpy module has the same packages in its venv.
    """
    import bpy

    folder = Path(bpy.utils.user_resource("EXTENSIONS", path="dev/multibounce_ao", create=True))
    for entry in SOURCE.iterdir():
        if entry.name != "wheels" and not entry.name.startswith(".") and not (folder / entry.name).exists():
            (folder / entry.name).symlink_to(entry)
    repositories = bpy.context.preferences.extensions.repos
    if "dev" not in (repository.module for repository in repositories):
        repositories.new(name="dev", module="dev", source="USER")


def enable_extension() -> ModuleType:
    """Enables the extension as Blender's preferences do, and returns its package.

    Raises RuntimeError with the cause where Blender itself would print it and go on.
    """
    import bpy  # noqa: F401  first: it makes addon_utils importable
    from addon_utils import enable

    if not INSTALLED:
        _link_source()
    errors: list[Exception] = []
    module = enable(PACKAGE, default_set=True, handle_error=errors.append)
    if module is None:
        raise RuntimeError(f"{PACKAGE} could not be enabled") from (errors[0] if errors else None)
    return module
