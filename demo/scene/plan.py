# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes that several parts share, in metres. The wall's face is the plane y = 0, the viewer is at negative y."""

NICHE_RADIUS = 1.1
NICHE_FLANK = 0.25
NICHE_DEPTH = 0.85
SILL = 0.85
SPRING = 2.2
RING_WIDTH = 0.36
RING_PROUD = 0.07
SILL_THICKNESS = 0.14
SILL_PROUD = 0.30
SILL_HALF = NICHE_RADIUS + RING_WIDTH + 0.12
COURSE = SILL / 5
