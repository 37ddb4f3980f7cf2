"""A backend of whole arrays, on PyTorch, CuPy, JAX or NumPy: the array API standard.

    pip install '.[arrays]'
    RESTIR_ARRAYS=torch restir check docs/examples/arrays/backend.py

The environment variable ``RESTIR_ARRAYS`` is torch, cupy, jax, strict for
array-api-strict, or numpy, the default; ``RESTIR_DEVICE`` is a device of PyTorch.

Shapes: a row of every array is a row of the contract.  Candidates of a stream are a
second axis, (N, C), with the first of the stream in column 0.
"""

import math
import os
from functools import wraps
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

MODULES = {
    "numpy": "array_api_compat.numpy",
    "torch": "array_api_compat.torch",
    "cupy": "array_api_compat.cupy",
    "jax": "jax.numpy",
    "strict": "array_api_strict",
}


def chosen_library():
    """Namespace of the library that ``RESTIR_ARRAYS`` names."""
    name = os.environ.get("RESTIR_ARRAYS") or "numpy"
    if name not in MODULES:
        raise ValueError(f"RESTIR_ARRAYS is {name!r}; {', '.join(MODULES)} are known")
    if name == "jax":
        import_module("jax").config.update("jax_enable_x64", True)  # for `product`
    return import_module(MODULES[name])


xp: Any = chosen_library()
DEVICE = os.environ.get("RESTIR_DEVICE") or None
LARGEST = float(np.finfo(np.float32).max)
WORD = 2**32 - 1


def in_library(value):
    """A buffer in the library, whole numbers with 64 bits; a setting as it is."""
    if not isinstance(value, np.ndarray):
        return value
    dtype = np.float32 if value.dtype.kind == "f" else np.int64
    return xp.asarray(value.astype(dtype), device=DEVICE)


def from_numpy(kernel):
    """The pass, given arrays of NumPy in place of the library's."""

    @wraps(kernel)
    def taking_numpy(self, **given):
        return kernel(self, **{name: in_library(v) for name, v in given.items()})

    return taking_numpy


# ---------------------------------------------------------------- records


class Surface(NamedTuple):
    """Visible points, each array (..., 3)."""

    position: Any
    normal: Any
    albedo: Any


class Sample(NamedTuple):
    """Sample points, each array (..., 3)."""

    position: Any
    normal: Any
    radiance: Any


class Reservoirs(NamedTuple):
    """Samples (N, C, 3), and numbers (N, C)."""

    y: Sample
    W: Any
    M: Any


class Candidates(NamedTuple):
    """Of a stream: samples (N, C, 3), and numbers (N, C)."""

    y: Sample
    p_hat: Any
    w: Any
    M: Any


def surface_in(buffers, prefix=""):
    """Visible points among the buffers of a pass, (N, 1, 3)."""
    names = ("visible_position", "visible_normal", "albedo")
    return Surface(*(buffers[prefix + name][:, None, :] for name in names))


def sample_in(buffers, prefix=""):
    """Sample points among the buffers of a pass, (N, 1, 3)."""
    return Sample(*(buffers[prefix + name][:, None, :] for name in Sample._fields))


def reservoirs_in(buffers, prefix=""):
    """Reservoirs among the buffers of a pass, a column."""
    W, M = (buffers[prefix + name][:, None] for name in ("W", "M"))
    return Reservoirs(sample_in(buffers, prefix), W, M)


def gathered(record, rows):
    """Of a column of records those at (N, K) rows, where −1 is any."""
    if isinstance(record, tuple):
        return type(record)(*(gathered(part, rows) for part in record))
    flat = xp.reshape(xp.clip(rows, min=0), (-1,))
    shape = (*rows.shape, *record.shape[2:])
    return xp.reshape(xp.take(record[:, 0, ...], flat, axis=0), shape)


def picked(record, column):
    """Of records (N, C, ...) one column for each row, (N, ...)."""
    if isinstance(record, tuple):
        return type(record)(*(picked(part, column) for part in record))
    wide = xp.reshape(column, (-1,) + (1,) * (record.ndim - 1))
    wide = xp.broadcast_to(wide, (record.shape[0], 1, *record.shape[2:]))
    return xp.take_along_axis(record, wide, axis=1)[:, 0, ...]


def in_order(*records):
    """One stream of several, one after the other."""
    if isinstance(records[0], tuple):
        return type(records[0])(*map(in_order, *records))
    return xp.concat(records, axis=1)


# ---------------------------------------------------------------- arithmetic


def quotient(a, b):
    """Quotient a / b; 0 where b is 0, and no larger than the largest number."""
    by_zero = b == 0
    found = a / xp.where(by_zero, xp.ones_like(b), b)
    return xp.where(by_zero, xp.zeros_like(found), xp.clip(found, max=LARGEST))


def dot(a, b):
    """Inner product of vectors in the last axis."""
    return xp.sum(a * b, axis=-1)


def luminance(color):
    """Y of Rec. 709."""
    return 0.2126 * color[..., 0] + 0.7152 * color[..., 1] + 0.0722 * color[..., 2]


def product(a, b):
    """Product a b modulo 2³²; nothing exceeds 64 bits on the way."""
    low = a * (b & 0xFFFF)
    high = (a * (b >> 16)) & 0xFFFF
    return (low + (high << 16)) & WORD


def mixed(lanes):
    """The four sums of PCG4D, in place."""
    for to, a, b in ((0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)):
        lanes[to] = (lanes[to] + product(lanes[a], lanes[b])) & WORD


def whole(reals):
    """The nearest whole numbers, ties to even."""
    return xp.astype(xp.round(reals), xp.int64)


def bits_of(words, bits):
    """Whether the bits are set, as many columns as there are."""
    return ((words >> bits) & 1) == 1


# ---------------------------------------------------------------- formulas


def towards(x, y):
    """Unit vectors ω from x to y, and distances, without squares that overflow."""
    to = y.position - x.position
    distance = xp.hypot(xp.hypot(to[..., 0], to[..., 1]), to[..., 2])
    return to * quotient(xp.ones_like(distance), distance)[..., None], distance


def cosine_at(x, y):
    """Cosine at the visible point; 0 where the sample is below or shows its back."""
    direction, _ = towards(x, y)
    cosine = dot(x.normal, direction)
    counts = (cosine > 0) & (dot(y.normal, direction) < 0)
    return xp.where(counts, cosine, xp.zeros_like(cosine))


def target_at(x, y, target):
    """p̂ of Equation 9, scattered, or 10, outgoing."""
    cosine = cosine_at(x, y)
    if target == "outgoing":
        light = luminance(y.radiance) * xp.ones_like(cosine)
        return xp.where(cosine > 0, light, xp.zeros_like(light))
    return luminance(x.albedo * y.radiance) * cosine / math.pi


def jacobian_of(x_from, x_to, y):
    """Equation 11: of the solid angles of a patch, that at x_to above."""
    from_y, distance_from = towards(y, x_from)
    to_y, distance_to = towards(y, x_to)
    cosine_from = xp.abs(dot(y.normal, from_y))
    cosine_to = xp.abs(dot(y.normal, to_y))
    distances = quotient(distance_from, distance_to)
    cosines = quotient(cosine_to, cosine_from)
    return xp.clip(cosines * distances * distances, max=LARGEST)


def are_similar(n_a, z_a, n_b, z_b, max_angle, max_depth):
    """Whether two visible points may share samples."""
    seen = (z_a > 0) & (z_b > 0)
    alike = dot(n_a, n_b) >= math.cos(math.radians(max_angle))
    return seen & alike & (xp.abs(z_a - z_b) <= max_depth * xp.maximum(z_a, z_b))


# ---------------------------------------------------------------- streams


def drawn(x, y, pdf, target):
    """New samples as a stream of one."""
    p_hat = target_at(x, y, target)
    return Candidates(y, p_hat, quotient(p_hat, pdf[:, None]), xp.ones_like(p_hat))


def reused(x, reservoirs, target):
    """Reservoirs as a stream, as they are."""
    y, W, M = reservoirs
    p_hat = target_at(x, y, target)
    return Candidates(y, p_hat, p_hat * W * M, M)


def shifted(x, x_from, reservoirs, seen, target):
    """Reservoirs of other points as a stream; their samples are seen from x or not."""
    stream = reused(x, reservoirs, target)
    w = stream.w * jacobian_of(x_from, x, stream.y)
    return stream._replace(w=xp.where(seen, w, xp.zeros_like(w)))


def kept_column(w, u):
    """Column that Algorithm 1 keeps, (N,): the last that is accepted; 0 for none."""
    sums = xp.cumulative_sum(w, axis=1)
    alone = (w > 0) & (sums == w)
    accepted = alone | (u * sums < w)
    columns = xp.arange(w.shape[1], dtype=xp.int64, device=DEVICE)
    return xp.max(xp.where(accepted, columns, xp.zeros_like(columns)), axis=1)


def supports(x_from, stream, column, sees, bit, target):
    """Which of the points (N, K) could have made what is kept, whose bit is told."""
    kept = Sample(*(a[:, None, :] for a in picked(stream.y, column)))
    return bits_of(sees, bit[:, None]) & (target_at(x_from, kept, target) > 0)


def closed(stream, column, Z, cap):
    """Reservoirs of what is kept, and the terms of their W."""
    kept = picked(stream, column)
    w, M = xp.sum(stream.w, axis=1), xp.sum(stream.M, axis=1)
    return {
        **kept.y._asdict(),
        "W": quotient(quotient(w, kept.p_hat), Z),
        "M": xp.clip(M, max=float(cap)),
        "term_w": stream.w,
        "term_p_hat": kept.p_hat,
        "term_Z": Z,
    }


def divisor(M, can_make, mis):
    """Z of 1/Z, or of 1/M."""
    if mis == "1/M":
        return xp.sum(M, axis=1)
    return xp.sum(xp.where(can_make, M, xp.zeros_like(M)), axis=1)


def after_first(u):
    """Numbers that decide on a stream: the first of it needs none."""
    return xp.concat((xp.zeros_like(u[:, :1]), u), axis=1)


# ---------------------------------------------------------------- passes


class ArrayBackend:
    """The passes from ``random`` to ``shade``."""

    precision = "float32"

    @from_numpy
    def random(self, key):
        """PCG4D of [Jarzynski20], a lane each."""
        lanes = [(product(key[:, k], 1664525) + 1013904223) & WORD for k in range(4)]
        mixed(lanes)
        lanes = [lane ^ (lane >> 16) for lane in lanes]
        mixed(lanes)
        words = xp.stack(lanes, axis=1)
        u = xp.astype(words >> 8, xp.float32) * 2.0**-24
        return {"words": xp.astype(words, xp.uint32), "u": u}

    @from_numpy
    def direction(self, visible_normal, u, source):
        """A direction by the source's density."""
        n, u_0, azimuth = visible_normal, u[:, 0], 2 * math.pi * u[:, 1]
        if source == "uniform":
            cosine, sine = u_0, xp.sqrt((1 - u_0) * (1 + u_0))
            pdf = xp.full_like(cosine, 1 / (2 * math.pi))
        else:
            cosine, sine = xp.sqrt(1 - u_0), xp.sqrt(u_0)
            pdf = cosine / math.pi
        # The axis that is least along the normal is never parallel to it.
        axes = xp.eye(3, dtype=xp.float32, device=DEVICE)
        axis = xp.take(axes, xp.argmin(xp.abs(n), axis=1), axis=0)
        tangent = xp.linalg.cross(axis, n)
        tangent = tangent / xp.sqrt(dot(tangent, tangent))[:, None]
        bitangent = xp.linalg.cross(n, tangent)
        x, y = sine * xp.cos(azimuth), sine * xp.sin(azimuth)
        direction = x[:, None] * tangent + y[:, None] * bitangent + cosine[:, None] * n
        return {"direction": direction, "pdf": pdf}

    @from_numpy
    def target(self, target, **buffers):
        """p̂ of sample points."""
        p_hat = target_at(surface_in(buffers), sample_in(buffers), target)
        return {"p_hat": p_hat[:, 0]}

    @from_numpy
    def jacobian(self, x_from, x_to, position, normal):
        """J of the reconnection shift."""
        x_from, x_to = (Surface(x, None, None) for x in (x_from, x_to))
        return {"jacobian": jacobian_of(x_from, x_to, Sample(position, normal, None))}

    @from_numpy
    def merge(self, w_a, M_a, w_b, M_b, u):
        """A stream of two."""
        second = kept_column(xp.stack((w_a, w_b), axis=1), after_first(u[:, None]))
        return {"second": xp.astype(second, xp.uint32), "w": w_a + w_b, "M": M_a + M_b}

    @from_numpy
    def finalize(self, w, p_hat, Z):
        """Equation 7."""
        return {"W": quotient(quotient(w, p_hat), Z)}

    @from_numpy
    def similar(self, normal_a, depth_a, normal_b, depth_b, **limits):
        """Whether points are similar."""
        found = are_similar(normal_a, depth_a, normal_b, depth_b, **limits)
        return {"similar": xp.astype(found, xp.uint32)}

    @from_numpy
    def initial(self, pdf, target, **buffers):
        """Algorithm 2."""
        new = drawn(surface_in(buffers), sample_in(buffers), pdf, target)
        return {
            "p_hat": new.p_hat[:, 0],
            "W": quotient(new.w, new.p_hat)[:, 0],
            "M": new.M[:, 0],
        }

    @from_numpy
    def temporal(self, new_pdf, u, target, cap, **buffers):
        """Algorithm 3 where nothing moves."""
        x = surface_in(buffers)
        past = reused(x, reservoirs_in(buffers, "past_"), target)
        new = drawn(x, sample_in(buffers, "new_"), new_pdf, target)
        stream = in_order(past, new)
        column = kept_column(stream.w, after_first(u[:, None]))
        return closed(stream, column, xp.sum(stream.M, axis=1), cap)

    @from_numpy
    def moved(self, new_pdf, visible, u, target, mis, cap, **buffers):
        """Algorithm 3 where the past was seen from another point."""
        x, x_past = surface_in(buffers), surface_in(buffers, "past_")
        seen, sees = bits_of(visible[:, :1], 1), visible[:, 1:]
        past = shifted(x, x_past, reservoirs_in(buffers, "past_"), seen, target)
        new = drawn(x, sample_in(buffers, "new_"), new_pdf, target)
        stream = in_order(past, new)
        column = kept_column(stream.w, after_first(u[:, None]))
        can_make = supports(x_past, stream, column, sees, 1 - column, target)
        can_make = xp.concat((can_make, xp.ones_like(can_make)), axis=1)
        return closed(stream, column, divisor(stream.M, can_make, mis), cap)

    @from_numpy
    def neighbors(
        self, visible_normal, depth, u, width, radius, min_radius, max_angle, max_depth
    ):
        """Neighbours in a disk, whose radius depends on what was found before."""
        rows = xp.arange(depth.shape[0], dtype=xp.int64, device=DEVICE)
        column, line = rows % width, rows // width
        height = depth.shape[0] // width
        reach = max(radius * width, min_radius) * xp.ones_like(depth)
        found = []
        for k in range(u.shape[1]):
            r, azimuth = reach * xp.sqrt(u[:, k, 0]), 2 * math.pi * u[:, k, 1]
            to_column = column + whole(r * xp.cos(azimuth))
            to_line = line + whole(r * xp.sin(azimuth))
            inside = (to_column >= 0) & (to_column < width)
            inside = inside & (to_line >= 0) & (to_line < height)
            to = xp.where(inside, to_line * width + to_column, rows)
            n_to, z_to = (xp.take(a, to, axis=0) for a in (visible_normal, depth))
            usable = inside & are_similar(
                visible_normal, depth, n_to, z_to, max_angle, max_depth
            )
            found.append(xp.where(usable & (to != rows), to, -xp.ones_like(to)))
            halved = xp.clip(reach / 2, min=float(min_radius))
            reach = xp.where(usable, reach, halved)
        return {"neighbors": xp.astype(xp.stack(found, axis=1), xp.int32)}

    @from_numpy
    def spatial(
        self, neighbors, visible, u_own, u_neighbors, target, mis, cap, **buffers
    ):
        """Algorithm 4, all neighbours at once."""
        x, own = surface_in(buffers), reservoirs_in(buffers)
        count = neighbors.shape[1]
        bits = xp.arange(1, count + 1, dtype=xp.int64, device=DEVICE)
        there = neighbors >= 0
        seen, sees = there & bits_of(visible[:, :1], bits), visible[:, 1:]
        x_from, others = gathered(x, neighbors), gathered(own, neighbors)
        M = xp.where(there, others.M, xp.zeros_like(others.M))
        stream = in_order(
            reused(x, reservoirs_in(buffers, "past_"), target),
            reused(x, own, target),
            shifted(x, x_from, others._replace(M=M), seen, target),
        )
        u = xp.concat((u_own[:, None], u_neighbors), axis=1)
        column = kept_column(stream.w, after_first(u))
        # The past comes first in the stream, and last in the words.
        bit = xp.where(column == 0, xp.full_like(column, count + 1), column - 1)
        can_make = supports(x_from, stream, column, sees, bit, target)
        always = xp.ones((u.shape[0], 2), dtype=xp.bool, device=DEVICE)
        can_make = xp.concat((always, can_make), axis=1)
        return closed(stream, column, divisor(stream.M, can_make, mis), cap)

    @from_numpy
    def shade(self, W, **buffers):
        """Equation 8."""
        x, y = surface_in(buffers), sample_in(buffers)
        f = x.albedo * y.radiance * (cosine_at(x, y) / math.pi)[..., None]
        return {"color": f[:, 0, :] * W[:, None], "term_f": f[:, 0, :]}


BACKEND = ArrayBackend()
