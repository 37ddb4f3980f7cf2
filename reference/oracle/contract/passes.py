"""Passes of the contract: the algorithms of the paper, on whole frames."""

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
    Setting,
    bits,
    given_with,
    index,
    real,
)
from restir_gi.reference.oracle.contract.groups import (
    RECEIVER,
    RESERVOIR,
    SAMPLE,
    prefixed,
)
from restir_gi.reference.oracle.contract.kernels import SCATTERS
from restir_gi.reference.oracle.contract.surfaces import MATERIAL, SURFACE
from restir_gi.reference.oracle.contract.targets import (
    CLAUSE,
    SEEN_ALIKE,
    TARGET_OR_DATA,
    given_targets,
)
from restir_gi.reference.oracle.contract.weights import (
    MIS,
    MIS_AT_REST,
    SHARE_AT_REST,
    SHARES,
)

CAP = Setting("cap", "number, at least 1", "limit of M, when the reservoir is closed")
ASKED = "asked"
VISIBILITY = Setting(
    "visibility",
    "none",
    "whether the shading asks what the visible point sees",
    more=(ASKED,),
    default="none",
)
"""Of renderers that trace one ray, to the sample that is kept, when they shade."""


JOINED = (("visible_position", "position"),)
HERE_PAST = ("visible_position", "past_position")
HERE_NEW = ("visible_position", "new_position")


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
    inputs=(
        *RECEIVER,
        *MATERIAL,
        *SAMPLE,
        real("pdf", "source density of the sample, 1/sr"),
        *given_targets("target of the sample"),
    ),
    outputs=(
        real("p_hat", "target of the sample"),
        real("W", "contribution weight, sr"),
        real("M", "confidence"),
    ),
    settings=(TARGET_OR_DATA, SURFACE),
    source="[Ouyang21, Alg. 2]",
    joins=JOINED,
    clauses=(
        "the target is the one that is asked for",
        CLAUSE,
        "W has the density of its row",
        "nulls count",
        "W = 0 where pdf is 0",
        "W = 0 where p̂ is 0 although there is light",
    ),
)

MEETING = (
    "the target is the one that is asked for",
    CLAUSE,
    "the past has w₀ = p̂ W₀ M₀",
    "the new sample has the density of its row",
    "w₁ = 0 where pdf is 0",
    "the new sample is kept where u (w₀ + w₁) < w₁",
    "the new sample is kept where w₀ = 0 < w₁",
    "W is divided by the target of what is kept",
    "Z counts both, before the cap",
    "nulls count, in the past and now",
    "an empty past does not count",
    "M is capped when it is stored",
    "M counts where nothing is kept",
    "W = 0 where nothing is kept although there is light",
)
"""Clauses of Algorithm 3, whether or not the past has moved."""

TEMPORAL = Pass(
    name="temporal",
    summary="Algorithm 3: the new sample meets the pixel's past; nothing moves",
    formula=(
        "the past with w₀ = p̂(y₀) W₀ M₀, then the new sample with w₁ = p̂(y₁) / pdf;\n"
        "the new one is kept where u (w₀ + w₁) < w₁, and where w₀ = 0 < w₁;\n"
        "W = (w₀ + w₁) / (p̂(y) (M₀ + 1)), M = min(M₀ + 1, cap);\n"
        "defensive: of that MIS weights tells"
    ),
    inputs=(
        *RECEIVER,
        *MATERIAL,
        *prefixed("past", RESERVOIR),
        *prefixed("new", SAMPLE),
        real("new_pdf", "source density of the new sample, 1/sr"),
        real("u", "number in [0, 1)"),
        *given_targets("targets of the new sample, and of the past's", 2),
    ),
    outputs=RESERVOIR,
    settings=(TARGET_OR_DATA, CAP, MIS_AT_REST, SURFACE),
    source="[Ouyang21, Alg. 3], with w rebuilt after the cap",
    joins=(HERE_PAST, HERE_NEW),
    terms=_stream(2),
    clauses=(*MEETING, SHARE_AT_REST),
)

SHIFTING = (
    "w has the Jacobian of the shift",
    "J is not limited",
    "w = 0 where the receiver does not see the sample",
    "M of what is not seen counts",
    "w = 0 below the horizon and where the back is seen",
    "the sum is divided as it is asked for",
    "the domain asks the horizon of the source",
    "the domain asks on which side the sample shines",
    "the domain asks what the source sees",
    "the domain asks the albedo of the source",
    "the domain asks the view of the source",
    "who made the sample is in the domain",
)
"""Clauses of passes that shift samples from one point to another."""

MOVED = Pass(
    name="moved",
    summary="Algorithm 3 where the past was seen from another point",
    formula=(
        "the past with w₀ = p̂(y₀) W₀ M₀ J(x_past → x), 0 where x does not see y₀;\n"
        "then the new sample with w₁ = p̂(y₁) / pdf; it is kept where u (w₀ + w₁) < w₁,"
        " and where w₀ = 0 < w₁;\n"
        "1/M: Z = M₀ + 1;  1/Z: Z = M₀ + 1 where the kept sample is in the domain of"
        " x_past, else 1;\n"
        "y is in the domain of x_past where p̂(y) > 0 there, with its own normal, albedo"
        " and declared surface, and x_past sees y;\n"
        "W = (w₀ + w₁) / (p̂(y) Z), M = min(M₀ + 1, cap), whatever x sees"
    ),
    inputs=(
        *RECEIVER,
        *MATERIAL,
        *prefixed("past", RECEIVER),
        *prefixed("past", MATERIAL),
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
        *given_targets(SEEN_ALIKE, 2, 2),
    ),
    outputs=RESERVOIR,
    settings=(TARGET_OR_DATA, CAP, MIS, SURFACE),
    source="[Ouyang21, Alg. 3 and Eq. 11]",
    joins=(
        HERE_PAST,
        HERE_NEW,
        ("past_visible_position", "past_position"),
        ("past_visible_position", "new_position"),
    ),
    terms=_stream(2),
    clauses=(
        *MEETING,
        *SHIFTING,
        *SHARES,
    ),
)

DISK, TABLE = "disk", "table"
SEARCH = Setting(
    "search",
    DISK,
    "where neighbours are looked for: in a disk, or at offsets of the renderer's own",
    more=(TABLE,),
    default=DISK,
)
REFUSED, CLAMPED, MIRRORED = "refused", "clamped", "mirrored"
BORDER = Setting(
    "border",
    REFUSED,
    "what becomes of places outside of the image",
    more=(CLAMPED, MIRRORED),
    default=REFUSED,
)
NEIGHBORS = Pass(
    name="neighbors",
    summary="Neighbours whose samples a pixel reuses",
    formula=(
        "N = width · height; r = max(radius · width, min_radius);\n"
        "for each k: offset = r √u₀ (cos 2πu₁, sin 2πu₁), each component rounded to the"
        " nearest whole, ties to even;\n"
        "usable where the pixel lies in the image and is similar; else the neighbour is"
        " −1 and r = max(r / 2, min_radius); the pixel itself is −1, and usable;\n"
        "search in a table: the offset is given, in columns and rows downwards, and"
        " there is no radius, nor u;\n"
        "border, of each coordinate c of n pixels:\n"
        "  clamped: c = min(max(c, 0), n − 1);\n"
        "  mirrored: c = −c where c < 0, then c = 2 n − 1 − c where c ≥ n; once, and"
        " what is outside then is refused"
    ),
    inputs=(
        RECEIVER[1],
        real("depth", "view depth, m; 0 where nothing is seen"),
        *given_with(
            SEARCH.name,
            (DISK,),
            (real("u", "two numbers in [0, 1) for each neighbour", "K", 2),),
        ),
        *given_with(
            SEARCH.name,
            (TABLE,),
            (index("offsets", "columns and rows to each neighbour, pixels", "K", 2),),
        ),
    ),
    outputs=(index("neighbors", "row of the neighbour, or −1", "K"),),
    settings=(
        Setting("width", "pixels", "of the image; row = y · width + x"),
        Setting("radius", "number", "share of the width; not of a table"),
        Setting("min_radius", "pixels", "least radius; not of a table"),
        Setting("max_angle", "degrees", "between the normals"),
        Setting("max_depth", "number", "relative difference of the depths"),
        SEARCH,
        BORDER,
    ),
    source="[Ouyang21, section 5]; tables and borders as RTXDI and bevy have them",
    clauses=(
        "the radius is a share of the width",
        "offsets are uniform on the disk",
        "offsets are rounded to the nearest whole",
        "−1 outside of the image",
        "−1 where the pixel is not similar",
        "the radius halves after a failure",
        "the radius does not fall below the least",
        "the pixel itself is −1",
        "the pixel itself does not halve the radius",
        "the offsets of a table are taken as they are",
        "places outside are clamped, if that is asked",
        "places outside are mirrored, if that is asked",
    ),
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
        "does where p̂(y) > 0 at its visible point, with its own normal, albedo and "
        "declared surface, and it sees the sample; past and own always do;\n"
        "balance, pairwise, defensive: of these MIS weights tells;\n"
        "W = Σ w / (p̂(y) Z), and then M = min(Σ M, cap)"
    ),
    inputs=(
        *RECEIVER,
        *MATERIAL,
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
        *given_targets(SEEN_ALIKE, "K+1", "K+2"),
    ),
    outputs=RESERVOIR,
    settings=(TARGET_OR_DATA, CAP, MIS, SURFACE),
    source="[Ouyang21, Alg. 4], where the weight is multiplied by the Jacobian",
    joins=(*JOINED, HERE_PAST),
    terms=_stream("K+2"),
    clauses=(
        "the target is the one that is asked for",
        CLAUSE,
        "reused samples have w = p̂ W M",
        "the stream is past, own and neighbours in order",
        "each decision has a number of its own",
        "a candidate is kept where u (w_before + w) < w",
        "W is divided by the target of what is kept",
        "Z adds the M of each, before the cap",
        "nulls count",
        "empty rows do not count",
        "a neighbour −1 has no weight and no M",
        "past and own are always in the domain",
        "M is capped when it is stored",
        "M counts where nothing is kept",
        "W = 0 where nothing is kept although there is light",
        *SHIFTING,
        *SHARES,
    ),
)

FUSED = Pass(
    name="fused",
    summary="Spatiotemporal resampling: pixels resample what some kept a frame ago",
    formula=(
        "in this order: the pixel's own reservoir of this frame, as Algorithm 2 leaves"
        " it, with w = p̂(y) W M; then source 0 … K−1, which are reservoirs of the past"
        " frame, with w = p̂(y) W M J(x_source → x);\n"
        "a source is a row of the past buffers, with its own visible point there: that"
        " of the pixel's history, of others near it; all are shifted, and J = 1 only"
        " where the point is the same;\n"
        "w = 0 where x does not see a source's sample, whose M counts all the same;"
        " source −1 has w = 0 and M = 0;\n"
        "a candidate is kept where u (w_before + w) < w, and where w_before = 0 < w;\n"
        "1/M: Z = Σ M;  1/Z: Z = Σ M over those that hold the kept sample; a source"
        " does where p̂(y) > 0 at its visible point, with its own normal, albedo and"
        " declared surface, and it sees the sample; the pixel's own always does;\n"
        "balance, pairwise, defensive: of these MIS weights tells;\n"
        "W = Σ w / (p̂(y) Z), and then M = min(Σ M, cap)"
    ),
    inputs=(
        *RECEIVER,
        *MATERIAL,
        *RESERVOIR,
        *prefixed("past", RECEIVER),
        *prefixed("past", MATERIAL),
        *prefixed("past", RESERVOIR),
        index("sources", "row of each source in the past buffers, or −1", "K"),
        bits(
            "visible",
            "who sees which sample: column 0 is x, 1 + k the visible point of source k;"
            " bit 0 is the pixel's own sample, 1 + k that of source k; K is 30 at most,"
            " and bit 0 of column 0 is not looked at",
            "K+1",
        ),
        real("u", "numbers in [0, 1) that decide on the sources", "K"),
        *given_targets(SEEN_ALIKE, "K+1", "K+1"),
    ),
    outputs=RESERVOIR,
    settings=(TARGET_OR_DATA, CAP, MIS, SURFACE),
    source="[Ouyang21, Algs. 3 and 4] in one pass, as RTXDI and others have it",
    joins=JOINED,
    terms=_stream("K+1"),
    clauses=(
        "the target is the one that is asked for",
        CLAUSE,
        "reused samples have w = p̂ W M",
        "the stream is own, then the sources in order",
        "each decision has a number of its own",
        "a candidate is kept where u (w_before + w) < w",
        "W is divided by the target of what is kept",
        "Z adds the M of each, before the cap",
        "nulls count",
        "empty rows do not count",
        "a source −1 has no weight and no M",
        "own is always in the domain",
        "M is capped when it is stored",
        "M counts where nothing is kept",
        "W = 0 where nothing is kept although there is light",
        "the source is the past's point, not the pixel of its row",
        *SHIFTING,
        *SHARES,
    ),
)

SHADE = Pass(
    name="shade",
    summary="The estimate of the pixel's indirect light",
    formula="color = albedo / π · cos θ · L_o · W, 0 where the sample is below the "
    "horizon or shows its back;\n"
    "a declared surface has f, of which Surfaces tells, in place of albedo / π;\n"
    "where visibility is asked, 0 where x does not see the sample",
    inputs=(
        *RECEIVER,
        *MATERIAL,
        *SAMPLE,
        RESERVOIR[3],
        *given_with(
            VISIBILITY.name,
            (ASKED,),
            (bits("visible", "1 where x sees the sample, else 0"),),
        ),
    ),
    outputs=(real("color", "indirect radiance towards the camera, W/(m² sr)", 3),),
    settings=(SURFACE, VISIBILITY),
    source="[Ouyang21, Eq. 8]",
    joins=JOINED,
    terms=(real("term_f", "integrand f = albedo / π · cos θ · L_o", 3),),
    clauses=(
        "the integrand has albedo, cos θ and 1/π",
        "the integrand is multiplied by W",
        "0 where the sample is below the horizon",
        "0 where the sample shows its back",
        "0 where the sample is not seen, if that is asked",
        *SCATTERS,
    ),
)

FRAME_PASSES = (INITIAL, TEMPORAL, MOVED, NEIGHBORS, SPATIAL, FUSED, SHADE)
