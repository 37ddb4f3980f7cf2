"""A room without front and ceiling, and a ball in it: rays in closed form."""

import numpy as np

F = np.float32

BALL, RADIUS = np.array([0.25, -0.6, 0.1], F), F(0.35)
OFF = F(1e-3)
WALLS = ((0, -1), (0, 1), (1, -1), (2, -1))
"""Axis and side of the walls: left, right, floor and back."""

PAINT = np.array(
    [
        [0.7, 0.2, 0.15],
        [0.2, 0.6, 0.2],
        [0.7, 0.7, 0.65],
        [0.5, 0.5, 0.8],
        [0.8, 0.8, 0.8],
    ],
    F,
)
"""Of walls, and of the ball."""


def dot(a, b):
    """Inner products, (N,)."""
    return a[:, 0] * b[:, 0] + a[:, 1] * b[:, 1] + a[:, 2] * b[:, 2]


def unit(v):
    """Unit vectors; 0 for none."""
    size = np.sqrt(dot(v, v))[:, None]
    return np.divide(v, size, out=np.zeros_like(v), where=size > 0)


def cast(o, d):
    """What rays meet first: distance, or infinity, position, normal and paint."""
    t = np.full(len(o), np.inf, F)
    n, which = np.zeros_like(o), np.zeros(len(o), int)
    for k, (axis, side) in enumerate(WALLS):
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (F(side) - o[:, axis]) / d[:, axis]
            p = o + s[:, None] * d
        others = [a for a in range(3) if a != axis]
        met = (s > OFF) & (s < t) & (np.abs(p[:, others]) <= 1).all(axis=1)
        t, which = np.where(met, s, t), np.where(met, k, which)
        facing = np.zeros(3, F)
        facing[axis] = -side
        n = np.where(met[:, None], facing, n)
    v = o - BALL
    b, c = dot(v, d), dot(v, v) - RADIUS**2
    root = b * b - c
    with np.errstate(invalid="ignore"):
        s = -b - np.sqrt(root)
    met = (root > 0) & (s > OFF) & (s < t)
    t, which = np.where(met, s, t), np.where(met, len(WALLS), which)
    position = o + np.where(np.isfinite(t), t, 0)[:, None] * d
    n = np.where(met[:, None], (position - BALL) / RADIUS, n)
    return t.astype(F), position.astype(F), n.astype(F), which


def sees(x, y):
    """Whether nothing lies between points."""
    v = y - x
    d = np.sqrt(dot(v, v))
    d = np.where(d > 0, d, F(1))
    t, *_ = cast(x.astype(F), (v / d[:, None]).astype(F))
    return t > d - 2 * OFF


def glow(p, which):
    """Radiance that leaves surfaces, the same in all directions."""
    lamps = (
        (np.array([-1, 0.4, -0.3], F), F(0.03), F(20)),
        (np.array([0.5, -1, 0.7], F), F(0.01), F(8)),
    )
    light = np.full(len(p), F(0.1))
    for at, width, power in lamps:
        light = light + power * np.exp(-dot(p - at, p - at) / width)
    return (PAINT[which] * light[:, None]).astype(F)
