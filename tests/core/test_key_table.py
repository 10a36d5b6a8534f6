# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys found as a dictionary finds them."""

import numpy as np
import pytest

from core.key_table import KeyTable


@pytest.mark.parametrize("count", [0, 1, 5, 3000])
@pytest.mark.parametrize("kind", ["near one another", "anywhere", "multiples of a large power of two"])
def test_finds_what_a_dictionary_finds(count, kind):
    random = np.random.default_rng(count)
    if kind == "near one another":
        keys = random.permutation(4 * count)[:count].astype(np.int64)
    elif kind == "anywhere":
        keys = np.unique(random.integers(0, 2**63 - 1, count))
    else:
        keys = np.arange(count, dtype=np.int64) << 40
    asked = np.concatenate((keys, keys + 1, [-1, -2, 2**62], random.integers(0, 2**63 - 1, 500)))
    known = {key: index for index, key in enumerate(keys.tolist())}
    np.testing.assert_array_equal(KeyTable(keys).find(asked), [known.get(key, -1) for key in asked.tolist()])
