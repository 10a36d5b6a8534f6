# SPDX-License-Identifier: GPL-3.0-or-later
"""What tells bakes apart: their values, not where these lie in memory."""

from types import SimpleNamespace

import numpy as np

from .bakes import operators


def colours(red=0.8, **other):
    """As base colours are held: objects in lists of objects, with arrays."""
    return SimpleNamespace(sources=[SimpleNamespace(values=np.array([[red, 0.5, 0.2]]))], row=np.zeros(3, int), **other)


def test_equal_values_are_equal():
    fingerprint = operators("fingerprint").fingerprint
    assert fingerprint("1.0", colours()) == fingerprint("1.0", colours())


def test_each_value_counts():
    fingerprint = operators("fingerprint").fingerprint
    parts = [("1.0", colours()), ("1.1", colours()), ("1.0", colours(red=0.81)), ("1.0", colours(scale=2.0)), ("1.0",)]
    parts += [(np.zeros(4),), (np.zeros((2, 2)),), (np.zeros(4, np.float32),), ([1, 2], 3), ([1], 2, 3)]
    assert len({fingerprint(*each) for each in parts}) == len(parts)
