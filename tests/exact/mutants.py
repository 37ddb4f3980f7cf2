"""Mistakes to plant: the text of a kernel or of a pass, with a line changed.

Each entry is a mistake that somebody made, or nearly made: in a paper, a note, or a
renderer.  It is planted in the running production code by :mod:`tests.mutants.plant`;
``killed_by`` names claims of :mod:`tests.exact.claims` that refute it.
"""

from dataclasses import dataclass

from tests.exact import claims
from tests.mutants.catalogue import AT_NEIGHBOR, TAKE
from tests.mutants.plant import planted

RESERVOIR = "restir_gi.reference.resampling.reservoir"
MIS = "restir_gi.reference.resampling.reservoir"
PAIRWISE = "restir_gi.reference.resampling.pairwise"
SHIFT = "restir_gi.reference.resampling.shift"
REUSE = "restir_gi.reference.resampling.reuse"
ENGINE = "restir_gi.reference.resampling.generalized"
TEMPORAL = "restir_gi.reference.passes.temporal"
SPATIAL = "restir_gi.reference.passes.spatial"
PIXELS = "restir_gi.reference.passes.pixels"
MOTION = "restir_gi.reference.options.motion"
FUSED = "restir_gi.reference.options.fused"
WEIGHTS = "restir_gi.reference.options.weights"
LOOP = "restir_gi.reference.restir_gi"


@dataclass(frozen=True, slots=True)
class ExactMutant:
    """Edits of modules: ``old`` occurs once in its module and becomes ``new``."""

    name: str
    module: str
    old: str
    new: str
    killed_by: tuple[str, ...] = ()
    also: tuple[tuple[str, str, str], ...] = ()

    @property
    def edits(self):
        """All edits."""
        return ((self.module, self.old, self.new), *self.also)


def fractions_in(module):
    """Edit that makes fractions known to a module."""
    imports = "import numpy as np\n"
    return module, imports, f"{imports}from fractions import Fraction\n"


def is_refuted(mutant, claim):
    """Whether a claim, true of the code, finds a fault in the mutant."""
    with planted(mutant):
        return next(claim(), None) is not None


HIDDEN = "return replace(c, w=np.where(seen, c.w, c.w * 0))"
ASKED = "possible = asked & self.supports(y)"
LOOKED = "return sees(self.frame.world, self.x, y, possible)"
REFUSED = "~self.q.refuses(self.x.position, x_q, y)"
OTHER_WAY = "~self.q.refuses(x_q, self.x.position, y)"
COULD = "could = [np.ones(len(full), bool)] * len(Q)"
MAKER = "could[slot] = made | q_n.could_make(R.kept.y, full & ~made)"
CLOSED = "return cap_confidence(finalize(R_s.kept, Z), cap)"
ARRIVED = "c = reused_candidates(R_n, q.target(R_n.y), J)"
STREAMED = "R_s = R_s.then(shifted(q, q_n), u_n)"
PAST = "R_s = begin(reused(q, past))"
MADE = "target(made) / candidate.jacobian[at]"
THERE = "target(value) * jacobian, len(p_hat)"
OWN = "weighted = [_with_weight(canonical, m)]"
DONOR = "pairwise_neighbor(M, made, c.M, k.weighted.p_hat, S, defensive)"
DONORS = "S = one_over_m(M_k)"

MUTANTS = [
    # The Jacobian.
    ExactMutant(
        "the Jacobian is left out",
        RESERVOIR,
        "w = w * jacobian",
        "w = w * 1",
        ("spatial_pass", "balance_pass"),
    ),
    ExactMutant(
        "the weight is divided by the Jacobian",
        RESERVOIR,
        "w = w * jacobian",
        "w = divide_or_zero(w, jacobian)",
        ("spatial_pass", "balance_pass"),
    ),
    ExactMutant(
        "the Jacobian is clamped to [1/3, 3]",
        SHIFT,
        "return saturate(jacobian)",
        "return np.minimum(np.maximum(jacobian, Fraction(1, 3)), 3)",
        ("spatial_pass",),
        also=(fractions_in(SHIFT),),
    ),
    ExactMutant(
        "the distances are not squared",
        SHIFT,
        "cosines * ratio * ratio * ratio",
        "cosines * ratio * ratio",
        ("spatial_pass",),
    ),
    ExactMutant(
        "the cosines are left out",
        SHIFT,
        "cosines * ratio * ratio * ratio",
        "ratio * ratio",
        ("spatial_pass",),
    ),
    ExactMutant(
        "the cosines are upside down",
        SHIFT,
        "abs(dot(n_sample, v_to)), abs(dot(n_sample, v_from))",
        "abs(dot(n_sample, v_from)), abs(dot(n_sample, v_to))",
        ("spatial_pass",),
    ),
    ExactMutant(
        "source and receiver change places",
        PIXELS,
        "self.q.shift(self.x.position, self.q.points.position, self.reservoirs.y)",
        "self.q.shift(self.q.points.position, self.x.position, self.reservoirs.y)",
        ("spatial_pass", "balance_pass", "fused_pass"),
    ),
    # Confidence.
    ExactMutant(
        "new samples that found nothing do not count",
        RESERVOIR,
        "M = np.ones_like(w) if M is None else M",
        "M = np.where(w > 0, w * 0 + 1, w * 0)",
        ("several_candidates", "temporal_chain"),
    ),
    ExactMutant(
        "neighbours whose sample is hidden do not count",
        REUSE,
        HIDDEN,
        "return replace(\n"
        "        c, w=np.where(seen, c.w, c.w * 0), M=np.where(seen, c.M, c.M * 0)\n"
        "    )",
        ("spatial_pass", "fused_pass", "moved_temporal_pass", "moved_sources_pass"),
    ),
    ExactMutant(
        "M of a merged reservoir is 1",
        RESERVOIR,
        "M = a.M + b.M",
        "M = a.M + 1",
        ("spatial_pass",),
    ),
    ExactMutant(
        "M of the reservoir is missing in its weight",
        RESERVOIR,
        "w = p_hat * r.W * r.M",
        "w = p_hat * r.W",
        ("spatial_pass", "temporal_chain"),
    ),
    # The cap.
    ExactMutant(
        "M is capped before it divides",
        TEMPORAL,
        "Z = normalization(mis, R, [past, new])",
        "Z = normalization(mis, R, [past, new]).clip(max=cap)",
        ("temporal_chain",),
    ),
    ExactMutant(
        "the running weight outlives the cap",
        RESERVOIR,
        "W=r.W, M=np.minimum(r.M, cap)",
        "W=r.W * r.M / np.minimum(r.M, cap), M=np.minimum(r.M, cap)",
        ("temporal_chain",),
    ),
    ExactMutant(
        "the cap is put on the weight",
        RESERVOIR,
        "W=r.W, M=np.minimum(r.M, cap)",
        "W=r.W * np.minimum(r.M, cap) / r.M, M=r.M",
        ("temporal_chain",),
    ),
    ExactMutant(
        "M is capped at every pass",
        REUSE,
        "return [c.M for c in self.candidates]",
        "return [np.minimum(c.M, 2) for c in self.candidates]",
        ("spatial_pass",),
    ),
    # The choice.
    ExactMutant(
        "chosen by the ratio to the old sum",
        RESERVOIR,
        "u * (w_a + w_b) < w_b",
        "u * w_a < w_b",
        (
            "several_candidates",
            "temporal_chain",
            "spatial_pass",
            "one_law_of_all_associations",
        ),
    ),
    ExactMutant(
        "the newer sample always wins",
        RESERVOIR,
        "(u * (w_a + w_b) < w_b)",
        "(w_b > 0)",
        ("several_candidates", "temporal_chain", "spatial_pass"),
    ),
    ExactMutant(
        "one random number for two decisions",
        SPATIAL,
        STREAMED,
        "R_s = R_s.then(shifted(q, q_n), neighbors[0][1])",
        ("spatial_pass",),
    ),
    ExactMutant(
        "the sum of weights forgets what came before",
        RESERVOIR,
        "w = a.w + b.w",
        "w = b.w",
        ("several_candidates",),
    ),
    # The target.
    ExactMutant(
        "target of the sample at its source",
        REUSE,
        ARRIVED,
        TAKE + ARRIVED.replace("q.target(R_n.y)", AT_NEIGHBOR),
        ("spatial_pass", "fused_pass"),
    ),
    ExactMutant(
        "target of the sample that lost",
        RESERVOIR,
        "np.where(take_b, b.p_hat, a.p_hat)",
        "a.p_hat",
        ("several_candidates",),
    ),
    ExactMutant(
        "source density left out",
        RESERVOIR,
        "w = divide_or_zero(p_hat, pdf)",
        "w = p_hat",
        ("several_candidates",),
    ),
    ExactMutant(
        "divided by the target of the receiver's own sample",
        SPATIAL,
        CLOSED,
        "kept = R_s.kept\n"
        "    kept = type(kept)(kept.y, q.target(own.y), kept.w, kept.M)\n"
        "    return cap_confidence(finalize(kept, Z), cap)",
        ("spatial_pass",),
    ),
    # Visibility and the normalization.
    ExactMutant(
        "1/M in place of 1/Z",
        MIS,
        "terms = [np.where(holds, M, M * 0)",
        "terms = [M",
        ("spatial_pass", "two_passes"),
    ),
    ExactMutant(
        "Z counts pixels without their M",
        MIS,
        "np.where(holds, M, M * 0)",
        "np.where(holds, 1, 0)",
        ("spatial_pass",),
    ),
    ExactMutant(
        "Z does not ask for visibility",
        PIXELS,
        LOOKED,
        "return possible",
        ("spatial_pass", "fused_pass", "moved_temporal_pass"),
    ),
    ExactMutant(
        "Z does not ask for the horizon",
        PIXELS,
        ASKED,
        "possible = asked",
        ("spatial_pass", "fused_pass", "moved_temporal_pass"),
    ),
    ExactMutant(
        "Z asks for the receiver's view in place of the source's",
        PIXELS,
        ASKED,
        "possible = asked & (self.q.target(y) > 0)",
        ("spatial_pass", "fused_pass"),
        also=(
            (
                PIXELS,
                LOOKED,
                "return sees(self.frame.world, self.q.points, y, possible)",
            ),
        ),
    ),
    ExactMutant(
        "Z forgets the pixel's own reservoir",
        REUSE,
        COULD,
        "could = [R.slot == slot for slot in range(len(Q))]",
        ("spatial_pass", "fused_pass", "moved_temporal_pass", "moved_sources_pass"),
    ),
    ExactMutant(
        "Z forgets who made the sample",
        REUSE,
        MAKER,
        "could[slot] = ~made & q_n.could_make(R.kept.y, full)",
        ("spatial_pass", "fused_pass", "moved_temporal_pass"),
    ),
    ExactMutant(
        "hidden samples are reused and then kept",
        REUSE,
        HIDDEN,
        "return c",
        ("spatial_pass", "fused_pass", "moved_temporal_pass"),
    ),
    ExactMutant(
        "the late test of visibility is forgotten",
        LOOP,
        'if settings.visibility == "chosen" and shifts:',
        'if settings.visibility == "never" and shifts:',
        ("pass_with_late_visibility",),
    ),
    ExactMutant(
        "a limit on the Jacobian that Z does not know",
        PIXELS,
        f"{ASKED}\n        if self.q.refuses is not None:",
        f"{ASKED}\n        if False:",
        ("pass_with_mirrored_limit",),
    ),
    ExactMutant(
        "a limit on the Jacobian that Z applies the other way round",
        PIXELS,
        f"possible &= {REFUSED}\n        {LOOKED}",
        f"possible &= {OTHER_WAY}\n        {LOOKED}",
        ("pass_with_mirrored_limit",),
    ),
    ExactMutant(
        "balance heuristic for the receiver, whoever made the sample",
        ENGINE,
        "p, p_made = np.where(made, own, p), np.where(made, own, p_made)",
        "p = np.where(made, own, p)",
        ("balance_pass",),
    ),
    ExactMutant(
        "balance heuristic without M",
        MIS,
        "saturate(M * p)",
        "saturate(p)",
        ("balance_pass",),
    ),
    ExactMutant(
        "p̂ is kept away from 0 where it divides",
        RESERVOIR,
        "divide_or_zero(c.w, c.p_hat), normalization",
        "divide_or_zero(c.w, np.maximum(c.p_hat, Fraction(1, 2))), normalization",
        ("several_candidates",),
        also=(fractions_in(RESERVOIR),),
    ),
    ExactMutant(
        "the weight W is limited",
        RESERVOIR,
        "return Reservoirs(y=c.y, W=saturate(W), M=c.M)",
        "return Reservoirs(y=c.y, W=np.minimum(W, Fraction(1, 2)), M=c.M)",
        ("several_candidates",),
        also=(fractions_in(RESERVOIR),),
    ),
    ExactMutant(
        "nothing divides the sum of weights",
        RESERVOIR,
        "W = divide_or_zero(divide_or_zero(c.w, c.p_hat), normalization)",
        "W = divide_or_zero(c.w, c.p_hat)",
        ("several_candidates",),
    ),
    # Weights in pairs.
    ExactMutant(
        "the sources' confidences include the canonical one",
        ENGINE,
        DONORS,
        "S = one_over_m([*M_k, c.M])",
        ("pairwise_pass", "defensive_pass"),
    ),
    ExactMutant(
        "the canonical sample gets no share of its own",
        PAIRWISE,
        "divide_or_zero(plus(one_over_m(shares), M_c), plus(S, M_c))",
        "divide_or_zero(one_over_m(shares), plus(S, M_c))",
        ("defensive_pass",),
    ),
    ExactMutant(
        "each source stands for itself alone in its pair",
        PAIRWISE,
        "M_k * _share(S, p_k, M_c, p_c)",
        "M_k * _share(M_k, p_k, M_c, p_c)",
        ("pairwise_pass", "defensive_pass"),
    ),
    ExactMutant(
        "pairs do not ask whether the source could make the sample",
        WEIGHTS,
        "np.where(sees(q_n.frame.world, q_n.x, y, possible), p, p * 0)",
        "p",
        ("pairwise_pass", "defensive_pass"),
    ),
    ExactMutant(
        "what is left of a pair goes to the wrong side",
        PAIRWISE,
        "M * _share(M_c, p_c, S, p)",
        "M * _share(S, p, M_c, p_c)",
        ("pairwise_pass", "defensive_pass"),
    ),
    # The loop.
    ExactMutant(
        "spatial history is merged without its M",
        SPATIAL,
        PAST,
        "c = reused(q, past)\n"
        "    R_s = begin(type(c)(c.y, c.p_hat, c.w, (c.M > 0) * 1))",
        ("loop_of_two_frames",),
    ),
    # Weights of the general engine know a limit, too.
    ExactMutant(
        "a limit on the Jacobian that the balance heuristic does not know",
        WEIGHTS,
        "if refuses := q_n.q.refuses:",
        "if refuses := None:",
        ("balance_pass_with_mirrored_limit",),
    ),
    ExactMutant(
        "a limit on the Jacobian that the balance heuristic applies the other way",
        WEIGHTS,
        "possible &= ~refuses(q_n.x.position, x_q, y)",
        "possible &= ~refuses(x_q, q_n.x.position, y)",
        ("balance_pass_with_mirrored_limit",),
    ),
    ExactMutant(
        "the balance heuristic does not ask for visibility",
        WEIGHTS,
        "sees(q_n.frame.world, q_n.x, y, possible)",
        "possible",
        ("balance_pass", "pairwise_pass", "defensive_pass"),
    ),
    ExactMutant(
        "hidden samples compete in the general engine",
        WEIGHTS,
        "return np.where(seen, p, p * 0)[at], J[at]",
        "return p[at], J[at]",
        ("balance_pass", "pairwise_pass"),
    ),
    ExactMutant(
        "new samples come to the general engine with their density",
        WEIGHTS,
        "W = saturate(divide_or_zero(np.ones_like(pdf), pdf))",
        "W = pdf",
        ("moved_balance_pass",),
    ),
    ExactMutant(
        "nothing is known to be shifted",
        WEIGHTS,
        "if not any(isinstance(source, NeighborPixels) for source, _ in sources):",
        "if True:",
        ("balance_pass", "pairwise_pass"),
    ),
    # Between two frames.
    ExactMutant(
        "the Jacobian forgets that the sample moved",
        MOTION,
        "x_n = self.temporal_shift.points_forward(y, self.x.position)",
        "x_n = self.x.position",
        (
            "moved_temporal_pass",
            "moved_spatial_pass",
            "moved_fused_pass",
            "moved_sources_pass",
        ),
    ),
    ExactMutant(
        "M of a moved past is as if it could make everything",
        REUSE,
        "if not isinstance(q_n, Candidates | Reservoirs):",
        "if slot and not isinstance(q_n, Candidates | Reservoirs):",
        ("moved_temporal_pass", "moved_spatial_pass"),
    ),
    ExactMutant(
        "a moved past is reused as it stands",
        REUSE,
        "    return shifted(q, source)",
        "    r = source.reservoirs\n    return reused_candidates(r, q.target(r.y))",
        ("moved_temporal_pass", "moved_spatial_pass", "moved_fused_pass"),
    ),
    # The fused pass.
    ExactMutant(
        "the fused pass takes the domains of its neighbours for its own",
        FUSED,
        "[past, new, *(q_n for q_n, _ in neighbors)]",
        "[past, new, *(q_n.reservoirs for q_n, _ in neighbors)]",
        ("fused_pass",),
    ),
    ExactMutant(
        "the past is not in the fused stream, but in Z",
        FUSED,
        "R = begin(reused(q, past)).then(new, u)",
        "c = reused(q, past)\n"
        "    R = begin(type(c)(c.y, c.p_hat, c.w * 0, c.M)).then(new, u)",
        ("fused_pass", "moved_fused_pass"),
    ),
    ExactMutant(
        "neighbours of the fused pass are decided on by the number of the new sample",
        FUSED,
        "in neighbors:\n        R = R.then(shifted(q, q_n), u_n)",
        "in neighbors:\n        R = R.then(shifted(q, q_n), u)",
        ("fused_pass",),
    ),
]

SURVIVORS = [
    # Any weights that sum to 1 over the makers of a sample are unbiased.  These do, and
    # are noisier; the balance heuristic's own formula is tested in properties.
    ExactMutant(
        "balance heuristic without Jacobian",
        ENGINE,
        THERE,
        "target(value), len(p_hat)",
        also=((ENGINE, MADE, "target(made)"),),
    ),
    ExactMutant(
        "balance heuristic with the inverse Jacobian",
        ENGINE,
        THERE,
        "divide_or_zero(target(value), jacobian), len(p_hat)",
        also=((ENGINE, MADE, "target(made) * candidate.jacobian[at]"),),
    ),
    # Differs where u w = w_b exactly: a set of measure 0, and two weights of 0.  Found
    # where single numbers are looked at, in properties.
    ExactMutant(
        "a tie goes to the newer sample",
        RESERVOIR,
        "u * (w_a + w_b) < w_b",
        "u * (w_a + w_b) <= w_b",
    ),
]
"""Mistakes that no expectation can see, with the reason."""

CLAIMS = [
    claims.several_candidates,
    claims.temporal_chain,
    claims.moved_temporal_pass,
    claims.moved_balance_pass,
    claims.fused_pass,
    claims.spatial_pass,
    claims.balance_pass,
    claims.pairwise_pass,
    claims.defensive_pass,
    claims.pass_with_late_visibility,
    claims.pass_with_mirrored_limit,
    claims.balance_pass_with_mirrored_limit,
    claims.moved_spatial_pass,
    claims.moved_sources_pass,
    claims.moved_fused_pass,
    claims.two_passes,
    claims.loop_of_two_frames,
    claims.one_law_of_all_associations,
]
"""All claims, in the order of their cost."""
