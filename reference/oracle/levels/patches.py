"""Three pixels and four patches, small enough to be known by heart."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars

OUTCOMES, NOTHING = 5, 4

PLACE = np.array(
    [[0.5, 1.5, 0.25], [-1.0, 1.25, 0.5], [1.25, 1.0, -0.75], [-0.5, 2.0, -1.0]]
)
FACING = np.array(
    [[0.1, -1.0, 0.2], [0.5, -0.8, -0.3], [-0.6, -0.7, 0.3], [0.3, -0.9, 0.4]]
)
EYE = np.array([[0.0, 0.0, 0.0], [1.5, -0.25, 0.5], [-1.0, 0.5, 1.0]])
UP = np.array([[0.0, 1.0, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.6, -0.8]])
ALBEDO = np.array([0.8, 0.5, 0.3])
AREA = 0.05
WHOLE = np.array([1, 2, 1, 2, 0])
"""Weights that arrive at q, for M = 1; nothing weighs nothing."""

TRUST = np.array([1, 2, 1])
"""Confidences of the reservoirs of q and of the others."""

SEES = np.array([[1, 1, 1, 1], [1, 0, 1, 1], [1, 1, 0, 1]], bool)
"""What stands between is data."""


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """What is known of the patches.

    Attributes
    ----------
    mu : (3, 4); solid angle of each patch from each pixel; 0 where it is not held
    light : (5,); radiance of each patch, and of nothing
    normal : (5, 3); of each patch
    """

    mu: Scalars
    light: Scalars
    normal: Scalars


def theory() -> Theory:
    """Solid angles from their definition, and the radiances that make weights whole."""
    normal = FACING / np.linalg.norm(FACING, axis=1, keepdims=True)
    v = PLACE[None] - EYE[:, None]
    d = np.linalg.norm(v, axis=-1)
    facing = -np.einsum("ijk,jk->ij", v, normal) / d
    cosine = np.einsum("ijk,ik->ij", v, UP) / d
    mu = AREA * facing / d**2
    held = SEES & (cosine > 0) & (facing > 0)
    assert held[0].all()  # weights at q would not be whole
    p_hat = WHOLE[:4] / (OUTCOMES * mu[0])
    light = p_hat * pi / (ALBEDO[0] * cosine[0])
    up = np.array([[0.0, -1.0, 0.0]])
    return Theory(
        np.where(held, mu, 0.0), np.append(light, 0.0), np.concatenate([normal, up])
    )


def patch_reservoirs(who: int, cells: Indices) -> dict[str, NDArray[np.float64]]:
    """Reservoirs of a pixel that hold patches.

    Parameters
    ----------
    cells : (N,) int; patches, or `NOTHING`

    Returns
    -------
    dict of str to array; five buffers; empty where the pixel does not hold the patch
    """
    known = theory()
    place = np.concatenate([PLACE, [[0.0, 1.0, 0.0]]])
    mu = np.append(known.mu[who], 0.0)[cells]
    shines = (mu > 0)[:, None]
    return {
        "position": place[cells],
        "normal": known.normal[cells],
        "radiance": np.where(shines, known.light[cells][:, None], 0.0) * np.ones(3),
        "W": OUTCOMES * mu,
        "M": np.full(len(cells), float(TRUST[who])),
    }


def eye(who: int, rows: int) -> dict[str, NDArray[np.float64]]:
    """Visible points: one pixel in every row.

    Parameters
    ----------
    rows : int; N
    """
    return {
        "visible_position": np.tile(EYE[who], (rows, 1)),
        "visible_normal": np.tile(UP[who], (rows, 1)),
        "albedo": np.full((rows, 3), ALBEDO[who]),
    }


def whole_weight(who: int, cells: Indices) -> Indices:
    """Weight at pixel 0 of what a pixel drew, for M = 1.

    Parameters
    ----------
    cells : (N,) int; patches, or `NOTHING`

    Returns
    -------
    (N,) int; a whole number by construction
    """
    return np.where(np.append(theory().mu[who], 0.0)[cells] > 0, WHOLE[cells], 0)


def visible_bits(viewers: Indices, cells: list[Indices]) -> NDArray[np.uint32]:
    """Bits of who sees which patch, (N, V).

    Parameters
    ----------
    viewers : (V,) int; pixels, a column each
    cells : list of (N,) int; patches, a bit each
    """
    sees = np.concatenate([SEES, np.zeros((3, 1), bool)], axis=1)
    words = np.zeros((len(cells[0]), len(viewers)), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, cell in enumerate(cells):
            words[:, column] |= sees[viewer][cell].astype(np.uint32) << np.uint32(bit)
    return words
