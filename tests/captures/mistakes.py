"""Mistakes in an engine, one at a time.

Each class says in its first line what is wrong, and in ``named`` by which words the
oracle names it; of some it tells no more than where they are wrong.
"""

import numpy as np

from tests.captures import packed
from tests.captures.engine import Engine, where
from tests.captures.packed import F


class JacobianLeftOut(Engine):
    """The Jacobian is left out."""

    named = ("jacobian-omitted",)

    def jacobian(self, x_from, x_to, y):
        """1."""
        return np.ones(len(self.rows), F)


class JacobianInverted(Engine):
    """The Jacobian is inverted."""

    named = ("jacobian-inverted",)

    def jacobian(self, x_from, x_to, y):
        """Its inverse."""
        return super().jacobian(x_to, x_from, y)


class CosinesLeftOut(Engine):
    """The Jacobian has distances alone."""

    named = ("jacobian-without-cosines",)

    def jacobian(self, x_from, x_to, y):
        """Of a sphere about the sample."""
        a, b = x_from["position"] - y["position"], x_to["position"] - y["position"]
        with np.errstate(divide="ignore", invalid="ignore"):
            J = (a * a).sum(axis=1) / (b * b).sum(axis=1)
        return np.where(np.isfinite(J), J, F(0)).astype(F)


class DividedByConfidences(Engine):
    """The sum of weights is divided by all confidences, where shifts may fail."""

    named = ("one-over-m",)

    def share(self, x, candidates, kept, maker):
        """1 / M."""
        M = sum(np.where(there, r["M"], F(0)) for _, r, there in candidates)
        return np.divide(1, M, out=np.zeros_like(M), where=M > 0)


class BlindSources(Engine):
    """The sources are not asked whether they see the sample."""

    named = ("visibility-missing-in-z",)

    def source_density(self, x_from, x, kept):
        """Target alone."""
        return self.target(x_from, kept)


class HiddenUncounted(Engine):
    """Candidates that the pixel does not see do not count."""

    named = ("M is 1 where x does not see",)

    def counted(self, x, r, there):
        """M of what is seen."""
        return np.where(there & self.sees(x, r), r["M"], F(0))


class DarkUncounted(Engine):
    """Candidates without light do not count."""

    named = ("reused-nulls-not-counted",)

    def counted(self, x, r, there):
        """M of what has light."""
        return np.where(there & (self.target(x, r) > 0), r["M"], F(0))


class TargetOfSource(Engine):
    """Weights take the target at the source."""

    named = ("cos θ_from / cos θ",)

    def weight(self, x_from, x, r):
        """Of the source."""
        J = F(1) if x_from is x else self.jacobian(x_from, x, r)
        return np.where(r["W"] > 0, self.target(x_from, r) * r["W"] * r["M"] * J, F(0))


class WithoutConfidence(Engine):
    """Weights have no M."""

    named = ("confidence-missing-in-weight",)

    def weight(self, x_from, x, r):
        """Without M."""
        return super().weight(x_from, x, r | {"M": np.ones_like(r["M"])})


class SumBefore(Engine):
    """A candidate is held against the sum before it."""

    named = ("accepts-by-the-old-sum",)

    def accepts(self, u, before, w):
        """Too often."""
        return u * before < w


class SharedNumber(Engine):
    """One random number decides on all candidates."""

    named = ("one-number-for-all-decisions",)

    def random(self, frame, stream, dimension=0):
        """The same in streams of decisions."""
        return super().random(frame, stream, 0 if stream in (2, 4) else dimension)


class SlightlyUneven(Engine):
    """Each next candidate is kept 5 % too often."""

    size = 256
    named = ("where the weights say",)

    def accepts(self, u, before, w):
        """As if it weighed more."""
        return u * (before + w) < F(1.05) * w


class CapAfterW(Engine):
    """M is capped after W was calculated with a sum of weights that is not."""

    named = ("M is cut off at 8",)

    def arrived(self, r):
        """Not capped as it arrives."""
        return r

    def stored(self, r, frame=0):
        """M of what is stored is 8 at most, of a sum for more."""
        return packed.pack(r | {"M": np.minimum(r["M"], F(8)), "W": self._late(r)})

    def _late(self, r):
        over = np.maximum(r["M"], F(1)) / np.maximum(np.minimum(r["M"], F(8)), F(1))
        return r["W"] * over


class ReadWhileWritten(Engine):
    """Neighbours are read from the buffer that is written, by half of the pixels."""

    named = ("while they are written",)

    def spatial(self, frame, x, own, reservoirs, around):
        """In two halves, of which the second reads what the first has written."""
        first = super().spatial(frame, x, own, reservoirs, around)
        early = self.rows % 2 == 0
        stored = self.loaded(self.stored(first))
        seen = where(early, stored, reservoirs)
        second = super().spatial(frame, x, own, seen, around)
        return where(early, first, second)


class NotSwapped(Engine):
    """The buffers of past and present are not swapped: the past is a frame too old."""

    named = ("2 frames ago",)

    def past(self, frame):
        """Of the frame before the last."""
        found = self.memory.get("older", self.memory["spatial"])
        self.memory["older"] = self.memory["spatial"]
        return found


class TemporalAgain(Engine):
    """The past is read from the temporal reservoirs, not from those of Algorithm 4."""

    named = ("temporal reservoirs of the last frame",)

    def past(self, frame):
        """The other buffer."""
        return self.memory["temporal"]


class PastViewerForgotten(Engine):
    """The visible points of the past are taken for those of this frame."""

    named = ("visible points of the past are those of this frame",)

    def temporal(self, frame, x, x_before, new, past, row):
        """In place of the last ones, at the same row."""
        return super().temporal(frame, x, x, new, past, row)


class SignedNormal(Engine):
    """Normals of samples that face backwards are unpacked without their fold."""

    named = ()

    def loaded(self, bits):
        """The lower half of the octahedron is read as if it were the upper."""
        found = packed.unpack(bits)
        xy = np.stack([bits["normal"] & 0xFFFF, bits["normal"] >> 16], axis=1)
        xy = xy.astype(np.uint16).view(np.int16).astype(F) / F(32767)
        z = np.abs(1 - np.abs(xy).sum(axis=1))
        n = np.column_stack([xy, z]).astype(F)
        return found | {"normal": n / np.linalg.norm(n, axis=1)[:, None].astype(F)}


class StaleTarget(Engine):
    """W is divided by the target of the pixel's own sample, whichever was kept."""

    named = ("target-of-the-first",)

    def resample(self, x, candidates, decide):
        """W of another target."""
        r = super().resample(x, candidates, decide)
        own, p = self.target(x, candidates[0][1]), self.target(x, r)
        ratio = np.divide(p, own, out=np.zeros_like(p), where=own > 0)
        return r | {"W": r["W"] * ratio}


class QuotientOfZeros(Engine):
    """W is 0 / 0 where nothing is kept."""

    named = ()

    def resample(self, x, candidates, decide):
        """Without a guard."""
        r = super().resample(x, candidates, decide)
        return r | {"W": np.where(r["W"] > 0, r["W"], F(np.nan))}


MISTAKES = (
    JacobianLeftOut,
    JacobianInverted,
    CosinesLeftOut,
    DividedByConfidences,
    BlindSources,
    HiddenUncounted,
    DarkUncounted,
    TargetOfSource,
    WithoutConfidence,
    SumBefore,
    SharedNumber,
    SlightlyUneven,
    CapAfterW,
    ReadWhileWritten,
    NotSwapped,
    TemporalAgain,
    PastViewerForgotten,
    SignedNormal,
    StaleTarget,
    QuotientOfZeros,
)
