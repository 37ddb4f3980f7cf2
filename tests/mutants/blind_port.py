"""A backend in float32, written from the page of the contract alone.

It calls none of the project's passes.  Each step is a method of its own, so that a
mistake of one step is a subclass with one method.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Buffers = dict[str, Array]

PI = np.float32(np.pi)
LARGEST = np.finfo(np.float32).max
LARGEST_HALF = 65504.0
SAMPLE = ("position", "normal", "radiance")
RESERVOIR = (*SAMPLE, "W", "M")
RECEIVER = ("visible_position", "visible_normal", "albedo")


def finite(values: Array) -> Array:
    """What is too large becomes the largest number; what is no number becomes 0."""
    return np.nan_to_num(values, nan=0.0, posinf=LARGEST, neginf=-LARGEST)


def quotient(a: Array, b: Array) -> Array:
    """Of a by b, finite; 0 where b is 0."""
    with np.errstate(all="ignore"):
        return np.where(b == 0, np.float32(0), finite(a / b))


def product(*factors: Array) -> Array:
    """From the left, finite at every step."""
    found = factors[0]
    with np.errstate(all="ignore"):
        for factor in factors[1:]:
            found = finite(found * factor)
    return found


def total(a: Array, b: Array) -> Array:
    """Finite."""
    with np.errstate(all="ignore"):
        return finite(a + b)


def dot(a: Array, b: Array) -> Array:
    """Of vectors in the last axis."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def length_and_direction(start: Array, end: Array) -> tuple[Array, Array]:
    """From one point to another; the direction is 0 where they are one.

    The vector is scaled by its largest component before it is squared.
    """
    with np.errstate(all="ignore"):
        v = finite(end - start)
        scale = np.abs(v).max(axis=-1)
        scaled = quotient(v, scale[..., None])
        length = np.sqrt(dot(scaled, scaled))
        return finite(length * scale), quotient(scaled, length[..., None])


def bit(words: Array, place: Array | int) -> Array:
    """Whether a bit of each word is set."""
    return (words >> np.asarray(place, np.uint32)) & np.uint32(1) == 1


def group(names: tuple[str, ...], buffers: Buffers, prefix: str = "") -> Buffers:
    """Those buffers, without the prefix."""
    return {name: buffers[prefix + name] for name in names}


def rows_of(buffers: Buffers, rows: Array) -> Buffers:
    """Rows of every buffer."""
    return {name: values[rows] for name, values in buffers.items()}


def chosen(second: Array, a: Buffers, b: Buffers) -> Buffers:
    """Rows of the second where it is chosen, else of the first."""
    return {
        name: np.where(second.reshape(-1, *[1] * (a[name].ndim - 1)), b[name], a[name])
        for name in a
    }


def past_receiver(b: Buffers) -> Buffers:
    """Where the past was seen, as a receiver."""
    return {
        "visible_position": b["past_visible_position"],
        "visible_normal": b["past_visible_normal"],
        "albedo": b["past_albedo"],
    }


class Port:
    """All passes of the contract but those of whole paths."""

    precision = "float32"

    # ------------------------------------------------------------ random numbers

    def random(self, *, key: Array) -> Buffers:
        """Four words and four numbers a row."""
        with np.errstate(all="ignore"):
            v = key * np.uint32(1664525) + np.uint32(1013904223)
            v = self._sums(v)
            v = v ^ (v >> np.uint32(16))
            v = self._sums(v)
        return {"words": v, "u": self._unit(v)}

    def _sums(self, v: Array) -> Array:
        """Each lane takes the product of two others, one after the other."""
        x, y, z, w = v.T.copy()
        x += y * w
        y += z * x
        z += x * y
        w += y * z
        return np.stack([x, y, z, w], axis=1)

    def _unit(self, words: Array) -> Array:
        """Numbers in [0, 1) of words."""
        return (words >> np.uint32(8)).astype(np.float32) * np.float32(2**-24)

    # ---------------------------------------------------------------- directions

    def direction(self, *, visible_normal: Array, u: Array, source: str) -> Buffers:
        """Direction and density."""
        u0 = u[:, 0]
        cos = u0 if source == "uniform" else np.sqrt(1 - u0)
        sin = np.sqrt((1 - u0) * (1 + u0) if source == "uniform" else u0)
        phi = self._azimuth(u[:, 1])
        tangent, bitangent = self._frame(visible_normal)
        direction = (
            (sin * np.cos(phi))[:, None] * tangent
            + (sin * np.sin(phi))[:, None] * bitangent
            + cos[:, None] * visible_normal
        )
        return {"direction": direction, "pdf": self._density(cos, source)}

    def _azimuth(self, u1: Array) -> Array:
        """Angle about the normal, in radians."""
        return 2 * PI * u1

    def _frame(self, n: Array) -> tuple[Array, Array]:
        """Two unit vectors that are orthogonal to a normal and to each other."""
        x, y, z = n.T
        sign = np.where(z < 0, np.float32(-1), np.float32(1))
        a = -1 / (sign + z)
        b = x * y * a
        tangent = np.stack([1 + sign * x * x * a, sign * b, -sign * x], axis=1)
        return tangent, np.stack([b, sign + y * y * a, -y], axis=1)

    def _density(self, cos: Array, source: str) -> Array:
        """Of a direction on the hemisphere."""
        if source == "uniform":
            return np.full_like(cos, 1 / (2 * PI))
        return cos / PI

    # ------------------------------------------------------------------- targets

    def _luminance(self, c: Array) -> Array:
        """Of linear Rec. 709."""
        with np.errstate(all="ignore"):
            r, g, b = c[..., 0], c[..., 1], c[..., 2]
            return finite(
                np.float32(0.2126) * r + np.float32(0.7152) * g + np.float32(0.0722) * b
            )

    def _cosine(self, receiver: Buffers, sample: Buffers) -> Array:
        """At the visible point; 0 where the sample is below or shows its back."""
        x, s = receiver["visible_position"], sample["position"]
        _, omega = length_and_direction(x, s)
        cos = dot(receiver["visible_normal"], omega)
        usable = self._above(cos) & self._lit(dot(sample["normal"], omega))
        return np.where(usable, cos, np.float32(0))

    def _above(self, cos: Array) -> Array:
        """Whether a sample is above the horizon."""
        return cos > 0

    def _lit(self, cos_sample: Array) -> Array:
        """Whether a sample shows the side that was seen."""
        return cos_sample < 0

    def _p_hat(self, receiver: Buffers, sample: Buffers, target: str) -> Array:
        """Target of samples at visible points."""
        cos = self._cosine(receiver, sample)
        if target == "outgoing":
            bright = self._luminance(sample["radiance"])
            return np.where(cos > 0, bright, np.float32(0))
        reflected = receiver["albedo"] / PI * sample["radiance"]
        return self._luminance(reflected) * cos

    def target(self, *, target: str, **b: Array) -> Buffers:
        """Target."""
        return {"p_hat": self._p_hat(group(RECEIVER, b), group(SAMPLE, b), target)}

    def jacobian(
        self, *, x_from: Array, x_to: Array, position: Array, normal: Array
    ) -> Buffers:
        """Jacobian of the reconnection."""
        return {"jacobian": self._ratio(x_from, x_to, position, normal)}

    def _ratio(
        self, x_from: Array, x_to: Array, position: Array, normal: Array
    ) -> Array:
        """Of the solid angles of a patch."""
        d_from, w_from = length_and_direction(position, x_from)
        d_to, w_to = length_and_direction(position, x_to)
        cosines = quotient(np.abs(dot(normal, w_to)), np.abs(dot(normal, w_from)))
        return product(cosines, self._spread(quotient(d_from, d_to)))

    def _spread(self, ratio: Array) -> Array:
        """Of solid angles, by the ratio of two distances."""
        return product(ratio, ratio)

    # ---------------------------------------------------------------- reservoirs

    def merge(
        self, *, w_a: Array, M_a: Array, w_b: Array, M_b: Array, u: Array
    ) -> Buffers:
        """Which of two is kept."""
        second = self._keeps(w_a, w_b, u).astype(np.uint32)
        return {"second": second, "w": total(w_a, w_b), "M": M_a + M_b}

    def _keeps(self, before: Array, w: Array, u: Array) -> Array:
        """Whether a candidate takes the place of what was kept before."""
        with np.errstate(all="ignore"):
            return (u * total(before, w) < w) | ((before == 0) & (w > 0))

    def finalize(self, *, w: Array, p_hat: Array, Z: Array) -> Buffers:
        """Contribution weight."""
        return {"W": self._closed(w, p_hat, Z)}

    def _closed(self, w: Array, p_hat: Array, Z: Array) -> Array:
        """Sum of weights, divided by the divisor and the target."""
        return quotient(quotient(w, Z), p_hat)

    def similar(
        self,
        *,
        normal_a: Array,
        depth_a: Array,
        normal_b: Array,
        depth_b: Array,
        max_angle: float,
        max_depth: float,
    ) -> Buffers:
        """Whether points may share."""
        alike = self._alike(normal_a, depth_a, normal_b, depth_b, max_angle, max_depth)
        return {"similar": alike.astype(np.uint32)}

    def _alike(
        self,
        normal_a: Array,
        depth_a: Array,
        normal_b: Array,
        depth_b: Array,
        max_angle: float,
        max_depth: float,
    ) -> Array:
        """Whether normals and depths are close."""
        turned = dot(normal_a, normal_b) >= self._least_cosine(max_angle)
        limit = product(np.maximum(depth_a, depth_b), np.float32(max_depth))
        near = np.abs(depth_a - depth_b) <= limit
        return turned & near & (depth_a > 0) & (depth_b > 0)

    def _least_cosine(self, max_angle: float) -> np.float32:
        """Of two normals."""
        return np.float32(np.cos(np.radians(max_angle)))

    # ------------------------------------------------------- passes of a frame

    def initial(self, *, pdf: Array, target: str, **b: Array) -> Buffers:
        """A new sample as a reservoir."""
        p_hat = self._p_hat(group(RECEIVER, b), group(SAMPLE, b), target)
        W = quotient(self._new_weight(p_hat, pdf), p_hat)
        return {"p_hat": p_hat, "W": W, "M": np.ones_like(p_hat)}

    def _new_weight(self, p_hat: Array, pdf: Array) -> Array:
        """Of a new sample."""
        return quotient(p_hat, pdf)

    def temporal(self, *, target: str, cap: float, **b: Array) -> Buffers:
        """The pixel's past, then the new sample."""
        receiver = group(RECEIVER, b)
        past, new = group(SAMPLE, b, "past_"), group(SAMPLE, b, "new_")
        p_past = self._p_hat(receiver, past, target)
        p_new = self._p_hat(receiver, new, target)
        w_past = product(p_past, b["past_W"], b["past_M"])
        w_new = self._new_weight(p_new, b["new_pdf"])
        second = self._keeps(w_past, w_new, b["u"])
        kept = chosen(second, past, new)
        p_kept = self._p_hat_closing(receiver, kept, target)
        M = b["past_M"] + 1
        Z = self._temporal_divisor(M, cap)
        W = self._closed(total(w_past, w_new), p_kept, Z)
        return {**kept, "W": W, "M": self._temporal_cap(b["past_M"], cap)}

    def _p_hat_closing(self, receiver: Buffers, kept: Buffers, target: str) -> Array:
        """Target by which a temporal reservoir is closed."""
        return self._p_hat(receiver, kept, target)

    def _temporal_divisor(self, M: Array, cap: float) -> Array:
        """Of the sum of weights."""
        return M

    def _temporal_cap(self, past_M: Array, cap: float) -> Array:
        """Confidence on the way out."""
        return np.minimum(past_M + 1, np.float32(cap))

    def moved(self, *, target: str, cap: float, mis: str, **b: Array) -> Buffers:
        """The past of another visible point, then the new sample."""
        receiver = group(RECEIVER, b)
        past, new = group(SAMPLE, b, "past_"), group(SAMPLE, b, "new_")
        J = self._ratio(
            b["past_visible_position"],
            b["visible_position"],
            past["position"],
            past["normal"],
        )
        p_past = self._p_hat(receiver, past, target)
        p_new = self._p_hat(receiver, new, target)
        w_past = product(p_past, b["past_W"], b["past_M"], J)
        w_past = np.where(self._sees_past(b["visible"]), w_past, np.float32(0))
        w_new = self._new_weight(p_new, b["new_pdf"])
        second = self._keeps(w_past, w_new, b["u"])
        kept = chosen(second, past, new)
        p_kept = np.where(second, p_new, p_past)
        M = self._moved_confidence(b["past_M"], b["visible"])
        Z = M
        if mis == "1/Z":
            there = self._p_hat(self._earlier(b), kept, target) > 0
            there &= bit(b["visible"][:, 1], np.where(second, 0, 1))
            Z = np.where(there, M, np.float32(1))
        W = self._closed(total(w_past, w_new), p_kept, Z)
        return {**kept, "W": W, "M": np.minimum(M, np.float32(cap))}

    def _sees_past(self, visible: Array) -> Array:
        """Whether x sees the past's sample."""
        return bit(visible[:, 0], 1)

    def _earlier(self, b: Buffers) -> Buffers:
        """The receiver at x_past, whose domain is asked for."""
        return past_receiver(b)

    def _moved_confidence(self, past_M: Array, visible: Array) -> Array:
        """Before the cap; whatever x sees."""
        return past_M + 1

    # ---------------------------------------------------------------- neighbours

    def neighbors(
        self,
        *,
        visible_normal: Array,
        depth: Array,
        u: Array,
        width: int,
        radius: float,
        min_radius: float,
        max_angle: float,
        max_depth: float,
    ) -> Buffers:
        """Rows of neighbours."""
        N, K = u.shape[:2]
        rows = np.arange(N)
        x, y = rows % width, rows // width
        first = max(np.float32(radius) * np.float32(width), np.float32(min_radius))
        r = np.full(N, first, np.float32)
        found = np.full((N, K), -1, np.int32)
        for k in range(K):
            reach, phi = r * np.sqrt(u[:, k, 0]), 2 * PI * u[:, k, 1]
            at_x = x + self._whole(reach * np.cos(phi))
            at_y = y + self._whole(reach * np.sin(phi))
            inside = self._in_image(at_x, at_y, width, N // width)
            row = np.where(inside, at_y * width + at_x, rows)
            alike = self._alike(
                visible_normal,
                depth,
                visible_normal[row],
                depth[row],
                max_angle,
                max_depth,
            )
            itself = inside & (row == rows)
            found[:, k] = np.where(inside & alike & ~itself, row, -1)
            usable = inside & alike | itself
            r = np.where(usable, r, self._smaller(r, np.float32(min_radius)))
        return {"neighbors": found}

    def _whole(self, offset: Array) -> Array:
        """Nearest whole number, ties to even."""
        return np.rint(offset).astype(np.int64)

    def _in_image(self, x: Array, y: Array, width: int, height: int) -> Array:
        """Whether a pixel lies in the image."""
        return (x >= 0) & (x < width) & (y >= 0) & (y < height)

    def _smaller(self, r: Array, min_radius: np.float32) -> Array:
        """Radius after a neighbour that is not usable."""
        return np.maximum(r / 2, min_radius)

    # ------------------------------------------------------------------- spatial

    def spatial(self, *, target: str, cap: float, mis: str, **b: Array) -> Buffers:
        """Past, own, then the neighbours."""
        receiver, own = group(RECEIVER, b), group(RESERVOIR, b)
        past = group(RESERVOIR, b, "past_")
        visible, K = b["visible"], b["neighbors"].shape[1]
        kept = past
        sum_w = self._reuse_weight(receiver, past, target)
        sum_M = past["M"]
        place = np.full(len(sum_w), self._place_of_past(K))
        w = self._reuse_weight(receiver, own, target)
        second = self._keeps(sum_w, w, self._u_of_own(b))
        kept, place = chosen(second, kept, own), np.where(second, self._place(0), place)
        sum_w, sum_M = total(sum_w, w), sum_M + own["M"]
        for k in range(K):
            there, row = self._rows_there(b["neighbors"][:, k])
            sample, at = rows_of(own, row), rows_of(receiver, row)
            J = self._ratio(
                at["visible_position"],
                receiver["visible_position"],
                sample["position"],
                self._normal_for_ratio(sample, own),
            )
            w = product(self._reuse_weight(receiver, sample, target), J)
            w = np.where(there & self._sees_neighbor(visible, k), w, np.float32(0))
            second = self._keeps(sum_w, w, b["u_neighbors"][:, k])
            kept = chosen(second, kept, sample)
            place = np.where(second, self._place(1 + k), place)
            sum_w = total(sum_w, w)
            sum_M = sum_M + np.where(there, sample["M"], np.float32(0))
        p_kept = self._p_hat(receiver, kept, target)
        Z = sum_M
        if mis == "1/Z":
            Z = past["M"] + own["M"]
            for k in range(K):
                there, row = self._rows_there(b["neighbors"][:, k])
                holds = self._p_hat(rows_of(receiver, row), kept, target) > 0
                holds &= bit(visible[:, 1 + k], place) & there
                Z = Z + np.where(holds, own["M"][row], np.float32(0))
        W = self._closed(sum_w, p_kept, Z)
        return {**kept, "W": W, "M": self._spatial_cap(sum_M, cap)}

    def _reuse_weight(self, receiver: Buffers, r: Buffers, target: str) -> Array:
        """Of a reservoir, without the Jacobian."""
        return product(self._p_hat(receiver, r, target), r["W"], r["M"])

    def _rows_there(self, neighbor: Array) -> tuple[Array, Array]:
        """Whether there is a neighbour, and its row, or any."""
        return neighbor >= 0, np.maximum(neighbor, 0)

    def _sees_neighbor(self, visible: Array, k: int) -> Array:
        """Whether the pixel sees the sample of neighbour k."""
        return bit(visible[:, 0], 1 + k)

    def _place(self, source: int) -> int:
        """Bit of the pixel's own sample, 0, or of neighbour k, from 1 + k."""
        return source

    def _place_of_past(self, K: int) -> int:
        """Bit of the sample of the spatial past."""
        return 1 + K

    def _u_of_own(self, b: Buffers) -> Array:
        """Random number for the pixel's own reservoir."""
        return b["u_own"]

    def _normal_for_ratio(self, sample: Buffers, own: Buffers) -> Array:
        """Normal at the sample point of the neighbour."""
        return sample["normal"]

    def _spatial_cap(self, M: Array, cap: float) -> Array:
        """Confidence on the way out."""
        return np.minimum(M, np.float32(cap))

    def shade(self, *, W: Array, **b: Array) -> Buffers:
        """Colour of the pixel."""
        cos = self._shading_cosine(group(RECEIVER, b), group(SAMPLE, b))
        f = b["albedo"] / PI * cos[:, None] * b["radiance"]
        return {"color": product(f, W[:, None])}

    def _shading_cosine(self, receiver: Buffers, sample: Buffers) -> Array:
        """As of the target."""
        return self._cosine(receiver, sample)

    # ------------------------------------------------------------------- camera

    def _axes(self, c: dict[str, float]) -> tuple[Array, Array, Array, Array]:
        """Eye, forward, right and upward of a camera, each (3,)."""
        eye, at, up = (
            np.array([c[f"{name}_{axis}"] for axis in "xyz"], np.float32)
            for name in ("eye", "target", "up")
        )
        _, forward = length_and_direction(eye, at)
        _, right = length_and_direction(np.zeros_like(up), np.cross(forward, up))
        return eye, forward, right, np.cross(right, forward)

    def _half_width(self, c: dict[str, float]) -> np.float32:
        """Of the image at depth 1."""
        return np.float32(np.tan(np.radians(c["fov_x"]) / 2))

    def gbuffer(
        self, *, pixel: Array, a: Array, b: Array, c: Array, **camera: Any
    ) -> Buffers:
        """Visible point of a pixel on its triangle."""
        width, height = camera["width"], camera["height"]
        eye, forward, right, upward = self._axes(camera)
        h = self._half_width(camera)
        x = (pixel % width).astype(np.float32) + np.float32(0.5)
        y = (pixel // width).astype(np.float32) + np.float32(0.5)
        along_x = (2 * x / np.float32(width) - 1) * h
        along_y = (height - 2 * y) / np.float32(width) * h
        d = along_x[:, None] * right + along_y[:, None] * upward + forward
        n = np.cross(b - a, c - a)
        t = quotient(dot(n, a - eye), dot(n, d))
        p = eye + t[:, None] * d
        hit = t > 0
        for start, end in ((a, b), (b, c), (c, a)):
            hit &= dot(n, np.cross(end - start, p - start)) > 0
        normal = self._turned(length_and_direction(np.zeros_like(n), n)[1], d)
        depth = dot(forward, p - eye)
        zero = np.float32(0)
        return {
            "hit": hit.astype(np.uint32),
            "position": np.where(hit[:, None], p, zero),
            "normal": np.where(hit[:, None], normal, zero),
            "depth": np.where(hit, depth, zero),
        }

    def _turned(self, normal: Array, d: Array) -> Array:
        """Normal on the side that is seen."""
        return np.where((dot(normal, d) > 0)[:, None], -normal, normal)

    def reproject(
        self,
        *,
        position: Array,
        normal: Array,
        hit: Array,
        normal_before: Array,
        depth_before: Array,
        max_angle: float,
        max_depth: float,
        **camera: Any,
    ) -> Buffers:
        """Row of the last frame."""
        width, height = camera["width"], camera["height"]
        eye, forward, right, upward = self._axes(camera)
        o = position - eye
        z = dot(o, forward)
        per_pixel = 2 * z * self._half_width(camera)
        scale = np.float32(width)
        x = scale / 2 + quotient(dot(o, right) * scale, per_pixel)
        y = np.float32(height) / 2 - quotient(dot(o, upward) * scale, per_pixel)
        inside = (hit == 1) & (z > 0)
        inside &= (x >= 0) & (x < width) & (y >= 0) & (y < height)
        at_x, at_y = (np.where(inside, one, np.float32(0)) for one in (x, y))
        row = self._row_at(at_x, at_y, width, height).astype(np.int64)
        similar = self._alike(
            normal, z, normal_before[row], depth_before[row], max_angle, max_depth
        )
        return {"row": np.where(inside & similar, row, -1).astype(np.int32)}

    def _row_at(self, x: Array, y: Array, width: int, height: int) -> Array:
        """Row of the pixel that a point of the image lies in."""
        return np.floor(y) * width + np.floor(x)

    # ------------------------------------------------------------------ filters

    def validation(
        self,
        *,
        W: Array,
        M: Array,
        radiance_then: Array,
        radiance_now: Array,
        met: Array,
        null: Array,
        tolerance: float,
    ) -> Buffers:
        """Reservoirs whose sample is what it was."""
        a, b = self._luminance(radiance_then), self._luminance(radiance_now)
        same = np.abs(a - b) <= np.float32(tolerance) * np.maximum(a, b)
        stays = self._stays(same, met == 1, null == 1)
        return {"W": np.where(stays, W, 0), "M": np.where(stays, M, 0)}

    def _stays(self, same: Array, met: Array, null: Array) -> Array:
        """Whether a reservoir is still valid."""
        return null | met & same

    def boiling(
        self, *, radiance: Array, W: Array, M: Array, width: int, strength: float
    ) -> Buffers:
        """Reservoirs that do not outshine their tile."""
        light = product(self._luminance(radiance), W)
        row = np.arange(len(light))
        tile = row // width // 16 * -(-width // 16) + row % width // 16
        counts = np.zeros(tile.max(initial=0) + 1, np.float32)
        sums = np.zeros_like(counts)
        np.add.at(counts, tile, self._counted(light).astype(np.float32))
        with np.errstate(all="ignore"):
            np.add.at(sums, tile, light)
        mean = quotient(finite(sums), counts)[tile]
        strength = np.float32(strength)
        bright = product(light, strength)
        stays = bright <= product(mean, 10 - 9 * strength)
        return {"W": np.where(stays, W, 0), "M": np.where(stays, M, 0)}

    def _counted(self, light: Array) -> Array:
        """Pixels of which the mean is taken."""
        return light > 0

    def checkerboard(
        self, *, pixel: Array, has_history: Array, width: int, frame: int
    ) -> Buffers:
        """Which pixels draw."""
        x, y = pixel % width, pixel // width
        draws = self._even(pixel, x, y, frame) | (has_history == 0)
        return {"draws": draws.astype(np.uint32)}

    def _even(self, pixel: Array, x: Array, y: Array, frame: int) -> Array:
        """Whether it is a pixel's turn."""
        return (x + y + frame) % 2 == 0

    def roulette(
        self, *, pixel: Array, width: int, frame: int, seed: int, probability: float
    ) -> Buffers:
        """Weight of the tail."""
        x, y = pixel % width, pixel // width
        tile = y // 32 * self._tiles_across(width) + x // 64
        key = np.zeros((len(pixel), 4), np.uint32)
        key[:, 0], key[:, 1], key[:, 2], key[:, 3] = tile, frame, seed, 7 * 64
        u = self.random(key=key)["u"][:, 0]
        share = np.float32(probability)
        return {"weight": np.where(u < share, 1 / share, np.float32(0))}

    def _tiles_across(self, width: int) -> int:
        """Tiles in a row, with the one that is cut off."""
        return -(-width // 64)

    # --------------------------------------------------------------------- bits

    def pack(
        self,
        *,
        visible_position: Array,
        visible_normal: Array,
        position: Array,
        normal: Array,
        radiance: Array,
        W: Array,
        M: Array,
        seed: Array,
    ) -> Buffers:
        """Twelve words a row."""
        words = np.zeros((len(W), 12), np.uint32)
        words[:, 0:3] = visible_position.astype("<f4").view("<u4")
        words[:, 3] = self._packed_normal(visible_normal)
        words[:, 4:7] = position.astype("<f4").view("<u4")
        words[:, 7] = self._packed_normal(normal)
        half = self._half(radiance).view("<u2").astype(np.uint32)
        confidence = np.rint(np.minimum(M, np.float32(65535)))
        confidence = np.where(M > 0, np.maximum(confidence, 1), 0).astype(np.uint32)
        words[:, 8] = half[:, 0] | half[:, 1] << np.uint32(16)
        words[:, 9] = half[:, 2] | confidence << np.uint32(16)
        words[:, 10] = W.astype("<f4").view("<u4")
        words[:, 11] = seed
        return {"words": words}

    def _half(self, radiance: Array) -> Array:
        """In half precision."""
        return np.clip(radiance, -LARGEST_HALF, LARGEST_HALF).astype("<f2")

    def _packed_normal(self, n: Array) -> Array:
        """In octahedral coordinates, two int16 in a word."""
        s = np.abs(n[:, 0]) + np.abs(n[:, 1]) + np.abs(n[:, 2])
        u, v = quotient(n[:, 0], s), quotient(n[:, 1], s)
        folded_u, folded_v = self._fold(u, v)
        u, v = np.where(n[:, 2] < 0, folded_u, u), np.where(n[:, 2] < 0, folded_v, v)
        code_u, code_v = (
            np.rint(one * np.float32(32767)).astype(np.int32).view(np.uint32)
            & np.uint32(0xFFFF)
            for one in (u, v)
        )
        return code_u | code_v << np.uint32(16)

    def _fold(self, u: Array, v: Array) -> tuple[Array, Array]:
        """The lower half of the octahedron, turned outwards."""
        one = np.float32(1)
        sign_u, sign_v = np.where(u >= 0, one, -one), np.where(v >= 0, one, -one)
        return (1 - np.abs(v)) * sign_u, (1 - np.abs(u)) * sign_v

    def unpack(self, *, words: Array) -> Buffers:
        """Fields of a reservoir."""
        halves = [
            words[:, 8] & np.uint32(0xFFFF),
            words[:, 8] >> np.uint32(16),
            words[:, 9] & np.uint32(0xFFFF),
        ]
        return {
            "visible_position": self._read_floats(words[:, 0:3]),
            "visible_normal": self._unpacked_normal(words[:, 3]),
            "position": self._read_floats(words[:, 4:7]),
            "normal": self._unpacked_normal(words[:, 7]),
            "radiance": self._read_halves(np.stack(halves, axis=1)),
            "W": self._read_floats(words[:, 10]),
            "M": (words[:, 9] >> np.uint32(16)).astype(np.float32),
            "seed": words[:, 11],
        }

    def _read_floats(self, words: Array) -> Array:
        """Of single precision."""
        with np.errstate(all="ignore"):
            return finite(np.ascontiguousarray(words).view(np.float32))

    def _read_halves(self, codes: Array) -> Array:
        """Of half precision."""
        with np.errstate(all="ignore"):
            found = codes.astype(np.uint16).view(np.float16).astype(np.float32)
        return np.nan_to_num(
            found, nan=0.0, posinf=LARGEST_HALF, neginf=-LARGEST_HALF
        ).astype(np.float32)

    def _unpacked_normal(self, word: Array) -> Array:
        """Unit normal."""
        u, v = (
            np.maximum(code.astype(np.uint16).view(np.int16), np.int16(-32767))
            / np.float32(32767)
            for code in (word & np.uint32(0xFFFF), word >> np.uint32(16))
        )
        z = 1 - np.abs(u) - np.abs(v)
        folded_u, folded_v = self._fold(u, v)
        u, v = np.where(z < 0, folded_u, u), np.where(z < 0, folded_v, v)
        n = np.stack([u, v, z], axis=1)
        return n / np.sqrt(dot(n, n))[:, None]
