"""Three pixels and five patches, small enough to be known by heart."""

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars

OUTCOMES, PATCHES, NOTHING = 6, 5, 5
"""Draws of a pixel, all as likely; the patches among them; and the one that is none."""

HIDDEN = 4
"""The patch that pixel 0 does not see, and others do."""

PLACE = np.array(
    [
        [0.5, 1.5, 0.25],
        [-1.0, 1.25, 0.5],
        [1.25, 1.0, -0.75],
        [-0.5, 2.0, -1.0],
        [0.25, 1.75, 1.0],
    ]
)
FACING = np.array(
    [
        [0.1, -1.0, 0.2],
        [0.5, -0.8, -0.3],
        [-0.6, -0.7, 0.3],
        [0.3, -0.9, 0.4],
        [0.2, -0.9, -0.3],
    ]
)
ALBEDO = np.array([0.8, 0.5, 0.3])
AREA = 0.05
WHOLE = np.array([1, 2, 1, 2, 1])
"""Weights that arrive at pixel 0, for M = 1."""

SEES = np.array([[1, 1, 1, 1, 0], [1, 0, 1, 0, 1], [1, 1, 0, 0, 1]], bool)
"""What stands between is data: patch 3 is for pixel 0 alone, and 4 for the others."""


@dataclass(frozen=True, slots=True, eq=False)
class Placement:
    """Where the pixels are.

    Attributes
    ----------
    name : str; how the pixels lie, for messages
    eye : (3, 3), m; visible points
    up : (3, 3); their unit normals
    """

    name: str
    eye: Scalars
    up: Scalars


NEAR = Placement(
    "pixels side by side",
    np.array([[0.0, 0.0, 0.0], [1.5, -0.25, 0.5], [-1.0, 0.5, 1.0]]),
    np.array([[0.0, 1.0, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.6, -0.8]]),
)
"""Jacobians from 0.57 to 3.6."""

FAR_NEIGHBORS = Placement(
    "neighbours far away",
    np.array([[0.0, 0.0, 0.0], [2.0, -16.0, 3.0], [-1.5, -3.0, 1.0]]),
    np.array([[0.0, 1.0, 0.0], [0.0, 0.96, -0.28], [0.0, 0.6, -0.8]]),
)
"""Jacobians from 67 to 134 from pixel 1, and from 6.4 to 9.5 from pixel 2."""

CLOSE_NEIGHBORS = Placement(
    "neighbours close by",
    np.array([[2.0, -16.0, 3.0], [0.0, 0.0, 0.0], [1.5, -5.0, -0.5]]),
    np.array([[0.0, 0.96, -0.28], [0.0, 1.0, 0.0], [-0.6, 0.8, 0.0]]),
)
"""Jacobians from 0.0074 to 0.015 from pixel 1, and from 0.12 to 0.16 from pixel 2."""


@dataclass(frozen=True, slots=True, eq=False)
class Theory:
    """What is known of the patches in a world.

    Attributes
    ----------
    solid_angle : (3, 5), sr; of each patch at each pixel
    mu : (3, 5), sr; the same, 0 where the pixel does not see the patch
    light : (6,); radiance of each patch, and of nothing
    normal : (6, 3); of each patch
    """

    solid_angle: Scalars
    mu: Scalars
    light: Scalars
    normal: Scalars


def theory(world: Placement = NEAR, target: str = "scattered") -> Theory:
    """Solid angles from their definition, and the radiances that make weights whole.

    Parameters
    ----------
    target : 'scattered' or 'outgoing'; what a weight is made of
    """
    normal = FACING / np.linalg.norm(FACING, axis=1, keepdims=True)
    v = PLACE[None] - world.eye[:, None]
    d = np.linalg.norm(v, axis=-1)
    facing = -np.einsum("ijk,jk->ij", v, normal) / d
    cosine = np.einsum("ijk,ik->ij", v, world.up) / d
    solid_angle = AREA * facing / d**2
    # Only SEES decides who holds what.
    assert (facing > 0).all()
    assert (cosine > 0).all()
    p_hat = WHOLE / (OUTCOMES * solid_angle[0])
    light = p_hat * pi / (ALBEDO[0] * cosine[0]) if target == "scattered" else p_hat
    up = np.array([[0.0, -1.0, 0.0]])
    return Theory(
        solid_angle,
        np.where(SEES, solid_angle, 0.0),
        np.append(light, 0.0),
        np.concatenate([normal, up]),
    )


def patch_reservoirs(
    world: Placement, target: str, who: int, cells: Indices, M: float
) -> dict[str, NDArray[np.float64]]:
    """Reservoirs of a pixel that hold patches.

    Parameters
    ----------
    cells : (N,) int; patches, or `NOTHING`
    M : float; confidence of them all

    Returns
    -------
    dict of str to array; five buffers; a null where the pixel does not see the patch
    """
    known = theory(world, target)
    place = np.concatenate([PLACE, [[0.0, 1.0, 0.0]]])
    mu = np.append(known.mu[who], 0.0)[cells]
    shines = (mu > 0)[:, None]
    return {
        "position": place[cells],
        "normal": known.normal[cells],
        "radiance": np.where(shines, known.light[cells][:, None], 0.0) * np.ones(3),
        "W": OUTCOMES * mu * (M > 0),
        "M": np.full(len(cells), float(M)),
    }


def eye(world: Placement, who: int, rows: int) -> dict[str, NDArray[np.float64]]:
    """Visible points: one pixel in every row.

    Parameters
    ----------
    rows : int; N
    """
    return {
        "visible_position": np.tile(world.eye[who], (rows, 1)),
        "visible_normal": np.tile(world.up[who], (rows, 1)),
        "albedo": np.full((rows, 3), ALBEDO[who]),
    }


def whole_weight(who: int, cells: Indices) -> Indices:
    """Weight at pixel 0 of what a pixel drew, for M = 1, (N,) int.

    J · W is `OUTCOMES` times the solid angle at pixel 0, whoever drew the patch, and p̂
    is `WHOLE` over the same: so it is a whole number for any J.

    Parameters
    ----------
    cells : (N,) int; patches, or `NOTHING`
    """
    held = np.append(SEES[who] & SEES[0], False)
    return np.where(held, np.append(WHOLE, 0), 0)[cells]


def visible_bits(viewers: Indices, cells: list[Indices]) -> NDArray[np.uint32]:
    """Bits of who sees which patch, (N, V).

    Parameters
    ----------
    viewers : (V,) int; pixels, a column each; -1 for none
    cells : list of (N,) int; patches, a bit each
    """
    sees = np.concatenate([SEES, np.zeros((3, 1), bool)], axis=1)
    words = np.zeros((len(cells[0]), len(viewers)), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, cell in enumerate(cells):
            if viewer >= 0:
                seen = sees[viewer][cell].astype(np.uint32)
                words[:, column] |= seen << np.uint32(bit)
    return words
