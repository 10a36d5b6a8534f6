# SPDX-License-Identifier: GPL-3.0-or-later
"""A font of straight strokes, for labels of plots at any size.

Each glyph is a word a stroke, and two digits a point of it: x to the right, y down, in a grid whose capitals stand on
line 6 and reach line 0; small letters reach line 2, and descend to line 8. A stroke of one point is a dot.
"""

from __future__ import annotations

import unicodedata

import numpy as np
from numpy.typing import NDArray

CAP_HEIGHT = 6
"""Grid units from the baseline to the top of capitals."""

LINE_HEIGHT = 11
"""Grid units from one baseline to the next."""

_GAP, _SPACE = 2, 3  # grid units between glyphs, and of a space between its neighbours

_GLYPHS = {
    "A": "062046 1434", "B": "06003041423303 3344453606", "C": "4130100105163645", "D": "00304145360600",
    "E": "40000646 0333", "F": "400006 0333", "G": "41301001051636454323", "H": "0006 4046 0343",
    "I": "0020 1016 0626", "J": "4045361605", "K": "0006 4004 1346", "L": "000646", "M": "0600234046",
    "N": "06004640", "O": "104051554616050110", "P": "06003041423303", "Q": "104051554616050110 3456",
    "R": "06003041423303 2346", "S": "413010010213334445361605", "T": "0040 2026", "U": "000516364540",
    "V": "002640", "W": "0016223640", "X": "0046 4006", "Y": "002340 2326", "Z": "00400646",
    "a": "12324346 441405163645", "b": "0006 0312324345361605", "c": "4332120305163645",
    "d": "4046 4332120305163645", "e": "0444433212030516364645", "f": "30201116 0232",
    "g": "4332120305163645 4247381807", "h": "0006 0312324346", "i": "0206 00", "j": "121708 10",
    "k": "0006 3205 1436", "l": "000516", "m": "0206 03122326 23324346", "n": "0206 0312324346",
    "o": "123243453616050312", "p": "0208 0312324345361605", "q": "4248 4332120305163645", "r": "0206 031232",
    "s": "43321203143445361605", "t": "10152636 0232", "u": "0205163645 4246", "v": "022642", "w": "0216243642",
    "x": "0246 4206", "y": "0226 4218", "z": "02420646",
    "0": "103041453616050110", "1": "112026 1636", "2": "01103041420646", "3": "011030414233 1333 334445361605",
    "4": "36300444", "5": "400003334445361605", "6": "413010010516364544331304", "7": "004016",
    "8": "103041423313020110 1304051636454433", "9": "051636454130100102133342",
    ".": "06", ",": "1607", ":": "03 06", ";": "13 1607", "!": "0004 06", "?": "0110304142332324 26", "'": "0001",
    '"': "0001 2021", "`": "0011", "-": "0333", "+": "2125 0343", "=": "0242 0444", "_": "0747", "~": "03123443",
    "*": "2024 0143 0341", "/": "4006", "\\": "0046", "|": "0007", "(": "20110526", ")": "00111506", "[": "10000616",
    "]": "00101606", "{": "20111203141526", "}": "00111223141506", "<": "410345", ">": "014305", "^": "022042",
    "#": "1016 3036 0242 0444", "$": "413010010213334445361605 2026", "%": "4006 0010110100 3545463635",
    "&": "46121120310405162644", "@": "3212143432 344441301001051646",
}  # fmt: skip
_UNKNOWN = "0040460600"  # a box, for what the font does not have


def text_strokes(text: str) -> tuple[NDArray[np.float64], float]:
    """Segments (n, 2 ends, 2) of one line of ``text`` in grid units, and its width. Letters lose their accents."""
    letters = [char for char in unicodedata.normalize("NFKD", text) if not unicodedata.combining(char)]
    segments, x, width = [np.empty((0, 2, 2))], 0.0, 0.0
    for letter in letters:
        if letter.isspace():
            x += _SPACE
            continue
        glyph = _glyph(_GLYPHS.get(letter, _UNKNOWN))
        segments.append(glyph + np.array((x, 0.0)))
        width = x + glyph[..., 0].max()
        x = width + _GAP
    return np.concatenate(segments), width


def _glyph(strokes: str) -> NDArray[np.float64]:
    """Segments (n, 2 ends, 2) of one glyph, moved so that it begins at x = 0."""
    segments = []
    for stroke in strokes.split():
        points = np.array([int(digit) for digit in stroke], float).reshape(-1, 2)
        ends = points if len(points) == 1 else points[1:]
        segments.append(np.stack((points[: len(ends)], ends), axis=1))
    glyph = np.concatenate(segments)
    glyph[..., 0] -= glyph[..., 0].min()
    return glyph
