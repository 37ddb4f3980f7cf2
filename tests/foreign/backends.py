"""Backends in the manner of renderers that others wrote, right and wrong.

Each is a few words about a renderer: what it does, the passes in which it differs, and
what the enumeration of `truth` has to find.  Names of real renderers stand where the
manner is theirs; nothing of their code is here.
"""

from dataclasses import dataclass
from typing import Literal

from tests.foreign import mistakes as wrong
from tests.foreign.kernels import plain_unit
from tests.foreign.renderer import ForeignRenderer
from tests.foreign.service import SERVICE
from tests.foreign.storage import MIXING, ROUNDING
from tests.foreign.truth import biases, worst
from tests.foreign.world import MIXED, RECEIVER, SEES

REUSE = ("temporal", "moved", "spatial")
SHIFTED = ("moved", "spatial")
KERNELS = ("target", "jacobian", "merge", "finalize", "similar")
ALL = (*KERNELS, "initial", *REUSE, "shade")

Kind = Literal["right", "wrong", "extremes", "declared"]


@dataclass(frozen=True)
class Foreign:
    """A backend whose truth is known.

    Attributes
    ----------
    name : str
    renderer : object; all passes, whether it differs in them or not
    passes : tuple of str; those that it has as a backend
    kind : str
        'right'; 'wrong'; 'extremes': right in the working range alone; 'declared':
        right only under a choice that the contract does not have.
    nulls : tuple of str; kinds of nulls with which it is right
    rounding : float; relative error of W in its storage
    mixed : bool; nothing is said of light of one channel
    elsewhere : str; where a mistake is that the small world cannot show
    made_by : str; the pass whose reservoirs are reused, in the small world
    """

    name: str
    renderer: object
    passes: tuple[str, ...] = REUSE
    kind: Kind = "right"
    nulls: tuple[str, ...] = ("ordinary", "degenerate")
    rounding: float = 0.0
    mixed: bool = False
    elsewhere: str = ""
    made_by: str = "temporal"

    @property
    def backend(self):
        """The passes that it has, and no other."""
        return Only(self.renderer, self.passes)

    def bias(self, nulls="ordinary"):
        """Name and value of the largest bias in the small world, or None."""
        renderer, passes = self.renderer, self.passes
        if passes == KERNELS:
            renderer, passes = wrong.Assembled(renderer), REUSE
        # What a renderer hides when it shades may be anything.
        lit = SEES[RECEIVER] if self.kind == "declared" else None
        lit = MIXED if self.mixed else lit
        if self.made_by == "initial":
            passes = ("initial", *SHIFTED)
        found = biases(renderer, passes, nulls, lit=lit, made_by=self.made_by)
        return worst(found) if found else None


class Only:
    """Some passes of a renderer."""

    precision = "float32"

    def __init__(self, renderer, passes):
        vars(self).update({name: getattr(renderer, name) for name in passes})


def _right(name, *passes, nulls=("ordinary", "degenerate"), **options):
    storage = options.get("storage")
    about = {"rounding": ROUNDING.get(storage, 0.0), "mixed": storage in MIXING}
    renderer = ForeignRenderer(**options)
    return Foreign(name, renderer, passes or REUSE, nulls=nulls, **about)


TARGETS = ("target", "initial", *REUSE)

RTXDI = {"order": "own first", "cap": "past", "null_weight": True, "bytes": True}
BEVY = {"order": "own first, neighbors reversed", "cap": "arrival", "mis": "chained"}
WEBGPU = {"order": "past last", "mis": "share", "limit": 10.0, "luminance": "largest"}

THRIFTY = {"order": "reversed", "draws": "reservoir", "target": "root", "bytes": True}
HOBBY = {"order": "past last", "u": "1 - u", "luminance": "largest", "mis": "defensive"}

SEVERAL = (
    _right("a renderer like RTXDI", "initial", *REUSE, **RTXDI, storage="32 bytes"),
    _right("a renderer like RTXDI, in its bytes", *REUSE, **RTXDI, storage="RTXDI"),
    _right("a renderer like Bevy", *TARGETS, **BEVY, target="outgoing"),
    _right("a renderer like a WebGPU one", *TARGETS, **WEBGPU),
    _right("a thrifty renderer", *TARGETS, **THRIFTY, storage="half W"),
    _right("a renderer of a first try", *TARGETS, **HOBBY, cap="arrival"),
)
"""Right ones that depart in several choices at once."""

RIGHT = (
    *SEVERAL,
    _right("the contract as it stands", *ALL),
    _right("own first", order="own first"),
    _right("cap on arrival", cap="arrival"),
    _right(
        "own first, cap on arrival: RTXDI temporal",
        "temporal",
        "moved",
        order="own first",
        cap="past",
    ),
    _right(
        "own first, cap on arrival, neighbors reversed",
        order="own first, neighbors reversed",
        cap="arrival",
    ),
    _right("reversed, numbers of reservoirs", order="reversed", draws="reservoir"),
    _right("Equation 10 whatever is asked", *TARGETS, target="outgoing"),
    _right("largest channel", *TARGETS, luminance="largest"),
    _right("Rec. 601", *TARGETS, luminance="601"),
    _right("mean of channels", *TARGETS, luminance="mean"),
    _right("target without albedo", *TARGETS, target="no albedo"),
    _right("root of the target", *TARGETS, target="root"),
    _right("floor under the target where it is positive", *TARGETS, floor=0.01),
    _right("chained merges, balance of two: Bevy", **BEVY),
    _right("balance over all: RTXDI ray traced", "moved", "spatial", mis="balance"),
    _right("balance over all, weights first", mis="balance first"),
    _right("balance of densities without J", "moved", "spatial", mis="uneven"),
    _right("pairwise", mis="pairwise"),
    _right("defensive pairwise", mis="defensive"),
    _right("canonical share c / k", mis="share"),
    _right("J refused both ways, 1/Z asks too", "moved", "spatial", limit=10.0),
    _right(
        "J refused both ways, balance asks too",
        "moved",
        "spatial",
        limit=3.0,
        mis="balance",
    ),
    _right("u as 1 - u", u="1 - u"),
    _right("at most, where there is a weight", "merge", *REUSE, accept="<="),
    _right(
        "no test of the back, J is 0",
        "target",
        "jacobian",
        "initial",
        *REUSE,
        "shade",
        back_test=False,
    ),
    _right("W = 1 / pdf of nulls", "initial", null_weight=True),
    _right("M in a byte", bytes=True),
    _right("capped twice", cap="both"),
    _right("never capped", cap="never"),
    _right("32 bytes between passes", storage="32 bytes"),
    _right("RTXDI's 32 bytes between passes", storage="RTXDI"),
    _right("radiance in float16 between passes", storage="half radiance"),
    _right("W in float16 between passes", storage="half W"),
    _right("normals in four bytes between passes", storage="octahedral"),
    Foreign("spatial without history", wrong.HistoryIgnored(), ("spatial",)),
    Foreign("only kernels", ForeignRenderer(), KERNELS),
    Foreign("a service that outlives the call", SERVICE, ("temporal", "spatial")),
)

EXTREMES = (
    Foreign(
        "geometry tested before counting",
        wrong.DegenerateRejected(order="own first"),
        ("initial", *REUSE),
        "extremes",
        nulls=("ordinary",),
        elsewhere="nulls that stand nowhere",
    ),
    Foreign(
        "normalize() first",
        ForeignRenderer(normalize=plain_unit),
        ("target", "initial", *REUSE, "shade"),
        "extremes",
        elsewhere="points closer than 1e-19 m, or farther than 1e19 m",
    ),
    Foreign(
        "W overflows to infinity",
        wrong.Overflowing(),
        ("finalize",),
        "extremes",
        elsewhere="W beyond the largest number",
    ),
)

DECLARED = (
    Foreign(
        "visibility in shading alone, 1/Z asks the sources'",
        wrong.VisibleInShadingAlone(),
        ("moved", "spatial"),
        "declared",
    ),
)


def _wrong(mistake, *passes, on="", elsewhere="", made_by="temporal", **options):
    words = mistake.__doc__.splitlines()[0].rstrip(".")
    name = f"{on}: {words}" if on else words
    kept = passes or REUSE
    about = {"elsewhere": elsewhere, "made_by": made_by}
    about["mixed"] = options.get("storage") in MIXING
    return Foreign(name, mistake(**options), kept, "wrong", **about)


WRONG = (
    _wrong(wrong.RefusedOneWay, *SHIFTED),
    _wrong(wrong.RefusedThenClamped, *SHIFTED),
    _wrong(wrong.ClampedJacobian, "jacobian", *SHIFTED),
    _wrong(wrong.InvertedJacobian, "jacobian", *SHIFTED),
    _wrong(wrong.DividedByJacobian, *SHIFTED),
    _wrong(wrong.RefusedNotCounted, *SHIFTED, limit=10.0),
    _wrong(wrong.HiddenNotCounted, *SHIFTED),
    _wrong(wrong.NullsNotCounted, "initial", "temporal", "moved"),
    _wrong(wrong.UnlitWeight, "initial", made_by="initial"),
    _wrong(wrong.OneOverM, *SHIFTED),
    _wrong(wrong.BlindDomain, *SHIFTED),
    _wrong(wrong.BlindDomain, *SHIFTED, on="balance", mis="balance"),
    _wrong(wrong.HalfJacobians, *SHIFTED, mis="balance"),
    _wrong(wrong.BackUntested, *SHIFTED, back_test=False),
    _wrong(wrong.PairwiseWithoutM, *SHIFTED, mis="pairwise"),
    _wrong(wrong.PairwiseWithoutOwn, *SHIFTED, mis="pairwise"),
    _wrong(wrong.CanonicalMissing),
    _wrong(wrong.ChainedByTheirTarget, *SHIFTED, **BEVY),
    _wrong(wrong.ChainedFromANeighbor, "spatial", mis="chained", order="reversed"),
    _wrong(wrong.WeightClamped),
    _wrong(wrong.CappedBeforeWeight),
    _wrong(wrong.CappedInDivisorAlone),
    _wrong(wrong.PastAsItStands, "moved"),
    _wrong(wrong.OneNumber, "spatial"),
    _wrong(wrong.SquaredNumber),
    _wrong(wrong.OldSum),
    _wrong(wrong.DarkPureColors, *TARGETS),
    _wrong(wrong.FloorEverywhere, *TARGETS),
    _wrong(wrong.ClosedByAnotherTarget),
    _wrong(wrong.CountedDouble, "spatial"),
    _wrong(wrong.HistoryCounted, "spatial"),
    _wrong(wrong.NeverVisible, *SHIFTED),
    _wrong(wrong.ValidatedAtRandom, "validation", elsewhere="pass validation"),
    _wrong(wrong.NakedAtMost, "merge", *REUSE, elsewhere="u = 0, once in 2^24"),
    Foreign("only kernels: J upside down", wrong.InvertedJacobian(), KERNELS, "wrong"),
    # A right departure, and a mistake on top of it.
    _wrong(wrong.NullsNotCounted, "initial", *REUSE[:2], on="RTXDI", **RTXDI),
    _wrong(wrong.CappedInDivisorAlone, on="own first", order="own first"),
    _wrong(wrong.BlindDomain, *SHIFTED, on="RTXDI", **RTXDI),
    _wrong(wrong.RefusedThenClamped, *SHIFTED, on="RTXDI", **RTXDI, storage="32 bytes"),
    _wrong(wrong.OldSum, on="1 - u", u="1 - u"),
    _wrong(wrong.InvertedJacobian, *SHIFTED, on="reversed", order="reversed"),
    _wrong(wrong.WeightClamped, on="never capped", cap="never"),
    _wrong(wrong.OneOverM, *SHIFTED, on="Rec. 601", luminance="601"),
    _wrong(wrong.CanonicalMissing, on="Equation 10", target="outgoing"),
    _wrong(wrong.HiddenNotCounted, *SHIFTED, on="WebGPU", **WEBGPU),
    _wrong(wrong.CountedDouble, "spatial", on="half W", storage="half W"),
    _wrong(wrong.OneOverM, *SHIFTED, on="RTXDI's bytes", storage="RTXDI"),
    _wrong(wrong.OneNumber, "spatial", on="pairwise", mis="pairwise"),
    _wrong(wrong.DividedByJacobian, *SHIFTED, on="defensive", mis="defensive"),
    _wrong(wrong.ClampedJacobian, "jacobian", *SHIFTED, on="limit", limit=10.0),
    _wrong(wrong.HistoryCounted, "spatial", on="cap twice", cap="both"),
)

FOREIGN = (*RIGHT, *EXTREMES, *DECLARED, *WRONG)
