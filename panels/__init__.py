# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar of the 3D viewport."""
