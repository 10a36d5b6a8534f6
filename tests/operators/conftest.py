# SPDX-License-Identifier: GPL-3.0-or-later
import pytest


@pytest.fixture(autouse=True)
def scene(empty_scene):
    """Every test here begins with an empty scene."""
    return empty_scene
