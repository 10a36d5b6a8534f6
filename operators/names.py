# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of what a bake leaves, which shaders, scripts and other programs look up."""

MULTIBOUNCE_AO = "Multibounce AO"
"""Attribute or image: F0, F1, F2, T."""

BENT_CONE = "Bent Cone"
"""Attribute or image: mean visible direction x, y, z, and alpha."""

BENT_NORMAL = "Bent Normal"
"""Image: the bent direction as a normal map, red, green and blue."""

RADIOSITY = "Multibounce Radiosity"
"""Attribute or image: E/E0 in red, green and blue, and F0."""

AO_MAP = "AO"
"""Image: F0 as grey, for other programs."""

COLORED_AO_MAP = "Colored AO"
"""Image: E/E0 in red, green and blue, for other programs."""

CHANNELS = {
    "FITTED": (MULTIBOUNCE_AO, BENT_CONE),
    "BAKED": (MULTIBOUNCE_AO, BENT_CONE),
    "RADIOSITY": (RADIOSITY, BENT_CONE),
}
"""What a bake leaves, as attributes or as images, for each kind of bounces."""

ALL_CHANNELS = (MULTIBOUNCE_AO, RADIOSITY, BENT_CONE)
"""What all bakes of an object may have left."""

MEANINGS = {
    MULTIBOUNCE_AO: ("F0", "F1", "F2", "T"),
    RADIOSITY: ("red", "green", "blue", "F0"),
    BENT_CONE: ("x", "y", "z", "alpha"),
    BENT_NORMAL: ("x", "y", "z"),
    AO_MAP: ("F0", "F0", "F0"),
    COLORED_AO_MAP: ("red", "green", "blue"),
}
"""What red, green, blue and alpha of each hold."""

PROPERTY = "multibounce_ao"
"""ID property: on objects what was baked, on materials, images and nodes that they are ours."""
