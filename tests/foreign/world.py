"""A world of four pixels and seven patches, small enough to enumerate, in float64.

A patch is so small that it is a point with an area: its solid angle mu from a pixel is
area · cos φ / d², and Equation 11 is the exact ratio of two of them.  Shifts to the
receiver have J from 0.04 to 22.  Two patches are hidden from a neighbour, one from the
receiver; some are below a horizon, or show their back, though nothing hides them; one
is black to a pixel whose albedo has no red.
"""

from typing import NamedTuple

import numpy as np

NULL = 7
"""Outcome of a ray that meets nothing."""

OUTCOMES = 8

RECEIVER, LEFT, RIGHT, BEFORE = range(4)
"""Pixels: that which is judged, two neighbours, and where the first stood before."""


def unit(v):
    """Unit vectors of rows."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


EYE = np.array([[0, 0, 0], [1.5, 0.1, 0.3], [-1.2, 0.2, 0.8], [0.4, -0.1, -1.2]])
UP = unit(np.array([[0, 1, 0], [-0.1, 1, 0.1], [0.5, 0.8, -0.2], [0.1, 0.95, 0.2]]))
ALBEDO = np.array([[0.8, 0.5, 0.3], [0.6, 0.6, 0.2], [0, 0.6, 0.4], [0.7, 0.4, 0.4]])

PLACE = np.array(
    [
        [-0.26, 1.4, -0.35],  # all see it
        [1.8, 0.25, 0.21],  # J = 0.04 from the left; red
        [0.24, 0.88, -0.21],  # J = 18 from the left; blue; hidden from the right
        [-0.66, 0.35, -0.59],  # J = 13 from the right; green; hidden from the left
        [0.51, 0.49, -1.74],  # hidden from the receiver
        [-1.54, 0.44, 1.46],  # back to the left, below the horizon of the right
        [1.71, 1.39, 0.51],  # back to the receiver
    ]
)
FACING = unit(
    np.array(
        [
            [1, -7, 6],
            [-1, 0, 0],
            [-7, -11, 7],
            [5, 0, 3],
            [1, -10, 1],
            [-7, -10, -10],
            [8, -5, -2],
        ]
    )
)
LIGHT = np.array(
    [[2, 2, 1], [9, 0, 0], [0, 0, 9], [0, 4, 0], [3, 3, 2], [1, 2, 3], [4, 3, 3]]
)
MIXED = (LIGHT > 0).all(axis=1)
"""Patches whose light has every channel."""

AREA = np.array([4, 3, 1, 2, 1, 8, 5])
SEES = np.array(
    [
        [1, 1, 1, 1, 0, 1, 1],
        [1, 1, 1, 0, 1, 1, 1],
        [1, 1, 0, 1, 1, 1, 1],
        [1, 1, 1, 0, 1, 1, 1],
    ],
    bool,
)
CHANCE = np.array([1, 2, 1.5, 1, 2, 1.2, 0.8])
"""How often a pixel draws each patch of those that it can, beside each other."""

NOTHING = 0.15
"""How often its ray meets nothing."""


class PatchTheory(NamedTuple):
    """What is true of each pixel and patch, (4, 7).

    Attributes
    ----------
    size : solid angle, whatever stands between
    held : bool; above the horizon, facing the pixel, and not hidden
    chance : with which it is drawn
    integrand : (4, 7, 3); albedo / π · cos θ · L_o, 0 where it is not held
    """

    size: np.ndarray
    held: np.ndarray
    chance: np.ndarray
    integrand: np.ndarray


def theory():
    """All of it, from the definitions."""
    v = PLACE - EYE[:, None]
    d = np.linalg.norm(v, axis=-1)
    cosine = np.einsum("pxi,pi->px", v, UP) / d
    facing = -np.einsum("pxi,xi->px", v, FACING) / d
    held = SEES & (cosine > 0) & (facing > 0)
    chance = CHANCE * held
    chance *= (1 - NOTHING) / chance.sum(axis=1, keepdims=True)
    f = ALBEDO[:, None] / np.pi * (cosine * held)[..., None] * LIGHT
    return PatchTheory(AREA * np.abs(facing) / d**2, held, chance, f)


def point(who, rows, prefix=""):
    """Visible points of a pixel, in every row."""
    of = {"visible_position": EYE, "visible_normal": UP, "albedo": ALBEDO}
    return {prefix + n: np.tile(a[who], (rows, 1)).astype("f4") for n, a in of.items()}


def samples(cells, nulls="ordinary"):
    """Samples of outcomes; nulls stand on a far wall, or nowhere.

    Parameters
    ----------
    cells : (N,) int; patches, or `NULL`
    nulls : 'ordinary' or 'degenerate'
    """
    far = nulls == "ordinary"
    place = [0.0, 90.0, 0.0] if far else [0.0, 0.0, 0.0]
    facing = [0.0, -1.0, 0.0] if far else [-0.0, -0.0, -0.0]
    of = {
        "position": np.vstack([PLACE, place]),
        "normal": np.vstack([FACING, facing]),
        "radiance": np.vstack([LIGHT, np.zeros(3)]),
    }
    return {name: array[cells].astype("f4") for name, array in of.items()}


def density(who):
    """Source density of each outcome of a pixel, (8,); 1 for those that it cannot."""
    known = theory()
    drawn = known.chance[who] > 0
    pdf = np.where(drawn, known.chance[who] / known.size[who], 1.0)
    return np.append(pdf, 0.159).astype("f4")


def probability(who):
    """Of each outcome of a pixel, (8,)."""
    return np.append(theory().chance[who], NOTHING)


def patch_of(position):
    """Patch on which samples lie, (N,); `NULL` for none."""
    d = np.linalg.norm(position[:, None].astype(float) - PLACE, axis=-1)
    return np.where(d.min(axis=1) < 1e-2, d.argmin(axis=1), NULL)
