"""Passes of the contract about pairs of paths, and images made from differences."""

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
    Setting,
    bits,
    index,
    real,
    vector,
)

SIGN = Setting(
    "sign",
    "plus, minus or both",
    "part of ω G that the reservoir is for; both: all of it, by its magnitude",
)
WIDTH = Setting(
    "width", "whole number", "pixels a row of the image; row = y · width + x"
)
PAPER = "[Wang25, section 4.2]"
NONE = "where the inner shift does not exist inner = 0 and offset = 0"

BASE = "f of the base path in the pixel that k names, over its density"


def _sample(
    *columns: int | str, suffix: str = "", where: str = ""
) -> tuple[Field, ...]:
    """What a sample (x, k) is made of."""
    return (
        bits(f"k{suffix}", "0: the base path is one of pixel i; 1: of j", *columns),
        *_values(*columns, suffix=suffix, where=where),
    )


def _values(
    *columns: int | str, suffix: str = "", where: str = ""
) -> tuple[Field, ...]:
    return (
        real(f"base{suffix}", BASE + where, *columns, 3),
        real(f"offset{suffix}", "f of the offset path in the other pixel", *columns, 3),
        real(
            f"inner{suffix}", "|∂T| of the inner shift; 0: it does not exist", *columns
        ),
    )


PAIR_VALUE = Pass(
    name="pair_value",
    summary="What a sample of a pair contributes to F_i − F_j",
    formula=(
        "k = 0: G = base − offset · inner;\n"
        "k = 1: G = offset · inner − base; a path without offset path gives ±base"
    ),
    inputs=_sample(),
    outputs=(vector("G", "contribution to the difference, W/(m² sr)"),),
    source=f"[Wang25, Eq. 15]; {NONE}",
    clauses=(
        "the offset path has the Jacobian once",
        "k = 1 turns the sign",
        "the difference is that of i less j",
        "a base path alone counts",
    ),
)

PAIR_WEIGHT = Pass(
    name="pair_weight",
    summary="MIS weight of a base path beside its offset path",
    formula=(
        "omega = p_base / (p_base + p_offset · inner);\n"
        "where inner = 0: 1 if p_base > 0, else 0"
    ),
    inputs=(
        real("p_base", "density of the base path in its pixel, or its target"),
        real(
            "p_offset", "density of the offset path in the other pixel, or its target"
        ),
        real("inner", "|∂T| of the inner shift; 0: it does not exist"),
    ),
    outputs=(real("omega", "0 to 1"),),
    source="[Wang25, Eq. 4; Eq. 13 with targets, where densities are not known]",
    clauses=(
        "both ways to draw the two paths share",
        "the offset path's density has the Jacobian",
        "1 without an offset path",
        "0 where the base path cannot be",
    ),
)

INTEGRAND = "ω = 1 / (1 + inner), H = ω G with G of pass pair_value"
PART = (
    "plus: contribution = max(H, 0); minus: −max(−H, 0); both: H; by channel;\n"
    "p_hat = 0.2126 |r| + 0.7152 |g| + 0.0722 |b| of the contribution"
)

PAIR_TARGET = Pass(
    name="pair_target",
    summary="What a sample adds for the sign of its reservoir, and its target",
    formula=f"{INTEGRAND};\n{PART}",
    inputs=_sample(),
    outputs=(
        vector("contribution", "to F_i − F_j, before W"),
        real("p_hat", "target"),
    ),
    settings=(SIGN,),
    source=(
        "[Wang25, Eqs. 14, 16, 19 and 23 to 26]. Densities are those of primary sample "
        "space, 1 each: elsewhere inner is the Jacobian times p_offset / p_base"
    ),
    clauses=(
        "H has the weight of the base path",
        "reservoirs of a sign have that part alone",
        "the negative part is negative",
        "each channel is split by itself",
        "magnitudes are taken before the luminance",
    ),
)

PAIR_INITIAL = Pass(
    name="pair_initial",
    summary="A new reservoir of a pair, from one candidate of each pixel",
    formula=(
        "column c is the candidate with k = c; p_hat_c by pass pair_target;\n"
        "w_c = p_hat_c · W_c; k = 1 if u · (w_0 + w_1) < w_1, else 0;\n"
        "p_hat = p_hat_k, W = (w_0 + w_1) / p_hat, M = 1; W = 0 where both w are 0"
    ),
    inputs=(
        *_values(2, where="; of both candidates"),
        real("W", "of the candidates, 1 / density; 0: no path", 2),
        real("u", "in [0, 1)"),
    ),
    outputs=(
        bits("k", "which is kept; not asked for where W = 0"),
        real("p_hat", "target of what is kept; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence"),
    ),
    settings=(SIGN,),
    source=(
        "[Wang25, section 4.4 and Eq. 18]. k = 0 and k = 1 are disjoint parts of the "
        "domain, so that each candidate has the MIS weight 1"
    ),
    clauses=(
        "each candidate has the weight 1",
        "two candidates count as one",
        "nulls count",
        "the target is that of the reservoir's sign",
        "W is divided by the target of what is kept",
        "u decides as in every stream",
        "W = 0 where no weight arrives",
    ),
)

INNER_SHIFT = Pass(
    name="inner_shift",
    summary="Which pixel the offset path of a sample belongs to, and its place there",
    formula=(
        "k = 0: pixel = second, x_to = x + dx, y_to = y + dy;\n"
        "k = 1: pixel = first, x_to = x − dx, y_to = y − dy;\n"
        "offset and inner are the columns of that pixel, 0 where its jacobian is 0"
    ),
    inputs=(
        bits("k", "0: the base path is one of pixel i; 1: of j"),
        index("first", "row of pixel i in the image"),
        index("second", "row of pixel j"),
        real("dx", "from i to j: 1 for horizontal pairs, else 0"),
        real("dy", "from i to j: 1 for vertical pairs, else 0"),
        real("x", "where the base path's x_1 appears in the image, pixels"),
        real("y", "likewise"),
        real("value_at", "f of the path shifted to pixel i (0) and j (1)", 2, 3),
        real("jacobian_at", "of the shift to pixel i (0) and j (1); 0: none", 2),
    ),
    outputs=(
        index("pixel", "row of the other pixel of the pair"),
        real("x_to", "where the offset path's x_1 appears, pixels"),
        real("y_to", "likewise"),
        vector("offset", "f of the offset path, 0 without one"),
        real("inner", "|∂T|, 0 without one"),
    ),
    source=(
        "[Wang25, Eqs. 2 to 4]: T_ij where k = 0, T_ji where k = 1. The shift itself "
        "is pass shift or path_jacobian; here its results are given"
    ),
    clauses=(
        "the offset path is in the other pixel",
        "its place moves from the base path's pixel to the other",
        "0 where the shift does not exist",
    ),
)

OUTER_SHIFT = Pass(
    name="outer_shift",
    summary="A sample of one pair as a sample of another pair",
    formula=(
        "k remains; the base path goes to pixel i of the pair where k = 0, to j where "
        "k = 1: base = value_at_k, jacobian = jacobian_at_k;\n"
        "the offset path is rebuilt from there: offset = rebuilt_at_k, inner = "
        "inner_at_k;\n"
        "all 0 where jacobian = 0"
    ),
    inputs=(
        bits("k", "0: the base path is one of pixel i; 1: of j"),
        index("first", "row of pixel i of the pair that it goes to"),
        index("second", "row of pixel j"),
        real("value_at", "f of the base path shifted to pixel i (0) and j (1)", 2, 3),
        real("jacobian_at", "of that shift to pixel i (0) and j (1); 0: none", 2),
        real(
            "rebuilt_at",
            "f of the offset path that pass inner_shift makes of the path at i (0) and "
            "at j (1)",
            2,
            3,
        ),
        real("inner_at", "Jacobian of that inner shift", 2),
        vector("offset_from", "what the sample's offset path was where it comes from"),
        real("inner_from", "and its Jacobian there"),
    ),
    outputs=(
        index("pixel", "row of the pixel that the base path goes to"),
        vector("base", "f of the base path there"),
        vector("offset", "f of the offset path there"),
        real("inner", "|∂T| there"),
        real("jacobian", "|∂T*|"),
    ),
    source="[Wang25, Eqs. 21 and 22, and Figure 4]. The columns _from are not needed",
    clauses=(
        "k remains",
        "the Jacobian is that of the base path alone",
        "the offset path is rebuilt",
        "0 where the base path has no place",
    ),
)

PAIR_REUSE = Pass(
    name="pair_reuse",
    summary="Which of the samples that K pairs bring for a sign is kept, its weight",
    formula=(
        "pass path_reuse, with p̂ of pass pair_target for the sign:\n"
        "target_base_s of k_s, base_from_s, offset_from_s, inner_from_s;\n"
        "target_here_s of k_s, base_s, offset_s, inner_s, 0 where jacobian_s = 0;\n"
        "target_at_sq of k_s, base_at_sq, offset_at_sq, inner_at_sq, times "
        "jacobian_at_sq"
    ),
    inputs=(
        real("W", "of the sources' reservoirs", "K"),
        real("M", "their confidences", "K"),
        bits("there", "1 where the slot has a source at all", "K"),
        *_sample("K", suffix="_from", where="; where the sample was made"),
        *_values("K", where="; at the receiver, by pass outer_shift"),
        real("jacobian", "of the outer shift to the receiver; 0: no such path", "K"),
        real(
            "base_at",
            "row s, column q: base of the sample of s at source q",
            "K",
            "K",
            3,
        ),
        real("offset_at", "likewise", "K", "K", 3),
        real("inner_at", "likewise", "K", "K"),
        real(
            "jacobian_at",
            "of the outer shift from the receiver to source q; 0: q cannot make it",
            "K",
            "K",
        ),
        real("u", "in [0, 1); the first decides nothing", "K"),
    ),
    outputs=(
        index("slot", "that is kept; not asked for where W = 0"),
        real("p_hat", "target_here of what is kept; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence"),
    ),
    settings=(
        SIGN,
        Setting("mis", "1/M, 1/Z, balance, pairwise or defensive", "the weights"),
        Setting("canonical", "whole number, below K", "slot that stands: jacobian 1"),
        Setting("cap", "number, 1 upwards", "limit of M, on the way out"),
    ),
    source=(
        "[Wang25, Eqs. 18 to 20; Lin22, Eqs. 22 and 36 to 38]. A sample of the sign at "
        "its source may have none of it here, and the other way round: weights other "
        "than 1/M ask each source"
    ),
    clauses=(
        "the target is that of the pair and sign here",
        "the offset path is the one rebuilt here",
        "the outer Jacobian is that of the base path alone",
        "supports are those of the sign",
        "what others could make is asked with their offset paths",
        "the sum is divided as it is asked for",
        "nulls count",
        "slots without a source do not count",
        "M is capped on the way out",
        "u decides as in every stream",
        "W = 0 where no weight arrives",
    ),
)

PAIR_ESTIMATE = Pass(
    name="pair_estimate",
    summary="Difference of a pair from its reservoirs",
    formula=(
        "contribution of pass pair_target, for plus in column 0, minus in column 1;\n"
        "reservoirs = two: delta = contribution_0 · W_0 + contribution_1 · W_1;\n"
        "reservoirs = one: delta = H_0 · W_0, and column 1 is not read"
    ),
    inputs=(
        *_sample(2),
        real("W", "of the reservoirs; 0: empty", 2),
    ),
    outputs=(vector("delta", "estimate of F_i − F_j"),),
    settings=(Setting("reservoirs", "two or one", "of a sign each, or of both signs"),),
    source="[Wang25, Eqs. 17 and 24]. The contribution of minus is negative already",
    clauses=(
        "each reservoir adds the part of its sign",
        "the negative part is subtracted",
        "each sample has the W of its reservoir",
        "the contribution has the weight of the base path",
        "one reservoir stands for both signs",
    ),
)

AFTER_ESTIMATE = Pass(
    name="after_estimate",
    summary="Difference of a pair from the paths that its pixels have kept",
    formula=(
        "column c is the path that pixel i (0) or j (1) has kept, with k = c;\n"
        "p_c = luminance of base_c, q_c = luminance of offset_c;\n"
        "ω_c of pass pair_weight with p_c, q_c and inner_c;\n"
        "delta = Σ ω_c · G_c · W_c, with G_c of pass pair_value"
    ),
    inputs=(
        *_values(2),
        real("W", "of the pixels' reservoirs; 0: empty", 2),
    ),
    outputs=(vector("delta", "estimate of F_i − F_j"),),
    source="[Wang25, Eqs. 11 to 13]: gradient after ReSTIR",
    clauses=(
        "targets stand in the place of densities",
        "the offset path's target has the Jacobian",
        "both paths are added, with the sign of k",
        "each path has its own W",
    ),
)


def _pixel(which: str) -> tuple[Field, ...]:
    return (
        vector(f"albedo_{which}", "albedo of its point"),
        vector(f"normal_{which}", "unit normal"),
        real(f"depth_{which}", "distance from the camera, m; above 0 where it hits"),
        bits(f"hit_{which}", "1 where the pixel sees a point"),
    )


GIVEN, EITHER_SIDE, BY_CHANNELS = "given", "either-side", "channels"
LIKENESS = (
    Setting(
        "thresholds",
        "fixed",
        "0.1, 0.9 and 0.1; given: most_albedo, least_cosine and most_depth",
        more=(GIVEN,),
        default="fixed",
    ),
    Setting(
        "most_albedo",
        "number",
        "in place of the first 0.1, where they are given",
        default="0.1",
    ),
    Setting("least_cosine", "number", "likewise, of 0.9", default="0.9"),
    Setting("most_depth", "number", "likewise, of the second 0.1", default="0.1"),
    Setting(
        "normals",
        "facing",
        "normal_a · normal_b as it is; either-side: its magnitude",
        more=(EITHER_SIDE,),
        default="facing",
    ),
)
"""What pixels look alike by, of those who declare it."""

DECLARED_CLAUSES = (
    "declared thresholds are those that are given",
    "declared normals may be turned round",
)

EDGE = (
    "edge = 1 where just one of the two sees a point, or both do and: |albedo_a − "
    "albedo_b| > 0.1 in any channel, or normal_a · normal_b < 0.9, or |depth_a − "
    "depth_b| > 0.1 · max(depth_a, depth_b); else 0"
)

EDGE_PAIR = Pass(
    name="edge_pair",
    summary="Whether two pixels look unlike: whether their pair lies across an edge",
    formula=EDGE,
    inputs=(*_pixel("a"), *_pixel("b")),
    outputs=(bits("edge", "1 or 0"),),
    settings=LIKENESS,
    source=(
        "[Wang25, section 4.3.2], where a cosine *above* 0.9 is printed, and a depth "
        "relative to that of the first pixel. Other thresholds bring no bias: who has "
        "them declares thresholds = given, and is asked for several"
    ),
    clauses=(
        "any channel of the albedo, in absolute value",
        "a cosine below 0.9",
        "depths relative to the larger one",
        "any of the three is enough",
        "1 where one pixel alone sees a point",
        "0 where none does",
        *DECLARED_CLAUSES,
    ),
)

PAIR_SEARCH = Pass(
    name="pair_search",
    summary="The similar edge pair around each edge pair of an image",
    formula=(
        "rows are pixels; column 0 is the pair with the right neighbour, 1 with the "
        "lower one; edges by pass edge_pair;\n"
        "try t of an edge pair with first pixel (x, y): n = 2 radius + 1, q = "
        "floor(u_t · n²), first pixel (x + q mod n − radius, y + floor(q / n) − "
        "radius) of the same axis;\n"
        "it is taken where both its pixels are in the image, it is not the pair "
        "itself, is an edge pair, and its first pixel looks like the first, its second "
        "like the second: pass edge_pair gives 0;\n"
        "neighbor = first pixel of the first try that is taken; −1 without one, for "
        "pairs that are no edge, and for pairs that lead out of the image"
    ),
    inputs=(
        vector("albedo", "albedo of the pixel's point"),
        vector("normal", "unit normal"),
        real("depth", "distance from the camera, m"),
        bits("hit", "1 where the pixel sees a point"),
        real("u", "in [0, 1), of each axis and try", 2, "K"),
    ),
    outputs=(index("neighbor", "row of a first pixel, of each axis, or −1", 2),),
    settings=(
        WIDTH,
        Setting("radius", "whole number", "columns and lines, at most"),
        *LIKENESS,
    ),
    source="[Wang25, section 4.3.2]",
    clauses=(
        "pairs that are no edge have none",
        "the pair found is an edge as well",
        "both pixels are compared, in their order",
        "the first that is alike is taken",
        "the pair itself is not",
        "the places of the square are counted line by line",
        "tries outside of the image are lost",
        "of the same axis",
        *DECLARED_CLAUSES,
    ),
)

PAIR_MOTION = Pass(
    name="pair_motion",
    summary="Which pair of the last frame a pair was",
    formula=(
        "pivot = second where it sees a point and the first does not, or both do and "
        "depth_second < depth_first; else first;\n"
        "before = before_first or before_second, of the pivot;\n"
        "row = before where the pivot is the first; where it is the second, the pixel "
        "to the left of before (axis 0) or above it (axis 1);\n"
        "−1 where before is −1, and where row or its neighbour on the axis would be "
        "outside of the image"
    ),
    inputs=(
        bits("axis", "0: the second pixel is to the right; 1: it is below"),
        index("first", "row of pixel i in this frame"),
        real("depth_first", "distance from the camera, m"),
        real("depth_second", "likewise"),
        bits("hit_first", "1 where it sees a point"),
        bits("hit_second", "likewise"),
        index("before_first", "row of the last frame where pixel i was, or −1"),
        index("before_second", "where pixel j was, or −1"),
    ),
    outputs=(index("row", "of the first pixel of the pair in the last frame, or −1"),),
    settings=(
        WIDTH,
        Setting("height", "whole number", "lines of the image"),
    ),
    source="[Wang25, section 4.3.1]: what is behind may have been hidden",
    clauses=(
        "the nearer pixel is the pivot",
        "a pixel that sees nothing is the farther one",
        "the first where both are alike",
        "the pair is where its pivot was",
        "−1 where the pivot was nowhere",
        "−1 where the pair would lead out of the image",
    ),
)

PRIMAL = Pass(
    name="primal",
    summary="Indirect light of a pixel by its own sample, before the image is made",
    formula="color = value · W",
    inputs=(
        vector("value", "f of the path that the pixel has kept, over its density"),
        real("W", "its unbiased contribution weight; 0: none"),
        vector("emission", "that the pixel sees directly; not needed"),
    ),
    outputs=(vector("color", "P of pass poisson_l2"),),
    source=(
        "[Wang25, section 5]. Emission seen directly is added to the finished image: "
        "differences do not have it"
    ),
    clauses=("the path has its W", "emission seen directly is added later"),
)

PAIR_DIFFERENCES = Pass(
    name="pair_differences",
    summary="Differences of an image from those of its pairs",
    formula=(
        "dx = −delta_x, dy = −delta_y: Δ = F_i − F_j is minus the forward difference;\n"
        "0 in the last column for dx, and in the last line for dy, whatever delta is"
    ),
    inputs=(
        vector(
            "delta_x", "Δ of the pixel and its right neighbour; not read without one"
        ),
        vector(
            "delta_y", "Δ of the pixel and its lower neighbour; not read without one"
        ),
    ),
    outputs=(
        vector("dx", "right neighbour less pixel"),
        vector("dy", "lower neighbour less pixel"),
    ),
    settings=(WIDTH,),
    source="[Wang25, Eqs. 1 and 14], which have Δ with opposite signs",
    clauses=(
        "the sign turns",
        "axes are not exchanged",
        "0 at the last column and line",
    ),
)

DIFFERENCES = Pass(
    name="differences",
    summary="Forward differences of known pixels",
    formula=(
        "dx(x, y) = color(x + 1, y) − color(x, y), dy(x, y) = color(x, y + 1) − "
        "color(x, y); 0 in the last column and line"
    ),
    inputs=(vector("color", "of the pixels"),),
    outputs=(
        vector("dx", "right neighbour less pixel"),
        vector("dy", "lower neighbour less pixel"),
    ),
    settings=(WIDTH,),
    source="[Wang25, Eq. 1]",
    clauses=(
        "neighbour less pixel",
        "axes are not exchanged",
        "0 at the last column and line",
    ),
)

IMAGE = (
    vector("primal", "P: estimates of the pixels"),
    vector("dx", "estimated difference to the right neighbour; 0 in the last column"),
    vector("dy", "estimated difference to the lower neighbour; 0 in the last line"),
)
ALPHA = Setting("alpha", "number, above 0", "weight of P on its rows; squared in L2")

POISSON_L2 = Pass(
    name="poisson_l2",
    summary="Image from pixels and differences by least squares",
    formula=(
        "minimize |alpha (I − P)|² + |D_x I − dx|² + |D_y I − dy|², D of pass "
        "differences, each channel by itself;\n"
        "with A = alpha² + D_xᵀ D_x + D_yᵀ D_y and b = alpha² P + D_xᵀ dx + D_yᵀ dy: "
        "|b − A I| ≤ residual · |b| in each channel, and rounding"
    ),
    inputs=IMAGE,
    outputs=(vector("color", "I"),),
    settings=(
        WIDTH,
        ALPHA,
        Setting("residual", "number", "of the normal equations that is left, at most"),
    ),
    source=(
        "[Lehtinen13, section 3; Kettunen15]; alpha = 0.2 is usual. Any solver is "
        "right: A has eigenvalues from alpha² to alpha² + 8. |·| is the square root of "
        "a sum of squares over the pixels"
    ),
    clauses=(
        "alpha is squared",
        "alpha is on the pixels",
        "differences are to the right and down",
        "axes are not exchanged",
        "the sign of the divergence",
        "nothing leads out of the image",
        "channels are solved by themselves",
    ),
)

POISSON_L1 = Pass(
    name="poisson_l1",
    summary="Image from pixels and differences by least absolute values",
    formula=(
        "minimize E(I) = Σ |alpha (I − P)| + Σ |D_x I − dx| + Σ |D_y I − dy| over the "
        "pixels, |·| the length of the three channels:\n"
        "E(I) ≤ (1 + ratio) · min E"
    ),
    inputs=IMAGE,
    outputs=(vector("color", "I"),),
    settings=(
        WIDTH,
        ALPHA,
        Setting("ratio", "number", "by which E may exceed its minimum"),
        Setting(
            "norm",
            "length",
            "|·| is the length of the three channels; channels: the sum of their "
            "absolute values",
            more=(BY_CHANNELS,),
            default="length",
        ),
    ),
    source=(
        "[Lehtinen13, section 3; Kettunen15]. Any solver is right; the result is "
        "biased, as it is not linear in what it is given"
    ),
    clauses=(
        "absolute values, not squares",
        "alpha is not squared",
        "alpha is on the pixels",
        "differences are to the right and down",
        "nothing leads out of the image",
        "E is near its minimum",
        "a declared norm is that of each channel",
    ),
)

GRADIENT_PASSES = (
    PAIR_VALUE,
    PAIR_WEIGHT,
    PAIR_TARGET,
    PAIR_INITIAL,
    INNER_SHIFT,
    OUTER_SHIFT,
    PAIR_REUSE,
    PAIR_ESTIMATE,
    AFTER_ESTIMATE,
    EDGE_PAIR,
    PAIR_SEARCH,
    PAIR_MOTION,
    PRIMAL,
    PAIR_DIFFERENCES,
    DIFFERENCES,
    POISSON_L2,
    POISSON_L1,
)
