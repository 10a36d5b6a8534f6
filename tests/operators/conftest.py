# SPDX-License-Identifier: GPL-3.0-or-later
import pytest


@pytest.fixture(autouse=True)
def scene(empty_scene):
    """Every test here begins with an empty scene."""
    return empty_scene


@pytest.fixture
def fitted(scene):
    """Bounces by the published fit: what the test is about is the same with either, and this is faster."""
    scene.multibounce_ao.bounces = "FITTED"
