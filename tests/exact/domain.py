"""A world so small that all of it can be written down in fractions.

Three pixels at rational points look at six cells, small facets at rational points whose
distances to all three are rational too: (6, 6, 3) is 9, 7 and 23 away.  So the
*production* Jacobian runs on it without rounding, and every measure is known:

    mu_i(x) = A_x |cos φ| / d²,  the solid angle of cell x from pixel i.

Supports differ: a cell may be hidden from a pixel, or below its horizon.

======  ===========  ==================  ===========
cell    pixel 0      pixel 1             pixel 2
======  ===========  ==================  ===========
0       sees         sees                sees
1       sees         below its horizon   sees
2       sees         sees                hidden
3       hidden       sees                sees
4       sees         hidden              sees
5       sees         below its horizon   hidden
======  ===========  ==================  ===========

Cell 5 is a null for all but pixel 0.  Index 6, ``NOTHING``, stands for a ray that
leaves the scene.  No target is proportional to a source density, nor to another
pixel's target.
"""

from fractions import Fraction
from math import isqrt

import numpy as np

from restir_gi.reference.numerics.arrays import dot

PIXELS, CELLS = range(3), range(6)
NOTHING = len(CELLS)


def rationals(rows):
    """Array of fractions."""
    return np.array([[Fraction(v) for v in row] for row in rows], object)


EYE = rationals([[0, 0, 0], [8, 0, 0], [28, 0, 0]])
CELL = rationals(
    [[6, 6, 3], [4, 12, 3], [8, 12, 9], [14, 12, 12], [18, 24, 0], [28, 21, 0], [0] * 3]
)
NORMAL = rationals(
    [
        [0, -1, 0],
        [Fraction(3, 5), Fraction(-4, 5), 0],
        [Fraction(-2, 3), Fraction(-2, 3), Fraction(-1, 3)],
        [0, Fraction(-4, 5), Fraction(-3, 5)],
        [Fraction(-6, 7), Fraction(-3, 7), Fraction(2, 7)],
        [Fraction(-3, 5), Fraction(-4, 5), 0],
        [0, -1, 0],
    ]
)
AREA = [
    Fraction(9),
    Fraction(16),
    Fraction(20),
    Fraction(30),
    Fraction(100),
    Fraction(75),
]

# The table of supports, as two reasons for a 0.
SEES = np.array([[1, 1, 1, 0, 1, 1], [1, 1, 1, 1, 0, 1], [1, 1, 0, 1, 1, 0]], bool)
ABOVE = np.array([[1, 1, 1, 1, 1, 1], [1, 0, 1, 1, 1, 0], [1, 1, 1, 1, 1, 1]], bool)
HOLDS = SEES & ABOVE

SOURCE = [
    [
        Fraction(1, 6),
        Fraction(1, 4),
        Fraction(1, 8),
        Fraction(0),
        Fraction(1, 12),
        Fraction(1, 8),
    ],
    [
        Fraction(1, 5),
        Fraction(0),
        Fraction(3, 10),
        Fraction(1, 4),
        Fraction(0),
        Fraction(0),
    ],
    [
        Fraction(1, 3),
        Fraction(1, 9),
        Fraction(0),
        Fraction(1, 6),
        Fraction(2, 9),
        Fraction(0),
    ],
]
"""Probability that a ray of a pixel meets a cell; the rest meets nothing."""

TARGET = [
    [
        Fraction(2),
        Fraction(1, 3),
        Fraction(3),
        Fraction(1, 2),
        Fraction(5),
        Fraction(1),
    ],
    [Fraction(1), Fraction(0), Fraction(4), Fraction(2, 5), Fraction(7), Fraction(0)],
    [
        Fraction(3, 2),
        Fraction(6),
        Fraction(1, 4),
        Fraction(1),
        Fraction(2),
        Fraction(5),
    ],
]
"""p̂ of a cell at a pixel, without visibility, 0 below the horizon."""


def distance(i, x):
    """Distance of pixel and cell, by integer square root."""
    offset = (EYE[i] - CELL[x])[None]
    squared = dot(offset, offset)[0]
    root = isqrt(squared.numerator)
    assert squared.denominator == 1
    assert root**2 == squared.numerator
    return Fraction(root)


def solid_angle(i, x):
    """mu_i(x) = A |n·v| / |v|³, from its definition."""
    return AREA[x] * abs(dot(NORMAL[x], EYE[i] - CELL[x])) / distance(i, x) ** 3


MU = np.array([[solid_angle(i, x) for x in CELLS] for i in PIXELS], object)
"""Measure of cell x at pixel i, in the measure's own right, with no Jacobian."""
