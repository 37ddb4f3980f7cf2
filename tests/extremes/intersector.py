"""Rays against triangles by brute force in float64: an oracle that knows no tree."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Crossings:
    """Every ray with every triangle: (N, T)."""

    inside: np.ndarray
    """Distance from the ray to the nearest edge, negative where the ray passes by."""
    distance: np.ndarray
    """Along the ray, to the plane."""
    slope: np.ndarray
    """|cos| of the ray with the plane's normal."""


def cross_all(origin, direction, corners):
    """Crossings of N rays with T triangles, each by volumes spanned with its edges."""
    a, b, c = (corners[None, :, i] - origin[:, None] for i in range(3))
    d = direction[:, None]
    sides = []
    for p, q in ((a, b), (b, c), (c, a)):
        # The volume over the area spanned by ray and edge: how far they pass apart.
        area = np.linalg.norm(np.cross(q - p, d), axis=-1)
        volume = np.einsum("nti,nti->nt", np.cross(p, q), np.broadcast_to(d, p.shape))
        sides.append(np.divide(volume, area, out=np.zeros_like(area), where=area > 0))
    one_way, other_way = np.min(sides, axis=0), np.min(np.negative(sides), axis=0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    slope = np.einsum("nti,nti->nt", normal, np.broadcast_to(d, normal.shape))
    height = np.einsum("nti,nti->nt", normal, a)
    endless = np.full_like(height, np.inf)
    distance = np.divide(height, slope, out=endless, where=slope != 0)
    return Crossings(np.maximum(one_way, other_way), distance, np.abs(slope))


@dataclass(frozen=True)
class RayJudgement:
    """What an intersector that is off by some margin may answer."""

    legal: np.ndarray
    """(N,) whether the answer is one of those."""
    forced: np.ndarray
    """(N,) whether there is but one."""


def judge(crossings, primitive, margin):
    """Judge the triangles that an intersector named; -1 for none.

    A triangle is surely hit where the ray passes more than the margin within its edges
    and starts more than that before it, and possibly hit where it does so less the
    margin.  An answer is legal if it is possible, and not behind a sure hit.
    """
    blur = margin / np.maximum(crossings.slope, 1e-300)
    sure = (crossings.inside > margin) & (crossings.distance > blur)
    possible = (crossings.inside > -margin) & (crossings.distance > -blur)
    latest = np.where(sure, crossings.distance + blur, np.inf).min(axis=1)
    earliest = crossings.distance - blur
    candidate = possible & (earliest <= latest[:, None])
    row = np.arange(len(primitive))
    named = candidate[row, np.maximum(primitive, 0)]
    legal = np.where(primitive >= 0, named, ~sure.any(axis=1))
    choices = candidate.sum(axis=1) + ~sure.any(axis=1)
    return RayJudgement(legal, choices == 1)
