"""What a renderer calculates with: plain functions of arrays, in float32.

Nothing here is imported from the project: it is written from the page of the contract
and from the papers.  Rows stand in front, a vector's three numbers last.
"""

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

F = np.float32
MOST = np.finfo(F).max

REC_709, REC_601 = F([0.2126, 0.7152, 0.0722]), F([0.299, 0.587, 0.114])
LUMINANCES = {
    "709": lambda c: dot(c, REC_709),
    "601": lambda c: dot(c, REC_601),
    "mean": lambda c: dot(c, F([1 / 3] * 3)),
    "sum": lambda c: bounded(c.sum(axis=-1)),
    "largest": lambda c: c.max(axis=-1),
}


class Point(NamedTuple):
    """Visible points: place, unit normal, reflectance."""

    position: np.ndarray
    normal: np.ndarray
    albedo: np.ndarray


@dataclass(frozen=True)
class Reservoir:
    """Samples, with their weights and confidences."""

    position: np.ndarray
    normal: np.ndarray
    radiance: np.ndarray
    W: np.ndarray
    M: np.ndarray

    def map(self, change):
        """All buffers, changed."""
        return Reservoir(*(change(getattr(self, f.name)) for f in fields(self)))

    def buffers(self):
        """As the contract names them."""
        return {f.name: getattr(self, f.name).astype(F) for f in fields(self)}


def bounded(x):
    """Infinity as the largest number."""
    return np.minimum(x, MOST)


def quotient(a, b):
    """The quotient a / b, and 0 where b is 0."""
    out = np.zeros(np.broadcast_shapes(np.shape(a), np.shape(b)), F)
    return bounded(np.divide(a, b, out=out, where=np.asarray(b) > 0, dtype=F))


def dot(a, b):
    """Scalar product."""
    p = a * b
    return p[..., 0] + p[..., 1] + p[..., 2]


def polar(v):
    """Length and direction, however short or long; direction 0 for none."""
    x, y, z = np.moveaxis(np.abs(v), -1, 0)
    scale = np.maximum(np.maximum(x, y), z)
    w = v / np.where(scale > 0, scale, F(1))[..., None]
    size = np.sqrt(dot(w, w))
    return scale * size, w / np.where(scale > 0, size, F(1))[..., None]


def unit(v):
    """Direction of a vector; 0 for none, however short it is."""
    return polar(v)[1]


def plain_unit(v):
    """normalize() of a shader: no direction where the square leaves the type."""
    d2 = dot(v, v)
    fits = (d2 > 0) & (d2 < np.inf)
    return v * np.where(fits, 1 / np.sqrt(np.where(fits, d2, F(1))), F(0))[..., None]


def cosines(x, y, direction=unit):
    """Of the direction from x to sample y: at x, and at the sample's front."""
    omega = direction(y.position - x.position)
    return dot(x.normal, omega), -dot(y.normal, omega)


def reflected(x, y, back_test=True, direction=unit):
    """Integrand albedo / π · cos θ · L_o, with three channels."""
    above, facing = cosines(x, y, direction)
    lit = (above > 0) & ((facing > 0) | (not back_test))
    f = (x.albedo / F(np.pi)) * np.where(lit, above, F(0))[..., None] * y.radiance
    return np.minimum(f, MOST)


def jacobian(x_from, x_to, position, normal, one_sided=False):
    """Ratio of the solid angles of a patch, seen from two points."""
    d_from, omega_from = polar(position - x_from)
    d_to, omega_to = polar(position - x_to)
    cos_from, cos_to = -dot(normal, omega_from), -dot(normal, omega_to)
    if one_sided:
        cos_from, cos_to = np.maximum(cos_from, F(0)), np.maximum(cos_to, F(0))
    ratio = quotient(d_from, d_to)
    return bounded(quotient(np.abs(cos_to), np.abs(cos_from)) * ratio * ratio)


def accepts(u, before, w):
    """Whether a candidate of weight w is kept, after others of weights `before`."""
    return ((u * (before + w) < w) & (w > 0)) | ((before <= 0) & (w > 0))


def at_most(u, before, w):
    """The same by ≤, which decides otherwise on a threshold alone, or on nothing."""
    nothing = (w <= 0) & (before <= 0)
    return ((u * (before + w) <= w) & (w > 0)) | ((before <= 0) & (w > 0)) | nothing


def product(*factors):
    """Product of factors that are not negative, 0 where one is."""
    out, zero = np.ones((), F), np.zeros((), bool)
    for factor in factors:
        zero = zero | (np.asarray(factor) == 0)
        out = bounded(out * factor)
    return np.where(zero, F(0), out).astype(F)


def pick(array, index):
    """Row by row, one of the entries along axis 1."""
    index = index.reshape(len(index), *[1] * (array.ndim - 1))
    return np.take_along_axis(array, index, axis=1)[:, 0]
