# SPDX-License-Identifier: GPL-3.0-or-later
"""Every way to have the light of all bounces, beside Cycles' path tracing of the same scene: for docs/bounces.md."""
