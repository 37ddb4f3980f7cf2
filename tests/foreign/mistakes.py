"""Mistakes, each a few lines on top of a renderer that may depart in any way."""

import numpy as np

from tests.foreign import kernels as k
from tests.foreign.kernels import F
from tests.foreign.renderer import FIRST, ORDERS, OWN, ForeignRenderer, pairwise


def within(J, limit):
    """Whether J and 1 / J are at most so large."""
    return np.maximum(J, k.quotient(F(1), J)) <= limit


class RefusedOneWay(ForeignRenderer):
    """Samples with J beyond [1/10, 10] are refused; Z counts as if they were not."""

    def _jacobians(self, x, s):
        J = super()._jacobians(x, s)
        return np.where(within(J, F(10)), J, F(0))


class RefusedThenClamped(ForeignRenderer):
    """J beyond [1/10, 10] is refused, and what is left is clamped to [1/3, 3]."""

    def _jacobians(self, x, s):
        J = super()._jacobians(x, s)
        return np.where(within(J, F(10)), np.clip(J, F(1 / 3), F(3)), F(0))


class ClampedJacobian(ForeignRenderer):
    """J is clamped to [1/3, 3]."""

    def _jacobian(self, x_from, x_to, y):
        J = super()._jacobian(x_from, x_to, y)
        return np.where(J > 0, np.clip(J, F(1 / 3), F(3)), J)


class InvertedJacobian(ForeignRenderer):
    """The two points are mistaken for each other."""

    def _jacobian(self, x_from, x_to, y):
        return super()._jacobian(x_to, x_from, y)


class DividedByJacobian(ForeignRenderer):
    """The Jacobian is right, and the weight is divided by it."""

    def _jacobians(self, x, s):
        return k.quotient(F(1), super()._jacobians(x, s))


class RefusedNotCounted(ForeignRenderer):
    """A refused shift takes its confidence with it, which so depends on the sample."""

    def _confidences(self, s, J, asked):
        return super()._confidences(s, J, asked) * (J > 0)


class HiddenNotCounted(ForeignRenderer):
    """A sample that the receiver does not see takes its confidence with it."""

    def _confidences(self, s, J, asked):
        return super()._confidences(s, J, asked) * s.seen


class NullsNotCounted(ForeignRenderer):
    """A ray that met nothing leaves no reservoir: M = 0."""

    def _new_confidence(self, y, p_hat):
        return (p_hat > 0).astype(F)


class UnlitWeight(ForeignRenderer):
    """W = 1 / pdf also of samples that are dark to their own pixel alone."""

    def initial(self, pdf, **given):
        """A new sample becomes a reservoir."""
        return super().initial(pdf=pdf, **given) | {"W": k.quotient(F(1), pdf)}


class DegenerateRejected(ForeignRenderer):
    """Geometry is tested before anything is counted: a normal of 0 is no sample."""

    def _new_confidence(self, y, p_hat):
        return (y.normal != 0).any(axis=-1).astype(F)

    def _confidences(self, s, J, asked):
        M = super()._confidences(s, J, asked)
        return M * (s.y.normal != 0).any(axis=-1)


class OneOverM(ForeignRenderer):
    """What is called 1/Z divides by all confidences."""

    def _rule(self, asked):
        return "1/M"


class BlindDomain(ForeignRenderer):
    """The domains of sources, and so their MIS weights, know no visibility."""

    def _there(self, p_hat, J, sees):
        return k.product(p_hat, J)


class HalfJacobians(ForeignRenderer):
    """Who made the sample has its Jacobian in the balance, and the others have not."""

    def _densities(self, x, s, asked, p_hat):
        p = super()._densities(x, s, asked, p_hat)
        own, J = np.eye(p.shape[1], dtype=bool), self._jacobians(x, s)
        return np.where(own, p, k.product(p, J[:, :, None]))


class BackUntested(ForeignRenderer):
    """The target knows no back, and the domain of a source does not ask for J."""

    def _there(self, p_hat, J, sees):
        return k.product(p_hat, sees)


class VisibleInShadingAlone(ForeignRenderer):
    """Samples that the receiver does not see come in, and are hidden when shaded.

    Right where the shading tests visibility and what is reused is not kept for later.
    """

    def _brought(self, p_hat, W, J, seen):
        return super()._brought(p_hat, W, J, True)


class NeverVisible(VisibleInShadingAlone, BlindDomain):
    """Visibility in shading alone, and the domains of sources know none either."""


def pairwise_without_M(M, p, there):
    """Neighbours compare densities as if the receiver's confidence were 1."""
    one = M.copy()
    one[:, OWN] = 1
    others = np.arange(M.shape[1]) != OWN
    return np.where(others, pairwise(one, p, there), pairwise(M, p, there))


def pairwise_without_own(M, p, there):
    """The receiver's own sample is weighed as if there were no neighbours."""
    others = np.arange(M.shape[1]) != OWN
    return np.where(others, pairwise(M, p, there), F(1))


class PairwiseWithoutM(ForeignRenderer):
    """Pairwise weights that leave out M in one of two places."""

    first = FIRST | {"pairwise": pairwise_without_M}


class PairwiseWithoutOwn(ForeignRenderer):
    """Pairwise weights in which the receiver's own is 1."""

    first = FIRST | {"pairwise": pairwise_without_own}


class CanonicalMissing(ForeignRenderer):
    """The sum over sources leaves out the receiver itself."""

    def _divisor(self, rule, M, p, kept, asked):
        Z = super()._divisor(rule, M, p, kept, asked)
        # Who alone can have made the sample is not left out, or W would be infinite.
        left = Z - M[:, OWN]
        return np.where(left > 0, left, Z)


class ChainedFromANeighbor(ForeignRenderer):
    """Merges begin with a neighbour, which is taken for one of the receiver's own."""

    def _chain(self, count):
        return ORDERS[self.options.order](count)


class ChainedByTheirTarget(ForeignRenderer):
    """Merges of two, closed by the target of whoever brought the kept sample."""

    def _chained(self, s, M, p_hat, brought, p):
        kept, W = super()._chained(s, M, p_hat, brought, p)
        ratio = k.quotient(k.pick(p_hat, kept), p[np.arange(len(M)), kept, kept])
        return kept, W * np.where(ratio > 0, ratio, F(1))


class WeightClamped(ForeignRenderer):
    """W is at most 10, against fireflies."""

    def _finalized(self, w, p_hat, Z):
        return np.minimum(super()._finalized(w, p_hat, Z), F(10))


class CappedBeforeWeight(ForeignRenderer):
    """M is capped before W is calculated, and the sum of weights is not."""

    def _divisor(self, rule, M, p, kept, asked):
        Z = super()._divisor(rule, M, p, kept, asked)
        return np.minimum(Z, F(asked.cap))


class CappedInDivisorAlone(ForeignRenderer):
    """The past is capped on arrival in Z, and not in its weight."""

    def _divisor(self, rule, M, p, kept, asked):
        M = np.minimum(M, F(asked.cap))
        return super()._divisor(rule, M, p, kept, asked)


class PastAsItStands(ForeignRenderer):
    """What was seen from another point is reused as if nothing had moved."""

    def _jacobians(self, x, s):
        return np.ones_like(super()._jacobians(x, s))


class OneNumber(ForeignRenderer):
    """One random number decides on all neighbours."""

    def _number(self, u, order, i):
        return super()._number(u, order, min(i, 2))


class SquaredNumber(ForeignRenderer):
    """The random number is squared."""

    def _accepts(self, u, before, w):
        return super()._accepts(u * u, before, w)


class OldSum(ForeignRenderer):
    """A candidate is compared with the sum before it."""

    def _accepts(self, u, before, w):
        return ((u * before < w) | (before <= 0)) & (w > 0)


class NakedAtMost(ForeignRenderer):
    """The comparison u · w_sum ≤ w alone: u = 0 keeps a sample without weight."""

    def _accepts(self, u, before, w):
        return u * (before + w) <= w


class DarkPureColors(ForeignRenderer):
    """Luminance by the least channel: no pure color is ever kept."""

    def _target(self, asked, x, y):
        return super()._target(asked, x, y) * (y.radiance.min(axis=-1) > 0)


class FloorEverywhere(ForeignRenderer):
    """A floor under the target where there is no light either."""

    def _target(self, asked, x, y):
        return np.maximum(super()._target(asked, x, y), F(0.5))


class ClosedByAnotherTarget(ForeignRenderer):
    """The target by which W is divided lacks the albedo, that of the weight has it."""

    def _dividing(self, asked, x, s):
        white = x._replace(albedo=np.ones_like(x.albedo))
        return super()._dividing(asked, white, s)


class CountedDouble(ForeignRenderer):
    """Neighbours weigh double, and are counted once."""

    def _brought(self, p_hat, W, J, seen):
        twice = np.where(np.arange(W.shape[1]) > OWN, F(2), F(1))
        return super()._brought(p_hat, W, J, seen) * twice


class HistoryIgnored(ForeignRenderer):
    """Reuse among neighbours has no history: the past is neither weighed nor counted.

    Right, as M of what is left is that of what came in.
    """

    def spatial(self, past_W, past_M, **given):
        """Pixels resample what their neighbours keep."""
        return super().spatial(past_W=past_W * 0, past_M=past_M * 0, **given)


class HistoryCounted(ForeignRenderer):
    """The past is not weighed, and yet it is counted."""

    def spatial(self, past_W, **given):
        """Pixels resample what their neighbours keep."""
        return super().spatial(past_W=past_W * 0, **given)


class ValidatedAtRandom(ForeignRenderer):
    """Of all rows 15 % lose their weight at random, and keep their confidence."""

    def validation(self, W, M, radiance_then, radiance_now, met, null, tolerance):
        """Reservoirs are emptied."""
        a, b = k.dot(radiance_then, k.REC_709), k.dot(radiance_now, k.REC_709)
        stays = (met != 0) & (np.abs(a - b) <= F(tolerance) * np.maximum(a, b))
        stays |= null != 0
        random = (np.arange(len(W)) * 2654435761 >> 16) % 100 < 15
        return {"W": W * (stays & ~random), "M": M * stays}


class Overflowing(ForeignRenderer):
    """W is infinite where it is too large; within the working range it is right."""

    def _finalized(self, w, p_hat, Z):
        out = np.zeros(np.shape(w), F)
        return np.divide(w, p_hat * Z, out=out, where=p_hat * Z > 0)


class Assembled(ForeignRenderer):
    """Passes that are put together from a backend's kernels, in the contract's way."""

    def __init__(self, kernels):
        super().__init__()
        self._kernels = kernels

    def _target(self, asked, x, y):
        shape = np.broadcast_shapes(x.position.shape, y.position.shape)[:-1]
        names = ("visible_position", "visible_normal", "albedo")
        given = dict(zip(names, map(_flat(shape), x), strict=True))
        names = ("position", "normal", "radiance")
        given |= {name: _flat(shape)(getattr(y, name)) for name in names}
        return self._kernels.target(**given, target=asked)["p_hat"].reshape(shape)

    def _jacobian(self, x_from, x_to, y):
        shape = np.broadcast_shapes(x_from.shape, x_to.shape, y.position.shape)[:-1]
        given = map(_flat(shape), (x_from, x_to, y.position, y.normal))
        return self._kernels.jacobian(*given)["jacobian"].reshape(shape)

    def _accepts(self, u, before, w):
        zero = np.zeros_like(w)
        return self._kernels.merge(before, zero, w, zero, u)["second"] != 0

    def _finalized(self, w, p_hat, Z):
        return self._kernels.finalize(w, p_hat, Z)["W"]


def _flat(shape):
    def flattened(a):
        return np.broadcast_to(a, (*shape, 3)).reshape(-1, 3)

    return flattened
