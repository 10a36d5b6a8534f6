# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender tells where a bake is refused."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest


def error_of(call: Callable[[], object]) -> str:
    """The message of an operator that gives up."""
    with pytest.raises(RuntimeError) as caught:
        call()
    return str(caught.value).removeprefix("Error: ").strip()


def assert_one_sentence(message: str, name: str = "Bad") -> None:
    """It names the object, says what to do after the colon, and does not talk like a program."""
    assert message.startswith(f"Object '{name}' ")
    assert re.search(": [a-z]", message)
    assert "\n" not in message
    assert not re.search(r"Error|Traceback|None|_|array|Exception", message)
