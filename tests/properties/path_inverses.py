"""Random numbers that draw given directions, by iteration.

Nothing here knows a density: directions come from the production sampler, which
Newton's method inverts.
"""

from functools import partial

import numpy as np

from restir_gi.reference.numerics.arrays import dot
from restir_gi.reference.numerics.frames import normal_frames
from restir_gi.reference.numerics.records import take
from restir_gi.reference.scene.materials.bsdf_sampling import sample
from tests.properties.path_scenes import UNIT

SMALL = 64 * UNIT
"""What is left is the rounding of the sampler itself."""

EDGE = 1e-5
"""Newton's method keeps the first number so far from 0 and 1."""

STEP = 1e-6
"""Of the differences by which it finds its way; they do not touch where it ends."""


def directions(w, x, u, lobe=0.0):
    """Where points are left with the two numbers of each row."""
    lane = np.broadcast_to(lobe, len(u))
    return sample(w.materials, x, (lane, u[:, 0], u[:, 1], lane)).wi


def miss(w, x, u, target, lobe=0.0):
    """(N, 2) by which the numbers miss a direction, across it."""
    wi = directions(w, x, u, lobe)
    return np.stack([dot(wi, axis) for axis in normal_frames(target)], axis=1)


def derivatives(function, u, h):
    """(N, M, K) by central differences of (N, K) numbers."""
    moved = np.eye(u.shape[1]) * h
    ends = [function(u + by) - function(u - by) for by in moved]
    return np.stack(ends, axis=2) / (2 * h)


def guessed(w, x, target, lobe=0.0, side=16):
    """The best of a lattice, whose first numbers lie closer to the ends."""
    best = np.full(len(x), -1.0)
    found = np.full((len(x), 2), 0.5)
    middle = (np.arange(side) + 0.5) / side
    for first in np.sin(0.5 * np.pi * middle) ** 2:
        for second in middle:
            u = np.broadcast_to((first, second), found.shape)
            near = dot(directions(w, x, u, lobe), target)
            found[near > best] = first, second
            best = np.maximum(best, near)
    return found


def inverted(w, x, target, u, lobe=0.0):
    """Numbers that leave points in given directions, and by how much they miss."""
    u, rows = u.copy(), np.arange(len(u))
    for _ in range(25):
        error = miss(w, take(x, rows), u[rows], target[rows], lobe)
        far = np.abs(error).max(axis=1) > SMALL
        rows, error = rows[far], error[far]
        if len(rows) == 0:
            break
        some = partial(miss, w, take(x, rows), target=target[rows], lobe=lobe)
        slope = derivatives(some, u[rows], STEP)
        able = np.abs(np.linalg.det(slope)) > 1e-12
        slope = np.where(able[:, None, None], slope, np.eye(2))
        by = np.linalg.solve(slope, error[:, :, None])[:, :, 0]
        size = np.linalg.norm(by, axis=1, keepdims=True)
        u[rows] -= by * np.minimum(1.0, 0.1 / np.maximum(size, UNIT))
        u[rows, 0] = np.clip(u[rows, 0], EDGE, 1 - EDGE)
    error = np.linalg.norm(miss(w, x, u, target, lobe), axis=1)
    ahead = dot(directions(w, x, u, lobe), target) > 0
    return u, np.where(ahead, error, 2.0)
