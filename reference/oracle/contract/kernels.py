"""Kernels of the contract: one formula a row."""

from restir_gi.reference.oracle.contract.fields import Pass, Setting, bits, real, vector
from restir_gi.reference.oracle.contract.groups import RECEIVER, SAMPLE
from restir_gi.reference.oracle.contract.surfaces import MATERIAL, SURFACE

SOURCE = Setting(
    "source", "uniform | cosine", "density of the directions on the hemisphere"
)
TARGET = Setting(
    "target", "scattered | outgoing", "Equation 9, or Equation 10 of the paper"
)

SCATTERS = (
    "a declared surface has its lobe beside the diffuse part",
    "a declared surface takes F at the half vector",
    "a declared surface is 0 where the view is below the horizon",
)
"""Clauses of passes that evaluate f."""

RANDOM = Pass(
    name="random",
    summary="PCG4D: four random words from a key of four words",
    formula=(
        "v = v · 1664525 + 1013904223 in each lane, modulo 2³²;\n"
        "x += y·w, y += z·x, z += x·y, w += y·z, one after the other;\n"
        "v ^= v >> 16 in each lane; the four sums once more;\n"
        "u = (v >> 8) · 2⁻²⁴"
    ),
    inputs=(
        bits("key", "pixel y · width + x, frame, seed, stream · 64 + dimension", 4),
    ),
    outputs=(
        bits("words", "the permuted key", 4),
        real("u", "numbers in [0, 1), multiples of 2⁻²⁴", 4),
    ),
    source="[Jarzynski20, Listing 5]",
    clauses=(
        "each word of the key changes the numbers",
        "u takes the upper 24 bits of a word",
    ),
)

DIRECTION = Pass(
    name="direction",
    summary="A direction on the hemisphere about a normal, and its density",
    formula=(
        "uniform: cos θ = u₀, pdf = 1 / 2π;  cosine: cos θ = √(1 − u₀), "
        "pdf = cos θ / π;\n"
        "azimuth 2π u₁ about the normal, in any frame that depends on the normal alone"
    ),
    inputs=(
        vector("visible_normal", "unit normal"),
        real("u", "two numbers in [0, 1)", 2),
    ),
    outputs=(
        vector("direction", "unit vector"),
        real("pdf", "source density p_q, 1/sr"),
    ),
    settings=(SOURCE,),
    source="[Ouyang21, Alg. 2, line 3]",
    clauses=(
        "the cosine with the normal is that of the source",
        "the density is that of the source",
        "the azimuth is 2π u₁",
        "directions leave on the side of the normal",
    ),
)

TARGET_FUNCTION = Pass(
    name="target",
    summary="Target p̂ of a sample point at a visible point",
    formula=(
        "ω = (x_s − x) / |x_s − x|, luminance Y = 0.2126 R + 0.7152 G + 0.0722 B;\n"
        "scattered: p̂ = Y(albedo / π · L_o) · cos θ;  outgoing: p̂ = Y(L_o);\n"
        "both 0 unless the sample is above the horizon, n·ω > 0, and lit, n_s·ω < 0;\n"
        "a declared surface has f, of which Surfaces tells, in place of albedo / π"
    ),
    inputs=(*RECEIVER, *MATERIAL, *SAMPLE),
    outputs=(real("p_hat", "target, without visibility"),),
    settings=(TARGET, SURFACE),
    joins=(("visible_position", "position"),),
    source="[Ouyang21, Eq. 9 and 10]",
    clauses=(
        "scattered has albedo, cos θ and 1/π",
        "outgoing has none of them",
        "luminance has the weights of Rec. 709",
        "0 where the sample is below the horizon",
        "0 where the sample shows its back",
        *SCATTERS,
    ),
)

JACOBIAN = Pass(
    name="jacobian",
    summary="Ratio of the solid angles of one patch, of the reconnection shift",
    formula="J = (|cos φ_to| / |cos φ_from|) · (d_from² / d_to²), angles at x_s",
    inputs=(
        vector("x_from", "visible point that made the sample, m"),
        vector("x_to", "visible point that reuses it, m"),
        vector("position", "sample point x_s, m"),
        vector("normal", "unit normal at x_s"),
    ),
    outputs=(
        real(
            "jacobian",
            "factor on W; 0 where cos φ_from, d_from or d_to is 0; finite where d² or J"
            " leaves the type's range, and then any number from 0 on",
        ),
    ),
    source="[Ouyang21, Eq. 11]",
    joins=(("x_from", "position"), ("x_to", "position")),
    clauses=(
        "the cosines are those at x_s, the receiver's above",
        "the distances are squared, the source's above",
        "J is not limited",
        "the back of the patch counts as its front",
        "0 where cos φ_from or cos φ_to is 0",
        "0 where points touch",
    ),
)

MERGE = Pass(
    name="merge",
    summary="Whether the second of two candidates is kept",
    formula=(
        "second where u (w_a + w_b) < w_b, and where w_a = 0 < w_b; where both are 0 "
        "nothing is kept, and second is not looked at;\n"
        "w = w_a + w_b; M = M_a + M_b"
    ),
    inputs=(
        real("w_a", "sum of resampling weights of the first"),
        real("M_a", "its confidence"),
        real("w_b", "the same of the second"),
        real("M_b", "its confidence"),
        real("u", "number in [0, 1)"),
    ),
    outputs=(
        bits("second", "1 where the second sample is kept, else 0"),
        real("w", "sum of both"),
        real("M", "sum of both"),
    ),
    source="[Ouyang21, Alg. 1, lines 6 to 10]",
    clauses=(
        "the second is kept where u (w_a + w_b) < w_b",
        "a weight is kept beside 0, whatever u is",
        "a weight of 0 is never kept beside another",
        "w and M are sums, M of what has no weight too",
    ),
)

FINALIZE = Pass(
    name="finalize",
    summary="Closing a reservoir",
    formula="W = w / (Z · p̂), and 0 where p̂ or Z is 0",
    inputs=(
        real("w", "sum of resampling weights"),
        real("p_hat", "target of the kept sample"),
        real("Z", "what the sum is divided by: M, or Z"),
    ),
    outputs=(
        real(
            "W",
            "unbiased contribution weight, sr; where it overflows any number from a"
            " quarter of the largest on",
        ),
    ),
    source="[Ouyang21, Eq. 7]",
    clauses=(
        "w is divided by Z and by p̂",
        "W is not limited",
        "0 where p̂ is 0",
        "0 where Z is 0",
    ),
)

SIMILAR = Pass(
    name="similar",
    summary="Whether two visible points may share samples",
    formula=(
        "n_a·n_b ≥ cos(max_angle), |z_a − z_b| ≤ max_depth · max(z_a, z_b), "
        "both depths above 0"
    ),
    inputs=(
        vector("normal_a", "unit normal"),
        real("depth_a", "view depth, m; 0 where nothing is seen"),
        vector("normal_b", "unit normal"),
        real("depth_b", "view depth, m"),
    ),
    outputs=(bits("similar", "1 or 0"),),
    settings=(
        Setting("max_angle", "degrees", "between the normals"),
        Setting("max_depth", "number", "relative difference of the depths"),
    ),
    source="[Ouyang21, section 4.2]",
    clauses=(
        "the normals differ by max_angle at most",
        "the depths differ by max_depth of the larger at most",
        "0 where a depth is 0",
    ),
)

KERNELS = (RANDOM, DIRECTION, TARGET_FUNCTION, JACOBIAN, MERGE, FINALIZE, SIMILAR)
