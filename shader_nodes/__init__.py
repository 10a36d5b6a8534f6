# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups for Cycles and EEVEE, built in code: one group a file, each with ``NAME`` and ``ensure()``.

``expression`` lets a group's source read like its formula, ``layout`` makes the result readable for an artist,
``group`` keeps one copy of each group in the file and brings old copies up to date.
"""
