# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of what a bake leaves, which shaders, scripts and other programs look up."""

MULTIBOUNCE_AO = "Multibounce AO"
"""Attribute or image: F0, F1, F2, T."""

BENT_CONE = "Bent Cone"
"""Attribute or image: mean visible direction x, y, z, and alpha."""

CHANNELS = (MULTIBOUNCE_AO, BENT_CONE)
"""What every bake leaves, as attributes or as images."""

PROPERTY = "multibounce_ao"
"""ID property: on objects what was baked, on materials, images and nodes that they are ours."""
