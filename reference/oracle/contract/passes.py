"""Passes of the contract: the algorithms of the paper, on whole frames."""

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
    Setting,
    bits,
    index,
    real,
)
from restir_gi.reference.oracle.contract.groups import (
    RECEIVER,
    RESERVOIR,
    SAMPLE,
    prefixed,
)
from restir_gi.reference.oracle.contract.kernels import TARGET

CAP = Setting("cap", "number, at least 1", "limit of M, when the reservoir is closed")
MIS = Setting("mis", "1/M | 1/Z", "what the sum of weights is divided by")


def _stream(count: int | str) -> tuple[Field, ...]:
    """Terms of a stream of reservoirs."""
    return (
        real("term_w", "weight of each in the stream, in its order", count),
        real("term_p_hat", "target of the kept sample, by which W is divided"),
        real("term_Z", "divisor Z"),
    )


INITIAL = Pass(
    name="initial",
    summary="Algorithm 2: a new sample becomes a reservoir",
    formula="w = p̂ / pdf, W = w / p̂, M = 1 for nulls too; W = 0 where w is",
    inputs=(*RECEIVER, *SAMPLE, real("pdf", "source density of the sample, 1/sr")),
    outputs=(
        real("p_hat", "target of the sample"),
        real("W", "contribution weight, sr"),
        real("M", "confidence"),
    ),
    settings=(TARGET,),
    source="[Ouyang21, Alg. 2]",
)

TEMPORAL = Pass(
    name="temporal",
    summary="Algorithm 3: the new sample meets the pixel's past; nothing moves",
    formula=(
        "the past with w₀ = p̂(y₀) W₀ M₀, then the new sample with w₁ = p̂(y₁) / pdf;\n"
        "the new one is kept where u (w₀ + w₁) < w₁, and where w₀ = 0 < w₁;\n"
        "W = (w₀ + w₁) / (p̂(y) (M₀ + 1)), M = min(M₀ + 1, cap)"
    ),
    inputs=(
        *RECEIVER,
        *prefixed("past", RESERVOIR),
        *prefixed("new", SAMPLE),
        real("new_pdf", "source density of the new sample, 1/sr"),
        real("u", "number in [0, 1)"),
    ),
    outputs=RESERVOIR,
    settings=(TARGET, CAP),
    source="[Ouyang21, Alg. 3], with w rebuilt after the cap",
    terms=_stream(2),
)

MOVED = Pass(
    name="moved",
    summary="Algorithm 3 where the past was seen from another point",
    formula=(
        "the past with w₀ = p̂(y₀) W₀ M₀ J(x_past → x), 0 where x does not see y₀;\n"
        "then the new sample with w₁ = p̂(y₁) / pdf; it is kept where u (w₀ + w₁) < w₁,"
        " and where w₀ = 0 < w₁;\n"
        "1/M: Z = M₀ + 1;  1/Z: Z = M₀ + 1 where the kept sample is in the domain of"
        " x_past, else 1;\n"
        "y is in the domain of x_past where p̂(y) > 0 there, with its normal and albedo,"
        " and x_past sees y;\n"
        "W = (w₀ + w₁) / (p̂(y) Z), M = min(M₀ + 1, cap), whatever x sees"
    ),
    inputs=(
        *RECEIVER,
        *prefixed("past", RECEIVER),
        *prefixed("past", RESERVOIR),
        *prefixed("new", SAMPLE),
        real("new_pdf", "source density of the new sample, 1/sr"),
        bits(
            "visible",
            "who sees which sample: column 0 is x, 1 is x_past; bit 0 the new sample,"
            " bit 1 the past's; bit 0 of column 0 is not looked at",
            2,
        ),
        real("u", "number in [0, 1)"),
    ),
    outputs=RESERVOIR,
    settings=(TARGET, CAP, MIS),
    source="[Ouyang21, Alg. 3 and Eq. 11]",
    terms=_stream(2),
)

NEIGHBORS = Pass(
    name="neighbors",
    summary="Neighbours whose samples a pixel reuses",
    formula=(
        "N = width · height; r = max(radius · width, min_radius);\n"
        "for each k: offset = r √u₀ (cos 2πu₁, sin 2πu₁), each component rounded to the"
        " nearest whole, ties to even;\n"
        "usable where the pixel lies in the image and is similar; else the neighbour is"
        " −1 and r = max(r / 2, min_radius); the pixel itself is −1, and usable"
    ),
    inputs=(
        RECEIVER[1],
        real("depth", "view depth, m; 0 where nothing is seen"),
        real("u", "two numbers in [0, 1) for each neighbour", "K", 2),
    ),
    outputs=(index("neighbors", "row of the neighbour, or −1", "K"),),
    settings=(
        Setting("width", "pixels", "of the image; row = y · width + x"),
        Setting("radius", "number", "share of the width"),
        Setting("min_radius", "pixels", "least radius"),
        Setting("max_angle", "degrees", "between the normals"),
        Setting("max_depth", "number", "relative difference of the depths"),
    ),
    source="[Ouyang21, section 5]",
)

SPATIAL = Pass(
    name="spatial",
    summary="Algorithm 4: pixels resample what their neighbours keep",
    formula=(
        "in this order: the pixel's spatial past, its own reservoir, neighbour 0 … K−1,"
        " with w = p̂(y) W M J; J = 1 for the first two;\n"
        "w = 0 where the receiver does not see a neighbour's sample, whose M counts "
        "all the same; neighbour −1 has w = 0 and M = 0;\n"
        "a candidate is kept where u (w_before + w) < w, and where w_before = 0 < w;\n"
        "1/M: Z = Σ M;  1/Z: Z = Σ M over those that hold the kept sample; a neighbour "
        "does where p̂(y) > 0 at its visible point, with its normal and albedo, and it "
        "sees the sample; past and own always do;\n"
        "W = Σ w / (p̂(y) Z), and then M = min(Σ M, cap)"
    ),
    inputs=(
        *RECEIVER,
        *RESERVOIR,
        *prefixed("past", RESERVOIR),
        index("neighbors", "row of each neighbour, or −1", "K"),
        bits(
            "visible",
            "who sees which sample: column 0 is the pixel, 1 + k neighbour k; bit 0 is"
            " the pixel's own sample, 1 + k neighbour k's, 1 + K the past's; K is 30 at"
            " most, and of column 0 the bits 0 and 1 + K are not looked at",
            "K+1",
        ),
        real("u_own", "number in [0, 1) that decides on the pixel's own reservoir"),
        real("u_neighbors", "that decide on the neighbours", "K"),
    ),
    outputs=RESERVOIR,
    settings=(TARGET, CAP, MIS),
    source="[Ouyang21, Alg. 4], where the weight is multiplied by the Jacobian",
    terms=_stream("K+2"),
)

SHADE = Pass(
    name="shade",
    summary="The estimate of the pixel's indirect light",
    formula="color = albedo / π · cos θ · L_o · W, 0 where the sample is below the "
    "horizon or shows its back",
    inputs=(*RECEIVER, *SAMPLE, RESERVOIR[3]),
    outputs=(real("color", "indirect radiance towards the camera, W/(m² sr)", 3),),
    source="[Ouyang21, Eq. 8]",
    terms=(real("term_f", "integrand f = albedo / π · cos θ · L_o", 3),),
)

FRAME_PASSES = (INITIAL, TEMPORAL, MOVED, NEIGHBORS, SPATIAL, SHADE)
