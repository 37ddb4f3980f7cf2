"""Known mistakes with what the sum of weights is divided by."""

from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.diagnosis.hypothesis import REUSE, SHIFTED, mistake
from restir_gi.reference.oracle.replay.bounded import Bounded
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.points import ReceiverPoint, SamplePoint
from restir_gi.reference.oracle.replay.verbs import inner, where_positive

W_RIGHT = "W = Σ w / (p̂(y) Z)"
Z_RIGHT = "Z = Σ M over those that could have made the kept sample"


def _undivided(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    return w / p_hat


def _without_p_hat(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    return w / Z


def _divided_twice(w: Bounded, p_hat: Bounded, Z: Bounded) -> Bounded:
    return w / p_hat / Z / Z


def _any_light(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    return luminance(y.radiance)


def _either_side(kind: Value, x: ReceiverPoint, y: SamplePoint) -> Bounded:
    above = inner(x.normal, y.position - x.position)
    return where_positive(above, luminance(y.radiance))


WEIGHTS = (
    mistake(
        "one-over-m",
        "1/M where 1/Z is asked for",
        "W = Σ w / (p̂ Σ M)",
        Z_RIGHT,
        SHIFTED,
        "the paper's biased form",
        "Capsaicin",
        normalization="1/M",
    ),
    mistake(
        "one-over-z-where-m",
        "1/Z where 1/M is asked for: right in mean",
        Z_RIGHT,
        "Z = Σ M",
        SHIFTED,
        departure="mis",
        normalization="1/Z",
    ),
    mistake(
        "not-normalized",
        "the sum of weights is not divided by the confidences",
        "W = Σ w / p̂",
        W_RIGHT,
        ("finalize", *REUSE),
        finalized=_undivided,
    ),
    mistake(
        "not-divided-by-target",
        "W is not divided by the target",
        "W = Σ w / Z",
        W_RIGHT,
        ("finalize", "initial", *REUSE),
        finalized=_without_p_hat,
    ),
    mistake(
        "weight-cut-at-10",
        "W is cut at 10",
        "W = min(W, 10)",
        W_RIGHT,
        ("finalize", "initial", *REUSE),
        "kajiya",
        "ReSTIR_PT",
        W_most=10.0,
    ),
    mistake(
        "weight-cut-at-4",
        "W is cut at 4",
        "W = min(W, 4)",
        W_RIGHT,
        ("finalize", "initial", *REUSE),
        "forge3d #177",
        W_most=4.0,
    ),
    mistake(
        "divided-by-the-donors-target",
        "W is divided by the target at the point that made the sample",
        "W = Σ w / (p̂_source(y) Z)",
        W_RIGHT,
        SHIFTED,
        "HIPRT 2861d1c5",
        divides_by_source_target=True,
    ),
    mistake(
        "canonical-missing-in-z",
        "the pixel's own reservoir is not counted in Z",
        "Z = Σ M of the others",
        Z_RIGHT,
        SHIFTED,
        canonical_in_z=False,
    ),
    mistake(
        "visibility-missing-in-z",
        "Z counts neighbours that do not see the kept sample, as where it asks what the"
        " receiver sees, which is all that it keeps",
        "domain: above the horizon and lit",
        "domain: above the horizon, lit, and visible from the neighbour",
        SHIFTED,
        "the paper's Algorithm 4 with Equation 10",
        visibility_in_z=False,
    ),
    mistake(
        "visibility-missing-in-weight",
        "samples that the receiver does not see keep their weight; right if your"
        " shading tests visibility, and no hidden sample is kept",
        "w = p̂ W M J",
        "w = 0 where the receiver does not see the sample",
        SHIFTED,
        "RTXDI",
        declared="visibility",
        visibility_in_weight=False,
    ),
    mistake(
        "normalized-twice",
        "the sum of weights is divided by the confidences twice",
        "W = Σ w / (p̂ Z²)",
        W_RIGHT,
        ("finalize", *REUSE),
        "ReSTIR_GI by shallairo",
        finalized=_divided_twice,
    ),
    mistake(
        "last-confidence-in-z",
        "Z adds M of the last neighbour, whose domain ever is asked",
        "Z = Σ M_last over those that hold the sample",
        Z_RIGHT,
        REUSE,
        "the paper's Algorithm 4",
        counted_as="last",
    ),
    mistake(
        "one-each-in-z",
        "Z counts reservoirs, not their samples",
        "Z = number of those that hold the sample",
        Z_RIGHT,
        REUSE,
        counted_as="one",
    ),
    mistake(
        "one-each-unless-empty-in-z",
        "Z counts reservoirs that are not empty, not their samples",
        "Z = number of those with M > 0 that hold the sample",
        Z_RIGHT,
        REUSE,
        counted_as="full",
    ),
    mistake(
        "merged-confidence-in-z",
        "the pixel's own reservoir is counted in Z with M after the merge",
        "Z = Σ M + M of the neighbours that hold the sample",
        Z_RIGHT,
        REUSE,
        counted_as="merged",
    ),
    mistake(
        "first-not-counted",
        "1/M leaves out the first reservoir of the stream, which is merged",
        "Z = Σ M over all but the first, for 1/M",
        "Z = Σ M over all, for 1/M",
        REUSE,
        "blade 5fe3230",
        counted_as="rest",
    ),
    mistake(
        "maker-missing-in-z",
        "Z does not count who made the sample",
        "Z = Σ M over the others that hold the sample",
        Z_RIGHT,
        SHIFTED,
        maker_in_z=False,
    ),
    mistake(
        "receivers-target-in-z",
        "the domain test is that of the receiver in place of the source",
        "domain: p̂_receiver(y) > 0",
        "domain: p̂_source(y) > 0",
        SHIFTED,
        "OloEngine #1183",
        receivers_domain=True,
    ),
    mistake(
        "canonical-not-merged",
        "the pixel's own reservoir takes no part",
        "the stream is past and neighbours",
        "the stream is past, own and neighbours",
        SHIFTED,
        "the paper's Algorithm 4 leaves it open",
        canonical_merged=False,
    ),
    mistake(
        "reused-as-it-stands",
        "what was seen from another point is reused as if it had been seen from here",
        "w = p̂ W M, Z = Σ M",
        "w = p̂ W M J, Z = Σ M over those that hold the sample",
        ("moved",),
        "the paper's Algorithm 3",
        as_stored=True,
    ),
    mistake(
        "horizon-missing-in-z",
        "Z asks whether there is light, and not on which side of whom",
        "domain: L_o > 0 and visible",
        "domain: above the source's horizon, lit, and visible",
        SHIFTED,
        "the paper's Algorithm 4 with Equation 10",
        domain_target=_any_light,
    ),
    mistake(
        "side-missing-in-z",
        "Z does not ask on which side the sample shines",
        "domain: above the source's horizon and visible",
        "domain: above the source's horizon, lit, and visible",
        SHIFTED,
        domain_target=_either_side,
    ),
)
