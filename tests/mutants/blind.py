"""Mistakes of engineers who port the page of the contract, and what is said of them.

Each is the float32 port with one step done wrong.  They were planned from the contract
alone, before any verdict on them was seen, and are not changed since.  The first line
of each says what is wrong; the others, which frames show it.  ``python -m
tests.mutants.blind`` prints the verdicts; names of mistakes choose among them.
"""

import sys
import time

import numpy as np

from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.verdict import Verdict
from tests.mutants.blind_port import (
    PI,
    Array,
    Buffers,
    Port,
    bit,
    dot,
    length_and_direction,
)

# -------------------------------------------------------------------------- kernels


class WordsDividedByTheirRange(Port):
    """Random numbers are words · 2⁻³², which rounds the largest words up to 1.

    A number of 1 is outside of [0, 1), and one in 2²⁵ words gives it; most others have
    more digits than multiples of 2⁻²⁴.
    """

    def _unit(self, words: Array) -> Array:
        return words.astype(np.float32) * np.float32(2**-32)


class DensityOfTheOtherSource(Port):
    """The density is that of the uniform hemisphere whatever the source is.

    Every frame with source cosine: new samples are weighted with a wrong density.
    """

    def _density(self, cos: Array, source: str) -> Array:
        return super()._density(cos, "uniform")


class HalfOfTheAzimuth(Port):
    """The azimuth is π u₁, so that half of the hemisphere is never drawn.

    Every frame: light from the other half is missing.
    """

    def _azimuth(self, u1: Array) -> Array:
        return PI * u1


class GrazingLightIsCut(Port):
    """The target is 0 where the cosine at the visible point is below 0.05.

    Light that arrives at more than 87 degrees is missing: floors beside a lit wall.
    """

    def _above(self, cos: Array) -> Array:
        return cos > np.float32(0.05)


class BackOfTheSampleShines(Port):
    """Whether the sample shows its back is not asked: n_s·ω may be of either sign.

    A neighbour around a thin wall brings a sample whose back the pixel would see.
    """

    def _lit(self, cos_sample: Array) -> Array:
        return np.full(cos_sample.shape, True)


class DistancesAreNotSquared(Port):
    """In the Jacobian the ratio of the distances is not squared.

    Every frame in which a sample is reused from another point.
    """

    def _spread(self, ratio: Array) -> Array:
        return ratio


class JacobianIsLimited(Port):
    """The Jacobian is clamped to at most 10.

    A sample close to the receiver, as in a corner, has a larger one.
    """

    def _ratio(
        self, x_from: Array, x_to: Array, position: Array, normal: Array
    ) -> Array:
        J = super()._ratio(x_from, x_to, position, normal)
        return np.minimum(J, np.float32(10))


class WeightAgainstTheFirstAlone(Port):
    """The new candidate is kept where u w_before < w, not u (w_before + w) < w.

    Every merge of two with weight: the second is kept too often.
    """

    def _keeps(self, before: Array, w: Array, u: Array) -> Array:
        return (u * before < w) & (w > 0)


class DarkTargetsAreNothing(Port):
    """Closing gives W = 0 where the target is below 0.001, not only where it is 0.

    Dim light, as far from a lamp or in a scene of other units, is lost.
    """

    def _closed(self, w: Array, p_hat: Array, Z: Array) -> Array:
        W = super()._closed(w, p_hat, Z)
        return np.where(p_hat < np.float32(1e-3), np.float32(0), W)


class DegreesTakenForRadians(Port):
    """The cosine of the largest angle is taken of degrees as if they were radians.

    Every frame: other pairs of points are similar, or none or all.
    """

    def _least_cosine(self, max_angle: float) -> np.float32:
        return np.float32(np.cos(max_angle))


# ---------------------------------------------------------------- passes of a frame


class SmallDensitiesAreRaised(Port):
    """The source density of a new sample is raised to at least 0.05.

    Directions near the horizon, drawn by cosine, have a smaller one: they come too
    dark.
    """

    def _new_weight(self, p_hat: Array, pdf: Array) -> Array:
        raised = np.where(pdf > 0, np.maximum(pdf, np.float32(0.05)), pdf)
        return super()._new_weight(p_hat, raised)


class CapOneFrameLate(Port):
    """The temporal cap limits the past's M, so that M comes out as cap + 1.

    Every pixel whose past has reached the cap.
    """

    def _temporal_cap(self, past_M: Array, cap: float) -> Array:
        return np.minimum(past_M, np.float32(cap)) + 1


class DividedByTheCappedM(Port):
    """The temporal W is divided by M after the cap, not before it.

    Every pixel whose past has reached the cap becomes brighter by 1/cap in each frame.
    """

    def _temporal_divisor(self, M: Array, cap: float) -> Array:
        return np.minimum(M, np.float32(cap))


class ClosedByTheOutgoingTarget(Port):
    """The temporal W is divided by the target of Equation 10, whatever the setting.

    Every frame with target scattered: sum and divisor are of two targets.
    """

    def _p_hat_closing(self, receiver: Buffers, kept: Buffers, target: str) -> Array:
        return self._p_hat(receiver, kept, "outgoing")


class PastSeenFromThePast(Port):
    """Whether x sees the past's sample is read of x_past's column of visibility.

    A door that closes: x_past saw the sample, and x does not.
    """

    def _sees_past(self, visible: Array) -> Array:
        return bit(visible[:, 1], 1)


class DomainWithTheNormalOfNow(Port):
    """The domain of x_past is judged with the normal at x, not with that at x_past.

    Objects that turn, and curved surfaces: a sample is above one horizon alone.
    """

    def _earlier(self, b: Buffers) -> Buffers:
        return super()._earlier(b) | {"visible_normal": b["visible_normal"]}


class HiddenPastDoesNotCount(Port):
    """Where x does not see the past's sample, its M is not counted.

    Whoever drops the past where it is hidden keeps it only where it is bright: pixels
    behind an edge that moves.
    """

    def _moved_confidence(self, past_M: Array, visible: Array) -> Array:
        return np.where(self._sees_past(visible), past_M, np.float32(0)) + 1


class MovedIsAlwaysDividedByM(Port):
    """The setting mis is not looked at in pass moved: always 1/M.

    Every frame with mis 1/Z in which x_past cannot make the kept sample: too dark.
    """

    def moved(self, **b: Array) -> Buffers:  # noqa: D102
        return super().moved(**b | {"mis": "1/M"})


class OffsetsAreCutOff(Port):
    """Offsets of neighbours are cut off towards 0, not rounded to the nearest.

    Every frame: neighbours stand too close by half a pixel, the pixel itself too often.
    """

    def _whole(self, offset: Array) -> Array:
        return np.trunc(offset).astype(np.int64)


class NeighboursAroundTheEdge(Port):
    """Only the row number is held against the image, not x: lines run into the next.

    Pixels at the left and right edge get neighbours from the other side of the image.
    """

    def _in_image(self, x: Array, y: Array, width: int, height: int) -> Array:
        row = y * width + x
        return (row >= 0) & (row < width * height)


class RadiusFallsBelowItsLeast(Port):
    """The radius is halved without looking at min_radius.

    Pixels at corners of the scene, where many neighbours are refused, find none.
    """

    def _smaller(self, r: Array, min_radius: np.float32) -> Array:
        return r / 2


class MissingNeighbourIsTheLastRow(Port):
    """Neighbour −1 is not left out: it reads the last row of the buffers.

    Every pixel at an edge: the last pixel's reservoir is reused, and its M counts.
    """

    def _rows_there(self, neighbor: Array) -> tuple[Array, Array]:
        return np.full(neighbor.shape, True), neighbor


class NeighbourSeenByTheBitBefore(Port):
    """Whether the pixel sees neighbour k's sample is read from bit k, not 1 + k.

    Every frame with occluders: one neighbour's shadow is another's.
    """

    def _sees_neighbor(self, visible: Array, k: int) -> Array:
        return bit(visible[:, 0], k)


class BitsInTheOrderOfTheStream(Port):
    """For Z the bits are read in the stream's order: past 0, own 1, neighbour k 2 + k.

    Every frame with mis 1/Z and occluders: it is asked who sees another sample.
    """

    def _place(self, source: int) -> int:
        return 1 + source

    def _place_of_past(self, K: int) -> int:
        return 0


class NormalOfTheOwnSample(Port):
    """A neighbour's Jacobian is taken with the normal of the pixel's own sample point.

    Every frame in which samples of one pixel and the next lie on different walls.
    """

    def _normal_for_ratio(self, sample: Buffers, own: Buffers) -> Array:
        return own["normal"]


class OwnAndFirstNeighbourShareANumber(Port):
    """The pixel's own reservoir is decided with neighbour 0's random number.

    Two decisions of a stream depend on each other: neighbour 0 gets too much or little.
    """

    def _u_of_own(self, b: Buffers) -> Array:
        return b["u_neighbors"][:, 0] if b["u_neighbors"].shape[1] else b["u_own"]


class SpatialIgnoresItsCap(Port):
    """The setting cap is not looked at in pass spatial: M goes out as the sum.

    Every long run: M grows in each frame without end, and light that changes stays.
    """

    def _spatial_cap(self, M: Array, cap: float) -> Array:
        return M


class ShadedBelowTheHorizon(Port):
    """The colour takes the absolute cosine, so that light below the horizon counts.

    Samples whose point lies behind the pixel's surface leak through it.
    """

    def _shading_cosine(self, receiver: Buffers, sample: Buffers) -> Array:
        x, s = receiver["visible_position"], sample["position"]
        _, omega = length_and_direction(x, s)
        cos = np.abs(dot(receiver["visible_normal"], omega))
        return np.where(dot(sample["normal"], omega) < 0, cos, np.float32(0))


# -------------------------------------------------------------------------- images


class AngleOfViewIsVertical(Port):
    """The angle of view is taken as that from top to bottom, not from left to right.

    Every image that is not square.
    """

    def _half_width(self, c: dict[str, float]) -> np.float32:
        return super()._half_width(c) * np.float32(c["width"] / c["height"])


class NormalIsNotTurned(Port):
    """The normal of a triangle that is seen from behind is not turned to the viewer.

    Every mesh whose corners are not ordered alike, and walls that are seen from both
    sides.
    """

    def _turned(self, normal: Array, d: Array) -> Array:
        return normal


class NearestPixelCorner(Port):
    """The row of the last frame is that of x and y rounded, not rounded down.

    Every frame: the past is the neighbour's in three of four pixels.
    """

    def _row_at(self, x: Array, y: Array, width: int, height: int) -> Array:
        last_x, last_y = np.float32(width - 1), np.float32(height - 1)
        return np.minimum(np.rint(y), last_y) * width + np.minimum(np.rint(x), last_x)


class ReprojectionIgnoresDepth(Port):
    """The setting max_depth is not looked at in pass reproject: any depth is similar.

    What comes into view behind an edge of the same normal takes over its past.
    """

    def reproject(self, **b: Array) -> Buffers:  # noqa: D102
        return super().reproject(**b | {"max_depth": np.inf})


class NullsAreEmptied(Port):
    """Nulls are treated as other samples: without a point to meet they are emptied.

    Every scene with a window: nulls no longer count, and the rest becomes brighter.
    """

    def _stays(self, same: Array, met: Array, null: Array) -> Array:
        return met & same


class MeanOverDarkPixelsToo(Port):
    """The mean of a tile is taken over all its pixels, not over those with light.

    Tiles that are dark but for a few pixels lose these.
    """

    def _counted(self, light: Array) -> Array:
        return np.full(light.shape, True)


class ParityOfTheRowNumber(Port):
    """Pixels take turns by the parity of the row number + frame, not of x + y + frame.

    Every image of even width: stripes in place of a checkerboard.
    """

    def _even(self, pixel: Array, x: Array, y: Array, frame: int) -> Array:
        return (pixel + frame) % 2 == 0


class TilesThatAreWholeAlone(Port):
    """Tiles in a row are ⌊width / 64⌋: the one that is cut off is not counted.

    Images of 1000 pixels or so: tiles of one row share the number of others.
    """

    def _tiles_across(self, width: int) -> int:
        return width // 64


class EveryTileHasWeightOne(Port):
    """Tiles that go on have weight 1, not 1 / probability.

    Every frame with a probability below 1: later bounces are too dark.
    """

    def roulette(self, **b: Array) -> Buffers:  # noqa: D102
        return {"weight": np.minimum(super().roulette(**b)["weight"], np.float32(1))}


class FoldUsesWhatItHasChanged(Port):
    """The fold writes u first and takes the new u for v.

    Every normal that points away from +z.
    """

    def _fold(self, u: Array, v: Array) -> tuple[Array, Array]:
        folded_u, _ = super()._fold(u, v)
        _, folded_v = super()._fold(folded_u, v)
        return folded_u, folded_v


class BrightRadianceIsInfinite(Port):
    """Radiance above 65504 is packed as infinity.

    Samples on a lamp or the sun's reflection, in a scene with physical units.
    """

    def _half(self, radiance: Array) -> Array:
        with np.errstate(over="ignore"):
            return radiance.astype("<f2")


class DimHalvesAreNothing(Port):
    """Subnormal halves are read as 0.

    Radiance below 2⁻¹⁴, as in a dark room, is lost.
    """

    def _read_halves(self, codes: Array) -> Array:
        subnormal = codes & np.uint32(0x7C00) == 0
        return np.where(subnormal, np.float32(0), super()._read_halves(codes))


MISTAKES = tuple(Port.__subclasses__())
"""All of them, in the order of the page."""

# ------------------------------------------------------------------------- verdicts


def truth(mistake: type[Port]) -> str:
    """What is wrong, in a sentence."""
    return (mistake.__doc__ or "").partition("\n")[0]


def verdict_on(backend: type[Port]) -> Verdict:
    """What the ladder says, without whole runs."""
    return judge(backend(), budget=600, statistics=False)


def said(verdict: Verdict) -> list[str]:
    """Of each pass that is not the contract's: what explains it, in words."""
    lines = []
    for one in verdict.diagnoses:
        kind = "other, without a bias" if one in verdict.departures else "wrong"
        lines.append(f"{one.pass_name}, {kind}: {one.text}")
    return lines


def killed(verdict: Verdict) -> bool:
    """Whether a backend is said to be wrong, for a bias or without one."""
    return verdict.status == "FAIL" or bool(verdict.departures)


def main(names: list[str]) -> None:
    """Print a table of mistakes and verdicts."""
    asked = [m for m in MISTAKES if m.__name__ in names or not names]
    found = []
    for number, mistake in enumerate(asked, 1):
        start = time.monotonic()
        found.append(verdict_on(mistake))
        seconds = time.monotonic() - start
        status = found[-1].status if killed(found[-1]) else "not killed"
        print(f"{number:2} {mistake.__name__}  {status}  {seconds:.1f} s")
        print(f"   truth: {truth(mistake)}")
        for line in said(found[-1]):
            print(f"   says:  {line}", flush=True)
    failed = sum(verdict.status == "FAIL" for verdict in found)
    told = sum(killed(verdict) for verdict in found) - failed
    print(f"of {len(found)}: {failed} FAIL, {told} told as other without a bias")


if __name__ == "__main__":
    main(sys.argv[1:])
