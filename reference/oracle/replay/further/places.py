"""Rows of the last frame, and what they saw."""

from math import cos, radians

import numpy as np

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.replay.bounded import Bounded, exact
from restir_gi.reference.oracle.replay.further.camera import Eye
from restir_gi.reference.oracle.replay.further.rules import further
from restir_gi.reference.oracle.replay.neighbors import similarity
from restir_gi.reference.oracle.replay.rules import Rules


def rows_at(x: Bounded, y: Bounded, eye: Eye, border: str) -> list[Indices]:
    """Rows at places of the image.

    Parameters
    ----------
    x, y : Bounded; (N,), pixels
    border : str; what becomes of places outside

    Returns
    -------
    list of (N,) int
        The exact row first, then those at the corners of the bounds; −1 for none.
    """
    with np.errstate(invalid="ignore"):
        ends = [(v.value - v.error, v.value + v.error) for v in (x, y)]
    corners = [(at_x, at_y) for at_x in ends[0] for at_y in ends[1]]
    places = ((x.value, y.value), *corners)
    return [_row_at(at_x, at_y, eye, border) for at_x, at_y in places]


def _row_at(x: Scalars, y: Scalars, eye: Eye, border: str) -> Indices:
    """−1 outside and for what is no number."""
    width, height = eye.width.value[0], eye.height.value[0]
    column, line = _whole(x, width, border), _whole(y, height, border)
    inside = (column >= 0) & (column < width + (border == "wide"))
    inside &= (line >= 0) & (line < height)
    column, line = (np.where(inside, v, -1.0).astype(np.int64) for v in (column, line))
    row = line * int(width) + column
    return np.where(inside & (row < width * height), row, -1)


def _whole(place: Scalars, count: float, border: str) -> Scalars:
    """Column or line of a place, also outside of the image; it never falls."""
    whole: Scalars = np.floor(place)
    if border == "truncated":
        return np.where((place > -1) & (whole < 0), 0.0, whole)
    return whole.clip(0, count - 1) if border == "clamped" else whole


def may_hold(row: Indices, x: Bounded, y: Bounded, eye: Eye, border: str) -> Masks:
    """Whether the pixel of a row may hold a place, (N,) bool; False for what is no row.

    Parameters
    ----------
    row : (N,) int; pixels
    x, y : Bounded; (N,), pixels
    border : str; what becomes of places outside
    """
    width, height = int(eye.width.value[0]), int(eye.height.value[0])
    line, column = np.divmod(row, width)
    may: Masks = (row >= 0) & (row < width * height)
    at_x = _between(x, column, width, border)
    if border == "wide":
        # The column after the last is the first one of the next line.
        beyond = (column == 0) & _between(x, column + width, width, border)
        before = beyond & _between(y, line - 1, height, border)
        may &= (at_x & _between(y, line, height, border)) | before
    else:
        may &= at_x & _between(y, line, height, border)
    return may


def _between(place: Bounded, at: Indices, count: int, border: str) -> Masks:
    """Whether a column or line is within the bounds of a place."""
    least, most = (
        _whole(end, count, border)
        for end in (place.value - place.error, place.value + place.error)
    )
    # A bound that is no number excludes nothing.
    between: Masks = ~(at > most) & ~(at < least)
    return between


def alike_at(case: Case, row: Indices, depth: Bounded, rules: Rules) -> Bounded:
    """Positive where points are similar to what rows of the last frame saw.

    Parameters
    ----------
    row : (N,) int; of the last frame, or −1
    depth : Bounded; (N,): of the points, in the last frame

    Returns
    -------
    Bounded; (N,), negative where there is no row
    """
    rounding, part = depth.rounding, further(rules)
    there, own = np.maximum(row, 0), np.arange(case.rows)
    normal_row = own if part.own_normal_asked else there
    depth_row = own if part.own_depth_asked else there
    max_depth = float(case.settings["max_depth"])
    # The limit max_depth · max(z, z_row) has its share of the error of z.
    whole = Bounded(depth.value, depth.error * (1 + max_depth), rounding)
    angle = radians(float(case.settings["max_angle"]))
    found = similarity(
        exact(case.inputs["normal"], rounding),
        whole,
        exact(case.inputs["normal_before"][normal_row], rounding),
        exact(case.inputs["depth_before"][depth_row], rounding),
        cos(angle) if part.compares_normals else -2.0,
        max_depth,
        rules,
    )
    nowhere = row < 0
    if not part.compares_anything:
        found = Bounded(np.ones(case.rows), np.zeros(case.rows), rounding)
    return Bounded(
        np.where(nowhere, -1.0, found.value),
        np.where(nowhere, 0.0, found.error),
        rounding,
    )
