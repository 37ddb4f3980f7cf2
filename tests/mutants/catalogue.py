"""Mistakes that renderers made, as edits of the production code.

``ids`` are rows of the bug catalogue; ``expected`` names hypotheses of
:mod:`restir_gi.reference.oracle.diagnosis` that would be right, none where there is
none.
"""

from dataclasses import dataclass
from typing import Literal

Class = Literal["bias", "variance", "equivalent", "robustness"]

RESERVOIR = "restir_gi.reference.resampling.reservoir"
TARGET = "restir_gi.reference.resampling.target"
SHIFT = "restir_gi.reference.resampling.shift"
MIS = "restir_gi.reference.resampling.reservoir"
REUSED = "restir_gi.reference.resampling.reuse"
PIXELS = "restir_gi.reference.passes.pixels"
SPATIAL = "restir_gi.reference.passes.spatial"
NEIGHBORS = "restir_gi.reference.passes.neighbors"
SHADE = "restir_gi.reference.passes.shade"
GBUFFER = "restir_gi.reference.passes.gbuffer"
TEMPORAL = "restir_gi.reference.passes.temporal"
SAMPLING = "restir_gi.reference.numerics.sampling"
FRAMES = "restir_gi.reference.numerics.frames"
RNG = "restir_gi.reference.numerics.rng"
LAMBERTIAN = "restir_gi.reference.scene.materials.lambertian"
COSINE = "restir_gi.reference.scene.materials.parameters"


@dataclass(frozen=True, slots=True)
class Mutant:
    """One mistake.

    Attributes
    ----------
    name : str
        What was done.
    ids : tuple of str
        Rows of the bug catalogue; "EQ" for its list of equivalent mutants, "§0" for
        its table of measured effects.
    module : str
        With dots.
    old, new : str
        ``old`` occurs once in the module's source.
    expected : tuple of str
        Hypotheses that would be right.
    kind : 'bias', 'variance', 'equivalent' or 'robustness'
        'bias': the expectation changes in some input; 'variance': it is another
        estimator of the same; 'equivalent': the same distribution, or a factor that
        cancels; 'robustness': only what is not a number, out of bounds, or of weight 0.
    also : tuple of (module, old, new)
        Further edits that belong to it.
    """

    name: str
    ids: tuple[str, ...]
    module: str
    old: str
    new: str
    expected: tuple[str, ...] = ()
    kind: Class = "bias"
    also: tuple[tuple[str, str, str], ...] = ()

    @property
    def edits(self) -> tuple[tuple[str, str, str], ...]:
        """All edits."""
        return ((self.module, self.old, self.new), *self.also)


WEIGHT = "w = p_hat * r.W * r.M"
JACOBIAN = "jacobian = cosines * ratio * ratio * ratio"
COSINES = "abs(dot(n_sample, v_to)), abs(dot(n_sample, v_from))"
LIMITED = "return saturate(jacobian)"
CHOICE = "u * (w_a + w_b) < w_b)"
CLOSED = "divide_or_zero(divide_or_zero(c.w, c.p_hat), normalization)"
KEPT = "return Reservoirs(y=c.y, W=saturate(W), M=c.M)"
CAP = "W=r.W, M=np.minimum(r.M, cap)"
FRESH = "w=saturate(w), M=M)"
BROUGHT = "return Candidates(y=r.y, p_hat=p_hat, w=w, M=r.M)"
TERMS = "np.where(holds, M, M * 0) for"
JACOBIAN_OF_NEIGHBOR = (
    "return self.q.shift(self.x.position, self.q.points.position, self.reservoirs.y)"
)
SHIFTED = "c = reused_candidates(R_n, q.target(R_n.y), J)"
SEEN = "seen = q.sees(R_n.y, c.w > 0)"
OFFERED = "return replace(c, w=np.where(seen, c.w, c.w * 0))"
FACES = "dot(y.normal, toward) < 0, lit_cosine"
OUTGOING = "return np.where(cosine > 0, luminance(y.radiance), 0.0)"
SCALE = "scale = divide_or_zero(cosine, np.pi * np.sqrt(dot(toward, toward)))"
LIGHT = "return luminance(receiver.color * y.radiance) * scale"
LUMINANCE = "dot(color, np.array(luminance_weights(), color.dtype))"
SHOWN = "return radiance * reservoirs.W[:, None]"
REFLECTED = "points.color * (lit_cosine(table, points, wi) / np.pi)[:, None]"
SIDE = "lit = dot(y.normal, omega) < 0"
LIT_COSINE = "cosine = np.maximum(dot(points.shading, wi), 0.0)"
NEIGHBOR_TARGET = "np.where(drawn, target(kind, table, points, y), 0.0)"
LOOKS = "return sees(self.frame.world, self.x, y, possible)"
UNIFORM = "np.where(cos_theta >= 0, 1.0 / (2.0 * np.pi), 0.0)"
COSINE_PDF = "np.maximum(cos_theta, 0.0) / np.pi"
UNIFORM_SAMPLE = "_about_z(u1, np.sqrt(np.maximum(0.0, 1.0 - u1 * u1)), u2)"
COSINE_SAMPLE = "_about_z(np.sqrt(1.0 - u1), np.sqrt(u1), u2)"
PHI = "phi = (2.0 * np.pi) * u\n"
NEW = "new = initial_candidates(S, q.target(S), initial.pdf, initial.M)"
PAST = "R = begin(reused(q, past))"
MERGED = "R = R.then(new, u)"
CLOSE = "return cap_confidence(finalize(R.kept, Z), cap)"
PAST_S = "R_s = begin(reused(q, past))"
OWN_S = "R_s = R_s.then(reused(q, own), u_own)"
CLOSE_S = "return cap_confidence(finalize(R_s.kept, Z), cap)"
LOOP = "for q_n, u_n in neighbors:"
AT_ROWS = "M=np.where(there, r.M, 0.0))"
COULD = "could[slot] = made | q_n.could_make(R.kept.y, full & ~made)"
IS_OTHER = "if not isinstance(q_n, Candidates | Reservoirs):"
EVERYONE = "could = [np.ones(len(full), bool)] * len(Q)"
SUM_M = "return one_over_m(R.M)"
SUM_Z = "return one_over_z(R.M, could_have_made(R, Q))"
AT_NEIGHBOR = """replace(
        q,
        world=q_n.frame.world,
        points=take(q_n.frame.visible.surface, np.maximum(q_n.rows, 0)),
    ).target(R_n.y)"""
TAKE = "from restir_gi.reference.numerics.records import take\n\n    "
REPLACE = "from dataclasses import replace\n\n    "
MOVES = "not isinstance(past, Reservoirs)"
ALIKE = "alike & (near > 0) & (far - near <= max_depth * far)"
ANGLE = "dot(n_a, n_b) >= np.cos(np.radians(max_angle))"
LANDS = "x_to, y_to = border(x + dx, width), border(y + dy, height)"

RECEIVERS_COSINES = """y, x_q = self.reservoirs.y, self.q.points
        v_from, v_to = y.position - self.x.position, y.position - x_q.position
        n_from = take(self.frame.visible.surface.normal, np.maximum(self.rows, 0))
        d_from, d_to = (v_from * v_from).sum(axis=1), (v_to * v_to).sum(axis=1)
        d_from, d_to = np.maximum(d_from, 1e-30), np.maximum(d_to, 1e-30)
        c_from = abs((n_from * v_from).sum(axis=1)) / np.sqrt(d_from)
        c_to = abs((x_q.normal * v_to).sum(axis=1)) / np.sqrt(d_to)
        ratio = np.where(c_from > 0, c_to / np.maximum(c_from, 1e-30), 0.0)
        return ratio * d_from / d_to"""

JACOBIANS = [
    Mutant(
        "the weight is divided by the Jacobian",
        ("JC-01",),
        RESERVOIR,
        "w = w * jacobian",
        "w = divide_or_zero(w, jacobian)",
        ("jacobian-inverted",),
    ),
    Mutant(
        "the Jacobian is left out",
        ("JC-02",),
        RESERVOIR,
        "w = w * jacobian",
        "pass",
        ("jacobian-omitted",),
    ),
    Mutant(
        "the distances are not squared",
        ("JC-03",),
        SHIFT,
        JACOBIAN,
        "jacobian = cosines * ratio * ratio",
        ("jacobian-unsquared",),
    ),
    Mutant(
        "the distances are left out",
        ("JC-03",),
        SHIFT,
        JACOBIAN,
        "jacobian = cosines * ratio",
        ("jacobian-without-distances",),
    ),
    Mutant(
        "the root of the Jacobian",
        ("§0",),
        SHIFT,
        LIMITED,
        "return sqrt(saturate(jacobian))",
        ("jacobian-root",),
    ),
    Mutant(
        "cosines at the visible points",
        ("JC-05",),
        PIXELS,
        JACOBIAN_OF_NEIGHBOR,
        RECEIVERS_COSINES,
        ("jacobian-receiver-cosine",),
    ),
    Mutant(
        "source and receiver change places",
        ("JC-07",),
        PIXELS,
        "return reconnection_jacobian(x_from, x_to, y.position, y.normal)",
        "return reconnection_jacobian(x_to, x_from, y.position, y.normal)",
        ("jacobian-inverted",),
    ),
    Mutant(
        "the distances are upside down",
        ("JC-07",),
        SHIFT,
        JACOBIAN,
        "jacobian = divide_or_zero(cosines, ratio)",
        ("jacobian-distances-upside-down",),
    ),
    Mutant(
        "the cosines are upside down",
        ("JC-07",),
        SHIFT,
        f"divide_or_zero({COSINES})\n        {JACOBIAN}",
        "divide_or_zero(abs(dot(n_sample, v_from)), abs(dot(n_sample, v_to)))\n"
        "        jacobian = cosines * ratio",
        ("jacobian-cosines-upside-down",),
    ),
    Mutant(
        "the Jacobian of the pixel's own sample",
        ("JC-09",),
        PIXELS,
        JACOBIAN_OF_NEIGHBOR,
        "own = take(self.frame.reservoirs.y, np.arange(len(self.rows)))\n"
        "        return self.q.shift(self.x.position, self.q.points.position, own)",
    ),
    Mutant(
        "the Jacobian from the receiver to itself",
        ("JC-09", "TR-03"),
        PIXELS,
        JACOBIAN_OF_NEIGHBOR,
        JACOBIAN_OF_NEIGHBOR.replace("self.x.position", "self.q.points.position"),
        ("jacobian-omitted",),
    ),
    *(
        Mutant(
            f"the Jacobian is clamped to {words}",
            ("JC-11",),
            SHIFT,
            LIMITED,
            f"return np.clip(saturate(jacobian), {words})",
            (name,),
        )
        for words, name in (
            ("1 / 3, 3", "jacobian-clamped-to-3"),
            ("1 / 2, 2", "jacobian-clamped-to-2"),
            ("0, 8", "jacobian-at-most-8"),
            ("0, 10", "jacobian-at-most-10"),
        )
    ),
    Mutant(
        "shifts beyond [1/10, 10] are refused, and counted",
        ("JC-12",),
        SHIFT,
        LIMITED,
        "J = saturate(jacobian)\n    return np.where((J >= 0.1) & (J <= 10), J, 0)",
        ("jacobian-rejected-beyond-10",),
    ),
    Mutant(
        "shifts beyond 2 are refused, and counted",
        ("JC-12",),
        SHIFT,
        LIMITED,
        "J = saturate(jacobian)\n    return np.where(J <= 2, J, 0)",
        ("jacobian-rejected-beyond-2",),
    ),
    Mutant(
        "shifts beyond [1/10, 10] are refused, and not counted",
        ("JC-12",),
        REUSED,
        SHIFTED,
        "R_n = replace(R_n, M=R_n.M * ((J >= 0.1) & (J <= 10)))\n    " + SHIFTED,
        ("jacobian-rejected-not-counted",),
    ),
    Mutant(
        "the cosines are left out",
        ("JC-15",),
        SHIFT,
        JACOBIAN,
        "jacobian = ratio * ratio",
        ("jacobian-without-cosines",),
    ),
    Mutant(
        "the cosines are cut at 0",
        ("EQ",),
        SHIFT,
        COSINES,
        "np.maximum(dot(n_sample, v_to), 0), np.maximum(dot(n_sample, v_from), 0)",
        ("jacobian-cut-at-the-back",),
        kind="equivalent",
    ),
    Mutant(
        "a Jacobian that overflows stays infinite",
        ("IS-19",),
        SHIFT,
        LIMITED,
        "return jacobian",
        kind="robustness",
    ),
]

INITIAL = [
    Mutant(
        "shading lacks 1/π",
        ("IS-01",),
        LAMBERTIAN,
        REFLECTED,
        "points.color * lit_cosine(table, points, wi)[:, None]",
        ("shade-without-pi",),
    ),
    Mutant(
        "the target lacks 1/π",
        ("IS-01", "EQ"),
        TARGET,
        SCALE,
        "scale = divide_or_zero(cosine, np.sqrt(dot(toward, toward)))",
        ("target-without-pi",),
        "equivalent",
    ),
    Mutant(
        "the geometry term in a target of solid angles",
        ("IS-05", "EQ"),
        TARGET,
        SCALE,
        "d2 = dot(toward, toward)\n"
        "    scale = divide_or_zero(cosine, np.pi * np.sqrt(d2))\n"
        "    scale = scale * divide_or_zero(abs(dot(y.normal, toward)),"
        " d2 * np.sqrt(d2))",
        ("target-with-geometry-term",),
        "variance",
    ),
    Mutant(
        "the geometry term in the estimate",
        ("IS-05",),
        TARGET,
        "value = scattering(table, receiver, omega) * y.radiance",
        "v = y.position - receiver.position\n"
        "    d2 = np.maximum(dot(v, v), 1e-12)\n"
        "    value = scattering(table, receiver, omega) * y.radiance\n"
        "    value = value * (abs(dot(y.normal, omega)) / d2)[:, None]",
        ("shade-with-geometry-term",),
    ),
    Mutant(
        "a uniform pdf of 1/π",
        ("IS-13",),
        SAMPLING,
        UNIFORM,
        "np.where(cos_theta >= 0, 1.0 / np.pi, 0.0)",
        ("density-of-half-the-hemisphere",),
    ),
    Mutant(
        "a uniform pdf of 1/4π",
        ("IS-13",),
        SAMPLING,
        UNIFORM,
        "np.where(cos_theta >= 0, 1.0 / (4.0 * np.pi), 0.0)",
        ("density-of-the-sphere",),
    ),
    Mutant(
        "a cosine pdf without 1/π",
        ("IS-01", "IS-13"),
        SAMPLING,
        COSINE_PDF,
        "np.maximum(cos_theta, 0.0)",
        ("density-without-pi",),
    ),
    Mutant(
        "a cosine pdf with 1/2π",
        ("IS-13",),
        SAMPLING,
        COSINE_PDF,
        "np.maximum(cos_theta, 0.0) / (2.0 * np.pi)",
        ("density-of-two-pi",),
    ),
    Mutant(
        "uniform directions with the cosine pdf",
        ("IS-13",),
        SAMPLING,
        UNIFORM,
        "np.maximum(cos_theta, 0.0) / np.pi",
        ("density-of-the-other-sampler",),
    ),
    Mutant(
        "cosine directions with the uniform pdf",
        ("IS-13",),
        SAMPLING,
        COSINE_PDF,
        "np.where(cos_theta > 0, 1.0 / (2.0 * np.pi), 0.0)",
        ("uniform-density-for-cosine",),
    ),
    Mutant(
        "cosine directions for uniform ones",
        ("IS-13",),
        SAMPLING,
        UNIFORM_SAMPLE,
        COSINE_SAMPLE,
        ("directions-always-cosine",),
    ),
    Mutant(
        "uniform directions for cosine ones",
        ("IS-13",),
        SAMPLING,
        COSINE_SAMPLE,
        UNIFORM_SAMPLE,
        ("directions-always-uniform",),
    ),
    Mutant(
        "the root of cos θ is forgotten",
        ("IS-13",),
        SAMPLING,
        COSINE_SAMPLE,
        "_about_z(1.0 - u1, np.sqrt(u1 * (2.0 - u1)), u2)",
        ("direction-root-forgotten",),
    ),
    Mutant(
        "half of the azimuths are drawn",
        ("IS-13",),
        SAMPLING,
        PHI,
        "phi = np.pi * u\n",
        ("half-of-the-azimuths",),
    ),
    Mutant(
        "one number for both components of a direction",
        ("IS-25",),
        SAMPLING,
        UNIFORM_SAMPLE,
        UNIFORM_SAMPLE.replace("u2", "u1"),
        ("one-number-for-both-components",),
        also=((SAMPLING, COSINE_SAMPLE, COSINE_SAMPLE.replace("u2", "u1")),),
    ),
    Mutant(
        "a frame that is not orthonormal below z = 0",
        ("IS-13",),
        FRAMES,
        "tangent = vectors(1.0 + sign * x * x * a, sign * b, -sign * x)",
        "tangent = vectors(1.0 + x * x * a, sign * b, -sign * x)",
    ),
    Mutant(
        "the normal points inward",
        ("IS-13",),
        FRAMES,
        "x * tangent + y * bitangent + z * n",
        "x * tangent + y * bitangent - z * n",
        ("normal-points-inward",),
    ),
    Mutant(
        "a new sample is not divided by its density",
        ("IS-13",),
        RESERVOIR,
        "w = divide_or_zero(p_hat, pdf)",
        "w = p_hat",
        ("density-left-out",),
    ),
    Mutant(
        "a new sample is multiplied by its density",
        ("IS-13",),
        RESERVOIR,
        "w = divide_or_zero(p_hat, pdf)",
        "w = p_hat * pdf",
        ("density-multiplied",),
    ),
    Mutant(
        "a new sample's density is that of another pixel",
        ("IS-13",),
        TEMPORAL,
        NEW,
        "from numpy import roll\n\n    "
        + NEW.replace("initial.pdf", "roll(initial.pdf, 1)"),
    ),
    Mutant(
        "a draw too many: the first is not counted",
        ("IS-17",),
        MIS,
        "return _sum(M_k)",
        "return _sum(M_k[1:])",
        ("first-not-counted",),
    ),
    Mutant(
        "new samples that found nothing do not count",
        ("§0", "RG-01", "RG-07"),
        RESERVOIR,
        FRESH,
        "w=saturate(w), M=M * (w > 0))",
        ("nulls-not-counted",),
    ),
    Mutant(
        "a weight of 0 may be kept",
        ("IS-19", "EQ"),
        RESERVOIR,
        CHOICE,
        "u * (w_a + w_b) <= w_b)",
        ("accepts-on-equality",),
        "robustness",
    ),
    Mutant(
        "0/0 when a reservoir is closed",
        ("IS-19",),
        RESERVOIR,
        CLOSED,
        "c.w / c.p_hat / normalization",
        (),
        "robustness",
        ((RESERVOIR, KEPT, "return Reservoirs(y=c.y, W=W, M=c.M)"),),
    ),
    Mutant(
        "the back of a sample shines, in the target alone",
        ("IS-21",),
        TARGET,
        FACES,
        "dot(y.normal, toward) != 0, lit_cosine",
        ("back-of-sample-shines", "back-left-to-the-jacobian"),
        "variance",
    ),
    Mutant(
        "the back of a sample shines",
        ("IS-21",),
        TARGET,
        FACES,
        "dot(y.normal, toward) != 0, lit_cosine",
        (
            "back-of-sample-shines",
            "back-left-to-the-jacobian",
            "shade-back-of-sample",
        ),
        "bias",
        ((TARGET, SIDE, "lit = dot(y.normal, omega) != 0"),),
    ),
    Mutant(
        "the back of a sample shines, in shading alone",
        ("IS-21",),
        TARGET,
        SIDE,
        "lit = dot(y.normal, omega) != 0",
        ("shade-back-of-sample",),
        "equivalent",
    ),
    Mutant(
        "the throughput is in L_o, and applied again",
        ("IS-23",),
        SHADE,
        SHOWN,
        "return radiance * points.color * reservoirs.W[:, None]",
        ("shade-albedo-twice",),
    ),
    Mutant(
        "one number for all neighbours",
        ("IS-25",),
        SPATIAL,
        LOOP,
        "for q_n, u_n in [(n, neighbors[0][1]) for n, _ in neighbors]:",
        ("one-number-for-all-neighbors",),
    ),
    Mutant(
        "one number for all decisions",
        ("IS-25",),
        SPATIAL,
        LOOP,
        "for q_n, u_n in [(n, u_own) for n, _ in neighbors]:",
        ("one-number-for-all-decisions",),
    ),
    Mutant(
        "pure colours are taken for nothing, in the target",
        ("IS-27",),
        TARGET,
        LIGHT,
        "color = receiver.color * y.radiance\n"
        "    return np.where((color > 0).all(axis=1), luminance(color), 0.0) * scale",
        ("pure-colours-are-null",),
    ),
    Mutant(
        "pure colours are taken for nothing, in shading",
        ("IS-27",),
        TARGET,
        SIDE,
        "lit = (dot(y.normal, omega) < 0) & (y.radiance > 0).all(axis=1)",
        ("shade-pure-colours-black",),
    ),
    Mutant(
        "what a pure colour reflects is taken for nothing",
        ("IS-27",),
        TARGET,
        "return np.where(lit[:, None], value, 0.0)",
        "lit = lit & (value > 0).all(axis=1)\n"
        "    return np.where(lit[:, None], value, 0.0)",
        ("shade-pure-reflections-black",),
    ),
]

REUSE = [
    Mutant(
        "M is capped, and the running weight is not",
        ("TR-01",),
        RESERVOIR,
        CAP,
        "W=r.W * divide_or_zero(r.M, np.minimum(r.M, cap)), M=np.minimum(r.M, cap)",
        ("capped-before-weight", "running-weight-kept"),
    ),
    Mutant(
        "M is capped before it divides",
        ("TR-01",),
        SPATIAL,
        CLOSE_S,
        "Z = Z * (Z <= cap) + cap * (Z > cap)\n    " + CLOSE_S,
        ("capped-before-weight",),
        also=((TEMPORAL, CLOSE, "Z = Z * (Z <= cap) + cap * (Z > cap)\n    " + CLOSE),),
    ),
    Mutant(
        "M is capped in the weight alone",
        ("TR-01", "SR-10"),
        RESERVOIR,
        WEIGHT,
        "w = p_hat * r.W * np.minimum(r.M, 2)",
    ),
    Mutant(
        "the cap is put on W",
        ("TR-01",),
        RESERVOIR,
        CAP,
        "W=r.W * divide_or_zero(np.minimum(r.M, cap), r.M), M=r.M",
    ),
    Mutant(
        "M is not capped",
        ("EQ",),
        RESERVOIR,
        CAP,
        "W=r.W, M=r.M",
        ("never-capped",),
        "equivalent",
    ),
    Mutant(
        "the cap is one too large",
        ("EQ",),
        RESERVOIR,
        CAP,
        "W=r.W, M=np.minimum(r.M, cap + 1)",
        ("cap-off-by-one",),
        "equivalent",
    ),
    Mutant(
        "the past is capped when it arrives, not when it is stored",
        ("EQ",),
        RESERVOIR,
        CAP,
        "W=r.W, M=r.M",
        ("never-capped", "capped-on-arrival"),
        "equivalent",
        (
            (
                TEMPORAL,
                PAST,
                "from numpy import minimum\n\n    "
                f"{REPLACE}if not ({MOVES}):\n"
                "        past = replace(past, M=minimum(past.M, cap))\n    " + PAST,
            ),
            (
                SPATIAL,
                PAST_S,
                "from numpy import minimum\n\n    "
                f"{REPLACE}past = replace(past, M=minimum(past.M, cap))\n"
                "    own = replace(own, M=minimum(own.M, cap))\n    " + PAST_S,
            ),
        ),
    ),
    Mutant(
        "no temporal Jacobian when the visible point moves",
        ("TR-03",),
        TEMPORAL,
        PAST,
        f"{REPLACE}if {MOVES}:\n"
        "        def one(x_from, x_to, y):\n"
        "            return x_from[:, 0] * 0 + 1\n\n"
        "        past = replace(past, q=replace(past.q, shift=one))\n    " + PAST,
        ("jacobian-omitted",),
    ),
    Mutant(
        "what moved is reused as it stands",
        ("TR-03", "TR-19"),
        TEMPORAL,
        PAST,
        f"if {MOVES}:\n        past = past.reservoirs\n    " + PAST,
        ("reused-as-it-stands",),
    ),
    Mutant(
        "bright samples are taken for fireflies",
        ("TR-07",),
        RESERVOIR,
        WEIGHT,
        "w = p_hat * r.W * r.M * (r.W < 10)",
        ("dropped-where-w-large",),
    ),
    Mutant(
        "a new sample counts twice",
        ("TR-17",),
        RESERVOIR,
        FRESH,
        "w=saturate(w), M=M * 2)",
        ("confidence-off-by-one",),
    ),
    Mutant(
        "M is one too large in the weight",
        ("TR-17",),
        RESERVOIR,
        WEIGHT,
        "w = p_hat * r.W * (r.M + 1)",
        ("confidence-plus-one-in-weight",),
    ),
    Mutant(
        "an empty history counts as a sample",
        ("TR-21",),
        RESERVOIR,
        BROUGHT,
        "return Candidates(y=r.y, p_hat=p_hat, w=w, M=np.maximum(r.M, 1))",
        ("empty-counts",),
    ),
    Mutant(
        "1/M where 1/Z is needed",
        ("SR-01", "EQ"),
        MIS,
        TERMS,
        "M for",
        ("one-over-m",),
    ),
    Mutant(
        "1/Z where 1/M is asked for",
        ("SR-01",),
        REUSED,
        'if mis == "1/M":',
        "if not mis:",
        ("one-over-z-where-m",),
        "equivalent",
    ),
    Mutant(
        "Z adds M of the last neighbour",
        ("SR-02",),
        MIS,
        TERMS,
        "np.where(holds, M_k[-1], M * 0) for",
        ("last-confidence-in-z",),
    ),
    Mutant(
        "Z counts reservoirs, not their samples",
        ("SR-02",),
        MIS,
        TERMS,
        "np.where(holds, M * 0 + 1, M * 0) for",
        ("one-each-in-z",),
    ),
    Mutant(
        "the pixel's own reservoir is counted with the merged M",
        ("SR-03",),
        REUSED,
        SUM_Z,
        "own = [isinstance(s, Candidates | Reservoirs) for s in Q]\n"
        "    M_k = [R.merged.M if k else M for k, M in zip(own, R.M, strict=True)]\n"
        "    return one_over_z(M_k, could_have_made(R, Q))",
        ("merged-confidence-in-z",),
        also=(
            (
                REUSED,
                SUM_M,
                "own = [isinstance(s, Candidates | Reservoirs) for s in Q]\n"
                "        M_k = [R.merged.M if k else M for k, M in zip(own, R.M)]\n"
                "        return one_over_m(M_k)",
            ),
        ),
    ),
    Mutant(
        "Z asks for light, not for the horizon",
        ("SR-05",),
        TARGET,
        "return " + NEIGHBOR_TARGET,
        "return y.radiance.max(axis=1)",
        ("horizon-missing-in-z",),
    ),
    Mutant(
        "Z does not ask on which side the sample shines",
        ("SR-05",),
        TARGET,
        NEIGHBOR_TARGET,
        "np.where(drawn, y.radiance.max(axis=1), 0.0)",
        ("side-missing-in-z",),
    ),
    Mutant(
        "Z does not ask for visibility",
        ("SR-05",),
        PIXELS,
        LOOKS,
        "return possible",
        ("visibility-missing-in-z",),
    ),
    Mutant(
        "Z asks what the receiver sees",
        ("SR-05",),
        PIXELS,
        LOOKS,
        "return self.q.sees(y, possible)",
        ("visibility-missing-in-z",),
    ),
    Mutant(
        "Z asks for the receiver's horizon",
        ("SR-05",),
        PIXELS,
        "table, surface = frame.world.materials, frame.visible.surface",
        "table, surface = frame.world.materials, self.q.points\n"
        "        rows = np.arange(len(surface))",
        ("receivers-target-in-z",),
    ),
    Mutant(
        "Z forgets who made the sample",
        ("SR-05",),
        REUSED,
        COULD,
        COULD.replace("made | ", ""),
        ("maker-missing-in-z",),
    ),
    Mutant(
        "a neighbour that was rejected still counts",
        ("SR-07",),
        PIXELS,
        AT_ROWS,
        "M=r.M)",
        ("rejected-counted",),
    ),
    Mutant(
        "W is divided by the target at the source",
        ("SR-09",),
        REUSED,
        SHIFTED,
        f"{TAKE}{SHIFTED}\n    c = replace(c, p_hat={AT_NEIGHBOR})",
        ("divided-by-the-donors-target",),
    ),
    Mutant(
        "the target at the source, in the weight too",
        ("SR-09",),
        REUSED,
        SHIFTED,
        TAKE + SHIFTED.replace("q.target(R_n.y)", AT_NEIGHBOR),
        ("donors-target-in-both",),
        "variance",
    ),
    Mutant(
        "M twice in the weight",
        ("SR-10",),
        RESERVOIR,
        WEIGHT,
        "w = p_hat * r.W * r.M * r.M",
        ("confidence-twice",),
    ),
    Mutant(
        "M is missing in the weight",
        ("SR-10",),
        RESERVOIR,
        WEIGHT,
        "w = p_hat * r.W",
        ("confidence-missing-in-weight",),
    ),
    Mutant(
        "divided by M twice",
        ("SR-10",),
        RESERVOIR,
        CLOSED,
        "divide_or_zero(divide_or_zero(c.w, c.p_hat), normalization * normalization)",
        ("normalized-twice",),
    ),
    Mutant(
        "neighbours are trusted twice",
        ("SR-10",),
        REUSED,
        SHIFTED,
        f"{SHIFTED}\n    c = replace(c, w=c.w * 2)",
        ("neighbors-counted-double",),
    ),
    Mutant(
        "the sum of weights is not divided by the confidences",
        ("SR-10",),
        RESERVOIR,
        CLOSED,
        "divide_or_zero(c.w, c.p_hat)",
        ("not-normalized",),
    ),
    Mutant(
        "W is not divided by the target",
        ("SR-09",),
        RESERVOIR,
        CLOSED,
        "divide_or_zero(c.w, normalization)",
        ("not-divided-by-target",),
    ),
    Mutant(
        "the target is missing in the weight",
        ("SR-09",),
        RESERVOIR,
        WEIGHT,
        "w = r.W * r.M",
        ("target-missing-in-weight",),
    ),
    Mutant(
        "the target is kept away from 0 where it divides",
        ("§0",),
        RESERVOIR,
        CLOSED,
        "divide_or_zero(np.maximum(c.p_hat, 1e-3) ** -1 * c.w, normalization)",
        ("divisor-at-least-0.001",),
    ),
    *(
        Mutant(
            f"W is cut at {most}",
            ("§0",),
            RESERVOIR,
            KEPT,
            f"return Reservoirs(y=c.y, W=np.minimum(saturate(W), {most}), M=c.M)",
            (f"weight-cut-at-{most}",),
        )
        for most in (4, 10)
    ),
    Mutant(
        "a neighbour outside of the image is pixel 0",
        ("SR-13",),
        PIXELS,
        "return replace(r, W=np.where(there, r.W, 0.0), M=np.where(there, r.M, 0.0))",
        "return r",
        ("rejected-counted",),
        # Nobody was asked whether its sample is seen: it is hidden, and counts.
        also=((REUSED, SEEN, "seen = q.sees(R_n.y, (c.w > 0) & (q_n.rows >= 0))"),),
    ),
    Mutant(
        "the second loop replays other neighbours",
        ("SR-15",),
        REUSED,
        COULD,
        "other = Q[slot - 1]\n"
        "            is_own = isinstance(other, Candidates | Reservoirs)\n"
        "            other = q_n if is_own else other\n            "
        + COULD.replace("q_n.", "other."),
    ),
    Mutant(
        "light below the horizon",
        ("SR-21",),
        COSINE,
        LIT_COSINE,
        "cosine = abs(dot(points.shading, wi))",
        ("light-below-the-horizon",),
    ),
    Mutant(
        "light below the horizon, in the target alone",
        ("SR-21",),
        TARGET,
        "lit_cosine(table, receiver, toward), 0.0",
        "abs(dot(receiver.normal, toward)), 0.0",
        ("light-below-the-horizon",),
        "variance",
    ),
    Mutant(
        "Equation 10 does not ask for the horizon",
        ("SR-05", "SR-21"),
        TARGET,
        OUTGOING,
        OUTGOING.replace("cosine > 0", "dot(y.normal, toward) < 0"),
        ("outgoing-without-horizon",),
        "variance",
    ),
    Mutant(
        "hidden samples keep their weight",
        ("SR-21", "SR-33"),
        REUSED,
        SEEN,
        "seen = c.w > 0",
        ("visibility-missing-in-weight",),
    ),
    Mutant(
        "samples that arrive with no weight do not count",
        ("SR-25",),
        REUSED,
        OFFERED,
        OFFERED.replace("return", "c =") + "\n    return replace(c, M=c.M * (c.w > 0))",
        ("reused-nulls-not-counted",),
        "bias",
        (
            (
                REUSED,
                "return reused_candidates(source, q.target(source.y))",
                "c = reused_candidates(source, q.target(source.y))\n"
                "        return replace(c, M=c.M * (c.w > 0))",
            ),
        ),
    ),
    Mutant(
        "samples with no target do not count, hidden ones do",
        ("SR-25",),
        RESERVOIR,
        BROUGHT,
        "return Candidates(y=r.y, p_hat=p_hat, w=w, M=r.M * (w > 0))",
        ("reused-nulls-not-counted",),
    ),
    Mutant(
        "hidden samples do not count",
        ("SR-25",),
        REUSED,
        SEEN,
        "seen = q.sees(R_n.y, c.M > 0)\n    c = replace(c, M=c.M * seen)",
        ("hidden-not-counted",),
    ),
    Mutant(
        "hidden samples with a weight do not count",
        ("SR-25",),
        REUSED,
        SEEN,
        f"{SEEN}\n    c = replace(c, M=c.M * ~((c.w > 0) & ~seen))",
        ("hidden-lights-not-counted",),
    ),
    Mutant(
        "the pixel's own sample is not merged",
        ("SR-31",),
        SPATIAL,
        OWN_S,
        f"{REPLACE}own = replace(own, W=own.W * 0, M=own.M * 0)\n    {OWN_S}",
        ("canonical-not-merged",),
        also=(
            (
                TEMPORAL,
                MERGED,
                f"{REPLACE}if {MOVES}:\n"
                f"        new = replace(new, w=new.w * 0, M=new.M * 0)\n    {MERGED}",
            ),
        ),
    ),
    Mutant(
        "the pixel's own sample is not counted in Z",
        ("SR-31",),
        REUSED,
        EVERYONE,
        f"{EVERYONE}\n"
        "    if not all(isinstance(s, Candidates | Reservoirs) for s in Q):\n"
        "        could[1] = ~could[1]",
        ("canonical-missing-in-z",),
    ),
    Mutant(
        "M of a merged reservoir is one more",
        ("TR-17", "SR-10"),
        RESERVOIR,
        "M = a.M + b.M",
        "M = a.M + 1",
    ),
    Mutant(
        "the sum of weights forgets what came before",
        ("IN-03",),
        RESERVOIR,
        "w = a.w + b.w",
        "w = b.w",
        ("sum-of-weights-lost",),
    ),
    Mutant(
        "the target of the sample that lost",
        ("SR-09",),
        RESERVOIR,
        "np.where(take_b, b.p_hat, a.p_hat)",
        "a.p_hat",
        ("target-of-the-first",),
    ),
    Mutant(
        "the sample that won is not copied",
        ("IN-03",),
        RESERVOIR,
        "where(take_b, b.y, a.y)",
        "a.y",
    ),
    Mutant(
        "what came first stays",
        ("IS-25",),
        RESERVOIR,
        CHOICE,
        "w_b < 0)",
        ("never-accepts",),
    ),
    Mutant(
        "every candidate with a weight is kept",
        ("IS-25",),
        RESERVOIR,
        CHOICE,
        "w_b > 0)",
        ("always-accepts",),
    ),
    Mutant(
        "compared with the sum before",
        ("IS-19",),
        RESERVOIR,
        CHOICE,
        "u * w_a < w_b)",
        ("accepts-by-the-old-sum",),
    ),
    Mutant(
        "u is used as 1 − u",
        ("EQ",),
        RESERVOIR,
        CHOICE,
        "(1 - u) * (w_a + w_b) < w_b)",
        ("keeps-the-other-side", "reuse-u-turned"),
        "equivalent",
    ),
    Mutant(
        "the stream runs backwards",
        ("EQ",),
        SPATIAL,
        PAST_S,
        "us = [u_own, *(u_n for _, u_n in neighbors)]\n"
        "    backwards = [*(n for n, _ in neighbors[::-1]), own, past]\n"
        "    R_s = begin(reused(q, backwards[0]))",
        ("stream-reversed",),
        "equivalent",
        (
            (SPATIAL, OWN_S, ""),
            (SPATIAL, "= [past, own]", "= backwards[:1]"),
            (SPATIAL, LOOP, "for q_n, u_n in zip(backwards[1:], us, strict=True):"),
            (
                SPATIAL,
                "R_s.then(shifted(q, q_n), u_n)",
                "R_s.then(reused(q, q_n), u_n)",
            ),
            (TEMPORAL, MERGED, "R = begin(new).then(reused(q, past), u)"),
            (TEMPORAL, "[past, new]", "[new, past]"),
        ),
    ),
]

TARGETS = [
    Mutant(
        f"the target {words}",
        ("EQ",),
        TARGET,
        old,
        new,
        expected,
        "equivalent",
    )
    for words, old, new, expected in (
        ("is twice as large", LIGHT, f"{LIGHT} * 2.0", ("target-doubled",)),
        (
            "lacks the cosine",
            SCALE,
            "scale = ((cosine > 0) / np.pi).astype(cosine.dtype)",
            ("target-without-cosine",),
        ),
        (
            "has the cosine twice",
            SCALE,
            f"{SCALE}\n    scale = scale * scale * np.pi",
            ("target-cosine-twice",),
        ),
        (
            "lacks the albedo",
            LIGHT,
            "return luminance(y.radiance) * scale",
            ("target-without-albedo",),
        ),
        (
            "has the luminance of Rec. 601",
            LUMINANCE,
            "dot(color, np.array((0.299, 0.587, 0.114), color.dtype))",
            ("luminance-of-rec-601", "filters-by-rec-601"),
        ),
        (
            "is the mean of the channels",
            LUMINANCE,
            "color.mean(axis=1)",
            ("mean-of-channels", "filters-by-the-mean-of-channels"),
        ),
        (
            "is the largest of the channels",
            LUMINANCE,
            "color.max(axis=1)",
            ("largest-channel", "filters-by-the-largest-channel"),
        ),
        (
            "has a floor where it is positive",
            LIGHT,
            "p_hat = luminance(receiver.color * y.radiance) * scale\n"
            "    return np.where(p_hat > 0, np.maximum(p_hat, 1e-3), p_hat)",
            ("scattered-at-least-0.001",),
        ),
        (
            "is Equation 9 where 10 is asked for",
            'if kind == "outgoing":',
            'if kind == "other":',
            ("target-always-scattered",),
        ),
    )
] + [
    Mutant(
        "the target is the red channel",
        ("IS-27",),
        TARGET,
        LUMINANCE,
        "color[:, 0]",
        ("red-channel",),
    )
]

SHADING = [
    Mutant(
        f"shading {words}",
        ids,
        module,
        old,
        new,
        expected,
    )
    for words, ids, module, old, new, expected in (
        (
            "lacks the albedo",
            ("IS-23",),
            LAMBERTIAN,
            REFLECTED,
            REFLECTED.replace("points.color", "(points.color * 0 + 1)"),
            ("shade-without-albedo",),
        ),
        (
            "lacks the cosine",
            ("SR-05",),
            LAMBERTIAN,
            REFLECTED,
            REFLECTED.replace("wi) / np.pi)", "wi) > 0)") + " / np.pi",
            ("shade-without-cosine",),
        ),
        (
            "has the cosine twice",
            ("IS-05",),
            LAMBERTIAN,
            REFLECTED,
            REFLECTED.replace("wi) / np.pi", "wi) ** 2 / np.pi"),
            ("shade-cosine-twice",),
        ),
        (
            "shows the target",
            ("IS-27", "PK-13"),
            SHADE,
            SHOWN,
            "from restir_gi.reference.resampling.target import target\n"
            '    p = target("scattered", world.materials, points, reservoirs.y)\n'
            "    return (radiance * 0 + p[:, None]) * reservoirs.W[:, None]",
            ("shade-by-the-target",),
        ),
        (
            "lacks W",
            ("SR-09",),
            SHADE,
            SHOWN,
            "return radiance",
            ("shade-without-weight",),
        ),
    )
]

SEARCH = [
    Mutant(
        name,
        ids,
        module,
        old,
        new,
        expected,
        "variance",
    )
    for name, ids, module, old, new, expected in (
        (
            "the depth test is relative to the pixel's own depth",
            ("SR-19",),
            GBUFFER,
            "max_depth * far)",
            "max_depth * depth_a)",
            ("depth-relative-to-own", "place-depth-relative-to-own"),
        ),
        (
            "a fixed depth difference",
            ("SR-19",),
            GBUFFER,
            "max_depth * far)",
            "max_depth)",
            (),
        ),
        (
            "no test of depths",
            ("SR-19", "TR-19"),
            GBUFFER,
            ALIKE,
            "alike & (near > 0)",
            (),
        ),
        (
            "no test of normals",
            ("SR-19", "TR-19"),
            GBUFFER,
            ALIKE,
            ALIKE.replace("alike & ", ""),
            (),
        ),
        (
            "degrees are taken for radians",
            ("IN-05",),
            GBUFFER,
            ANGLE,
            "dot(n_a, n_b) >= np.cos(max_angle)",
            (),
        ),
        (
            "the angle is a constant of 25.84 degrees",
            ("IN-05",),
            GBUFFER,
            ANGLE,
            "dot(n_a, n_b) >= 0.9",
            (),
        ),
        (
            "normals may point away",
            ("SR-19",),
            GBUFFER,
            ANGLE,
            "abs(dot(n_a, n_b)) >= np.cos(np.radians(max_angle))",
            (),
        ),
        (
            "the search radius is not halved",
            ("SR-19",),
            NEIGHBORS,
            "np.maximum(radius / 2.0, least)",
            "radius",
            ("radius-not-halved",),
        ),
        (
            "the search radius has no least",
            ("SR-19",),
            NEIGHBORS,
            "np.maximum(radius / 2.0, least)",
            "radius / 2.0",
            (),
        ),
        (
            "the disk is dense in its middle",
            ("SR-19",),
            NEIGHBORS,
            "radius * np.sqrt(u[0])",
            "radius * u[0]",
            (),
        ),
        (
            "offsets are rounded down",
            ("TR-05",),
            NEIGHBORS,
            "dx, dy = np.rint(r * np.cos(phi)), np.rint(r * np.sin(phi))",
            "dx, dy = np.trunc(r * np.cos(phi)), np.trunc(r * np.sin(phi))",
            (),
        ),
        (
            "neighbours outside are moved to the border",
            ("SR-13",),
            NEIGHBORS,
            LANDS,
            "x_to = np.clip(x + dx, 0, width - 1)\n"
            "        y_to = np.clip(y + dy, 0, height - 1)",
            (),
        ),
        (
            "the pixel is its own neighbour",
            ("SR-13",),
            NEIGHBORS,
            "np.where(usable & (neighbor != rows), neighbor, NONE)",
            "np.where(usable, neighbor, NONE)",
            (),
        ),
    )
] + [
    Mutant(
        "a neighbour may be one column outside",
        ("SR-13",),
        NEIGHBORS,
        "(x_to < width)",
        "(x_to <= width)",
        (),
        "robustness",
    ),
    Mutant(
        "what sees nothing is similar to all",
        ("TR-21",),
        GBUFFER,
        ALIKE,
        ALIKE.replace("(near > 0) & ", ""),
        (),
        "robustness",
    ),
]

RANDOM = [
    Mutant(
        "the key's last word is ignored: one stream for all passes",
        ("IN-01",),
        RNG,
        "for v in (x, y, z, w))\n    for last_round",
        "for v in (x, y, z, w * np.uint32(0)))\n    for last_round",
        ("stream-ignored",),
    ),
    Mutant(
        "the frame is ignored",
        ("IN-01",),
        RNG,
        "for v in (x, y, z, w))\n    for last_round",
        "for v in (x, y * np.uint32(0), z, w))\n    for last_round",
        ("frame-ignored", "roulette-stands-still"),
    ),
    Mutant(
        "another shift in the hash",
        ("EQ",),
        RNG,
        "v >> np.uint32(16)",
        "v >> np.uint32(15)",
        kind="equivalent",
    ),
    Mutant(
        "numbers that round to 1",
        ("IS-19",),
        RNG,
        "(bits >> np.uint32(8)) * 2.0**-24",
        "bits * 2.0**-32",
        kind="robustness",
    ),
]

UNSEEN = [
    Mutant(
        name,
        ("EQ",),
        module,
        old,
        new,
        kind="equivalent",
    )
    for name, module, old, new in (
        (
            "azimuths are counted from another axis",
            SAMPLING,
            PHI,
            "phi = (2.0 * np.pi) * u + 1.0\n",
        ),
        (
            "azimuths are counted the other way round",
            SAMPLING,
            PHI,
            "phi = (-2.0 * np.pi) * u\n",
        ),
        (
            "the Jacobian in another order",
            SHIFT,
            JACOBIAN,
            "jacobian = cosines * (ratio * (ratio * ratio))",
        ),
        (
            "the weight in another order",
            RESERVOIR,
            WEIGHT,
            "w = r.M * (r.W * p_hat)",
        ),
        (
            "the choice with its terms apart",
            RESERVOIR,
            CHOICE,
            "u * w_a < (1 - u) * w_b)",
        ),
        (
            "the choice by division",
            RESERVOIR,
            CHOICE,
            "u < divide_or_zero(w_b, w_a + w_b))",
        ),
        (
            "divided by Z before the target",
            RESERVOIR,
            CLOSED,
            "divide_or_zero(divide_or_zero(c.w, normalization), c.p_hat)",
        ),
        (
            "merged in the other order of terms",
            RESERVOIR,
            "w = a.w + b.w",
            "w = b.w + a.w",
        ),
        (
            "relative depth by division",
            GBUFFER,
            "far - near <= max_depth * far",
            "near >= (1 - max_depth) * far",
        ),
    )
] + [
    Mutant(
        "cos² θ is u",
        ("EQ",),
        SAMPLING,
        COSINE_SAMPLE,
        "_about_z(np.sqrt(u1), np.sqrt(1.0 - u1), u2)",
        ("cosine-directions-from-the-other-end",),
        "equivalent",
    )
]

MUTANTS = [
    *JACOBIANS,
    *INITIAL,
    *REUSE,
    *TARGETS,
    *SHADING,
    *SEARCH,
    *RANDOM,
    *UNSEEN,
]

NOTHING = Mutant(
    "nothing at all",
    (),
    RESERVOIR,
    WEIGHT,
    "w = p_hat * r.W * r.M  # nothing",
    kind="equivalent",
)
"""A planted edit that is none: whatever sees it sees the planting."""

BY_NAME = {mutant.name: mutant for mutant in MUTANTS}
