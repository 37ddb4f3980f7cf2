"""A renderer in the manner of RTXDI, in single precision, with numbers of its own.

Reservoirs of 32 bytes, its own sample first, the past capped as it arrives, the sum of
weights divided with the balance heuristic of targets, asked with rays at the sources,
visibility in the final shading alone, and no spatial history.  Whoever makes a mistake
overrides the method in which it is made.
"""

import numpy as np

from tests.captures import packed
from tests.captures.packed import F
from tests.captures.room import PAINT, cast, dot, glow, sees, unit

SAMPLE = ("position", "normal", "radiance")
PI = F(np.pi)


def luminance(color):
    """Of Rec. 709."""
    return (color @ np.array([0.2126, 0.7152, 0.0722], F)).astype(F)


def hashed(*numbers):
    """A random number in [0, 1) of each pixel, from whole numbers."""
    state = np.uint32(0x9E3779B9)
    with np.errstate(over="ignore"):
        for number in numbers:
            state = (np.asarray(number, np.uint32) ^ state) * np.uint32(747796405)
            state = state + np.uint32(2891336453)
            word = ((state >> ((state >> 28) + 4)) ^ state) * np.uint32(277803737)
            state = (word >> 22) ^ word
    return (state >> 8).astype(F) * F(2.0**-24)


def only(r, keep):
    """Rows of a dict of arrays."""
    return {name: array[keep] for name, array in r.items()}


def where(mask, a, b):
    """A dict of arrays, from one of two."""
    return {
        n: np.where(mask.reshape(-1, *[1] * (a[n].ndim - 1)), a[n], b[n]) for n in a
    }


def lobe(n, v, d, alpha, f0):
    """GGX with separable masking and Schlick's reflectance, as shaders write it."""
    h = unit(v + d)
    n_d, n_v = np.maximum(dot(n, d), F(1e-7)), np.maximum(dot(n, v), F(1e-7))
    n_h, d_h = np.clip(dot(n, h), 0, 1), np.clip(dot(d, h), 0, 1)
    a2 = alpha * alpha
    t = (n_h * a2 - n_h) * n_h + 1
    D = a2 / (PI * t * t)
    masks = [2 * c / (c + np.sqrt(a2 + (1 - a2) * c * c)) for c in (n_d, n_v)]
    F5 = (1 - d_h) ** 5
    fresnel = f0 + (1 - f0) * F5[:, None]
    return fresnel * (D * masks[0] * masks[1] / (4 * n_d * n_v))[:, None]


class Engine:
    """Frames one after the other.

    Parameters
    ----------
    size : int; pixels on a side
    cap : float; of M, in frames
    """

    size, cap, around, reach = 64, F(20), 2, 12
    named, surface, fused = (), "lambertian", False
    same_normal, same_depth = 0.5, 0.1

    def __init__(self, size=size, seed=1):
        self.size, self.seed = size, seed
        self.rows = np.arange(size * size)
        self.frames = []
        self.memory = {}

    # ------------------------------------------------------------ what is seen

    def eye(self, frame):
        """Of the camera, which moves."""
        return np.array([-0.3 + 0.04 * frame, 0.1, 3.0], F)

    def gbuffer(self, frame):
        """Visible points through pixel centres; a normal of 0 where nothing is seen."""
        y, x = np.divmod(self.rows, self.size)
        at = np.column_stack(
            [2 * (x + 0.5) / self.size - 1, 1 - 2 * (y + 0.5) / self.size]
        )
        d = unit(np.column_stack([0.5 * at, np.full(len(at), -1)]).astype(F))
        o = np.broadcast_to(self.eye(frame), d.shape).astype(F)
        t, position, n, which = cast(o, d)
        hit = np.isfinite(t)
        return {
            "position": position,
            "normal": np.where(hit[:, None], n, 0).astype(F),
            "albedo": np.where(hit[:, None], PAINT[which], 0).astype(F),
            "depth": np.where(hit, -(position - o)[:, 2], 0).astype(F),
        }

    def random(self, frame, stream, dimension=0):
        """A number in [0, 1) of each pixel."""
        return hashed(self.rows, frame, stream, dimension, self.seed)

    # ------------------------------------------------------------ kernels

    def target(self, x, y):
        """Luminance of what the visible point reflects, without visibility."""
        v = y["position"] - x["position"]
        d = unit(np.where((v != 0).any(axis=1)[:, None], v, F(1)))
        cosine = dot(x["normal"], d)
        lit = (cosine > 0) & (dot(y["normal"], d) < 0)
        color = self.brdf(x, d) * y["radiance"] * cosine[:, None]
        return np.where(lit, luminance(color), F(0))

    def brdf(self, x, d):
        """What visible points reflect of light that arrives from directions, (N, 3)."""
        return x["albedo"] / PI

    def jacobian(self, x_from, x_to, y):
        """Of the reconnection shift."""
        a, b = x_from["position"] - y["position"], x_to["position"] - y["position"]
        aa, bb = dot(a, a), dot(b, b)
        cosine_a = np.abs(dot(y["normal"], a)) / np.sqrt(aa)
        cosine_b = np.abs(dot(y["normal"], b)) / np.sqrt(bb)
        with np.errstate(divide="ignore", invalid="ignore"):
            J = cosine_b / cosine_a * aa / bb
        return np.where(np.isfinite(J), J, F(0))

    def sees(self, x, y):
        """Whether a visible point sees a sample."""
        off = x["position"] + F(2e-3) * x["normal"]
        return sees(off, y["position"] + F(2e-3) * y["normal"])

    def accepts(self, u, before, w):
        """Whether the next candidate is kept."""
        return u * (before + w) < w

    # ------------------------------------------------------------ passes

    def initial(self, frame, x):
        """One sample of the cosine about the normal; a miss is a null, and counts."""
        u0, u1 = (self.random(frame, 1, k) for k in range(2))
        root, turn = np.sqrt(u0), 2 * PI * u1
        up = np.where(np.abs(x["normal"][:, :1]) > 0.7, F([0, 1, 0]), F([1, 0, 0]))
        seen = (x["normal"] != 0).any(axis=1)
        n = np.where(seen[:, None], x["normal"], F([0, 0, 1]))
        s = unit(np.cross(up, n))
        t = np.cross(n, s)
        up_cosine = np.sqrt(1 - u0)
        d = (
            (root * np.cos(turn))[:, None] * s
            + (root * np.sin(turn))[:, None] * t
            + up_cosine[:, None] * n
        ).astype(F)
        far, position, normal, which = cast(x["position"] + F(1e-3) * n, d)
        met = np.isfinite(far)[:, None]
        pdf = np.maximum(up_cosine, F(1e-4)) / PI
        return {
            "position": np.where(met, position, x["position"] + d).astype(F),
            "normal": np.where(met, normal, -d).astype(F),
            "radiance": np.where(met, glow(position, which), 0).astype(F),
            "W": np.where(seen, 1 / pdf, 0).astype(F),
            "M": seen.astype(F),
        }

    def history(self, frame, x, x_before):
        """Row of the pixel that saw the point in the last frame, or −1."""
        v = x["position"] - self.eye(frame - 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = v[:, :2] / (-v[:, 2:]) / F(0.5)
            column = np.floor((at[:, 0] + 1) / 2 * self.size)
            line = np.floor((1 - at[:, 1]) / 2 * self.size)
        inside = (column >= 0) & (column < self.size) & (line >= 0) & (line < self.size)
        inside &= x["depth"] > 0
        row = np.where(inside, line * self.size + column, 0).astype(int)
        return np.where(inside & self.alike(x, only(x_before, row)), row, -1)

    def alike(self, a, b):
        """Whether two pixels may share samples."""
        near = np.abs(a["depth"] - b["depth"]) < self.same_depth * np.maximum(
            a["depth"], b["depth"]
        )
        return near & (dot(a["normal"], b["normal"]) > self.same_normal)

    def neighbors(self, frame, x):
        """Rows of the neighbours of each pixel, reflected at the borders, or −1."""
        found = []
        y, column = np.divmod(self.rows, self.size)
        for k in range(self.around):
            r = self.reach * np.sqrt(self.random(frame, 3, 2 * k))
            turn = 2 * PI * self.random(frame, 3, 2 * k + 1)
            i = np.abs(column + np.rint(r * np.cos(turn)).astype(int))
            j = np.abs(y + np.rint(r * np.sin(turn)).astype(int))
            last = self.size - 1
            i, j = (np.where(a > last, 2 * last - a, a) for a in (i, j))
            row = j * self.size + i
            use = (row != self.rows) & self.alike(x, only(x, row)) & (x["depth"] > 0)
            found.append(np.where(use, row, -1))
        return np.stack(found, axis=1)

    def resample(self, x, candidates, decide):
        """The stream of the pixel's own sample and of others.

        Parameters
        ----------
        candidates : list of (x_from, r, there); the own sample first
        decide : callable; gives the number that decides on candidate k
        """
        own = candidates[0][1]
        kept, maker = {n: own[n] for n in SAMPLE}, np.zeros(len(own["W"]), int)
        total = self.weight(x, x, own)
        p_hat, M = self.target(x, own), own["M"].copy()
        for k, (x_from, r, there) in enumerate(candidates[1:], start=1):
            w = np.where(there, self.weight(x_from, x, r), F(0))
            take = (w > 0) & self.accepts(decide(k), total, w)
            kept = where(take, {n: r[n] for n in SAMPLE}, kept)
            maker = np.where(take, k, maker)
            p_hat = np.where(take, self.target(x, r), p_hat)
            total, M = total + w, M + self.counted(x, r, there)
        share = self.share(x, candidates, kept, maker)
        with np.errstate(divide="ignore", invalid="ignore"):
            W = np.where((p_hat > 0) & (total > 0), total * share / p_hat, F(0))
        return kept | {"W": np.where(np.isfinite(W), W, F(0)), "M": M}

    def weight(self, x_from, x, r):
        """Resampling weight."""
        J = F(1) if x_from is x else self.jacobian(x_from, x, r)
        return np.where(r["W"] > 0, self.target(x, r) * r["W"] * r["M"] * J, F(0))

    def counted(self, x, r, there):
        """M that a candidate adds."""
        return np.where(there, r["M"], F(0))

    def share(self, x, candidates, kept, maker):
        """π / Σ π M of the balance heuristic, with rays at the sources."""
        whole, own = np.zeros(len(maker), F), np.zeros(len(maker), F)
        for k, (x_from, r, there) in enumerate(candidates):
            p = self.source_density(x_from, x, kept)
            own = np.where(maker == k, p, own)
            whole = whole + np.where(there, p * r["M"], F(0))
        return np.divide(own, whole, out=np.zeros_like(whole), where=whole > 0)

    def source_density(self, x_from, x, kept):
        """Target at a source, 0 where that does not see the sample."""
        p = self.target(x_from, kept)
        return p if x_from is x else np.where(self.sees(x_from, kept), p, F(0))

    def arrived(self, r):
        """The past, with M capped."""
        return r | {"M": np.minimum(r["M"], self.cap)}

    def temporal(self, frame, x, x_before, new, past, row):
        """The new sample, then the past of the pixel."""
        there, at = row >= 0, np.maximum(row, 0)
        past = self.arrived(only(past, at))
        past = past | {n: np.where(there, past[n], F(0)) for n in ("W", "M")}
        everywhere = np.ones(len(row), bool)
        candidates = [(x, new, everywhere), (only(x_before, at), past, there)]
        return self.resample(x, candidates, lambda k: self.random(frame, 2, k))

    def spatial(self, frame, x, own, reservoirs, around):
        """The pixel's own, then its neighbours."""
        candidates = [(x, own, np.ones(len(around), bool))]
        for k in range(around.shape[1]):
            at = np.maximum(around[:, k], 0)
            there = around[:, k] >= 0
            candidates.append((only(x, at), only(reservoirs, at), there))
        return self.resample(x, candidates, lambda k: self.random(frame, 4, k))

    def shade(self, x, r):
        """What the pixel reflects of what it sees, (N, 3)."""
        v = r["position"] - x["position"]
        d = unit(np.where((v != 0).any(axis=1)[:, None], v, F(1)))
        cosine = dot(x["normal"], d)
        lit = (cosine > 0) & (dot(r["normal"], d) < 0) & self.sees(x, r)
        color = self.brdf(x, d) * r["radiance"] * (cosine * r["W"])[:, None]
        return np.where(lit[:, None], color, 0).astype(F)

    # ------------------------------------------------------------ frames

    def run(self, frames):
        """Frames from 0 on; what they leave is appended to ``frames``."""
        for frame in range(frames):
            self.frames.append(self.frame(frame))
        return self.frames

    def stored(self, r, frame=0):
        """What memory holds of reservoirs."""
        return packed.pack(r)

    def loaded(self, bits):
        """Reservoirs from memory."""
        return packed.unpack(bits)

    def past(self, frame):
        """Reservoirs of the last frame, as memory holds them."""
        return self.memory["spatial"]

    def frame(self, frame):
        """One frame, and all buffers that it leaves."""
        x = self.gbuffer(frame)
        out = {"gbuffer": x, "initial": self.stored(self.initial(frame, x))}
        new = self.loaded(out["initial"])
        x_before = self.memory.get("gbuffer")
        if x_before is None:
            row, x_before = np.full(len(self.rows), -1), x
            past = {n: np.zeros_like(a) for n, a in new.items()}
        else:
            row, past = self.history(frame, x, x_before), self.loaded(self.past(frame))
        out["history"] = row
        merged = self.temporal(frame, x, x_before, new, past, row)
        out["temporal"] = self.stored(merged)
        out["visible_temporal"] = self.bits_temporal(x, x_before, new, past, row)
        out["neighbors"] = self.neighbors(frame, x)
        own = self.loaded(out["temporal"])
        final = self.spatial(frame, x, own, self.others(own), out["neighbors"])
        out["spatial"] = self.stored(final)
        out["visible_spatial"] = self.bits_spatial(x, own, out["neighbors"])
        out["shade"] = self.shade(x, self.loaded(out["spatial"]))
        out["visible_shade"] = Engine.sees(self, x, self.loaded(out["spatial"]))
        self.memory |= {"gbuffer": x, "spatial": out["spatial"]}
        self.memory |= {"temporal": out["temporal"]}
        return out

    def others(self, own):
        """Reservoirs that are read as those of neighbours."""
        return own

    # ------------------------------------------------------------ bits, for the dump

    def bits_temporal(self, x, x_before, new, past, row):
        """Who sees which: the pixel and its past, the new sample and the past's."""
        at = np.maximum(row, 0)
        samples, viewers = (new, only(past, at)), (x, only(x_before, at))
        return self._bits(viewers, samples)

    def bits_spatial(self, x, own, around):
        """Pixel and neighbours; the own sample, and those of neighbours."""
        rows = [np.maximum(around[:, k], 0) for k in range(around.shape[1])]
        samples = [own, *(only(own, row) for row in rows)]
        return self._bits([x, *(only(x, row) for row in rows)], samples)

    def _bits(self, viewers, samples):
        words = np.zeros((len(self.rows), len(viewers)), np.uint32)
        for j, x in enumerate(viewers):
            for k, y in enumerate(samples):
                seen = Engine.sees(self, x, y).astype(np.uint32)
                words[:, j] |= seen << np.uint32(k)
        return words


class GlossyEngine(Engine):
    """The same, with a GGX lobe on all surfaces."""

    surface = "ggx"

    def gbuffer(self, frame):
        """Visible points, with their material and the way to the eye."""
        x = super().gbuffer(frame)
        v = unit((self.eye(frame) - x["position"]).astype(F))
        red = x["albedo"][:, 0]
        return x | {
            "view": v.astype(F),
            "alpha": (F(0.15) + F(0.5) * red).astype(F),
            "f0": (F(0.04) + F(0.3) * x["albedo"][:, ::-1]).astype(F),
        }

    def brdf(self, x, d):
        """Diffuse and lobe; nothing where the eye is below the horizon."""
        found = super().brdf(x, d) + lobe(
            x["normal"], x["view"], d, x["alpha"], x["f0"]
        )
        return np.where((dot(x["normal"], x["view"]) > 0)[:, None], found, F(0))
