# SPDX-License-Identifier: GPL-3.0-or-later
"""A terracotta urn that is put down on the paving when all else is baked: the field's turn."""

import bpy
import numpy as np

from . import palette
from .lathe import lathe
from .patches import add_object

PLACE = (-0.35, -1.75, 0.0)


def add(material) -> bpy.types.Object:
    """The urn, hidden in renders: there it blocks no light and is not seen, until the demo puts it down."""
    # Up the outside from the foot to the lip, and down the inside.
    radii = [0.16, 0.17, 0.11, 0.20, 0.27, 0.25, 0.14, 0.19, 0.17, 0.115, 0.22, 0.24, 0.17, 0.01]
    heights = [0.0, 0.03, 0.07, 0.20, 0.36, 0.50, 0.62, 0.70, 0.70, 0.62, 0.50, 0.36, 0.20, 0.10]
    urn = add_object("Urn", lathe(np.stack([radii, heights], axis=-1), 16, palette.TERRACOTTA), material)
    urn.location = PLACE
    urn.hide_render = True
    return urn
