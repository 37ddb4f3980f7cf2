"""Mistakes in the reuse of whole samples.

In the manner of :mod:`tests.mutants.catalogue`.
"""

from tests.mutants.catalogue import Mutant

ENGINE = "restir_gi.reference.resampling.generalized"
PAIRWISE = "restir_gi.reference.resampling.pairwise"

ARRIVING = "reused_candidates(here, target(value), jacobian)"
COUNTED = "here = Reservoirs(np.full(size, slot, np.int8), W, M)"
MADE = "target(made) / candidate.jacobian[at]"
THERE = "target(value) * jacobian, len(p_hat)"
IN_DOMAIN = "made | (p > 0)"
BALANCE = "p, p_made = np.where(made, own, p), np.where(made, own, p_made)"
CLOSED = "return cap_confidence(finalize(replace(kept, y=y), total), cap)"
DONOR = "pairwise_neighbor(M, made, c.M, k.weighted.p_hat, S, defensive)"
OWN = "weighted = [_with_weight(canonical, m)]"

BIASES = [
    Mutant(
        "a shifted sample has no Jacobian",
        ("HS-09",),
        ENGINE,
        ARRIVING,
        "reused_candidates(here, target(value))",
        ("reuse-jacobian-left-out",),
    ),
    Mutant(
        "a shifted sample has its Jacobian twice",
        (),
        ENGINE,
        ARRIVING,
        "reused_candidates(here, target(value), jacobian * jacobian)",
        ("reuse-jacobian-twice",),
    ),
    Mutant(
        "a sample is weighted by what it was worth at its source",
        (),
        ENGINE,
        ARRIVING,
        "reused_candidates(here, target(take(r.y.value, row)), jacobian)",
        ("reuse-target-of-the-donor",),
    ),
    Mutant(
        "sources without a sample have no confidence",
        (),
        ENGINE,
        COUNTED,
        "here = Reservoirs(np.full(size, slot, np.int8), W, np.where(W > 0, M, 0))",
        ("reuse-nulls-not-counted",),
    ),
    Mutant(
        "slots without a source have the confidence of the first row",
        (),
        ENGINE,
        "W, M = (np.where(none, a * 0, a) for a in (r.W[row], r.M[row]))",
        "W, M = np.where(none, r.W[row] * 0, r.W[row]), r.M[row]",
    ),
    Mutant(
        "what a sample was worth is left in its source's measure",
        (),
        ENGINE,
        MADE,
        "target(made)",
        ("reuse-made-without-jacobian",),
    ),
    Mutant(
        "what a sample was worth is multiplied by the Jacobian",
        (),
        ENGINE,
        MADE,
        "target(made) * candidate.jacobian[at]",
        ("reuse-made-times-jacobian",),
    ),
    Mutant(
        "what a sample was worth is what it is worth here",
        (),
        ENGINE,
        MADE,
        "candidate.weighted.p_hat[at]",
        ("reuse-made-at-the-receiver",),
    ),
    Mutant(
        "what others would give for a sample is left in their measure",
        (),
        ENGINE,
        THERE,
        "target(value) * jacobian * 2, len(p_hat)",
    ),
    Mutant(
        "Z leaves out who made the sample",
        (),
        ENGINE,
        IN_DOMAIN,
        "p > 0",
        ("reuse-maker-not-in-z",),
    ),
    Mutant(
        "Z counts who could not have made the sample",
        (),
        ENGINE,
        IN_DOMAIN,
        "made | (p >= 0)",
        ("reuse-z-of-everybody",),
    ),
    Mutant(
        "balance over the receiver's target",
        (),
        ENGINE,
        BALANCE,
        "p = np.where(made, own, p)",
        ("reuse-balance-over-the-receiver",),
    ),
    Mutant(
        "balance with the maker at the receiver",
        (),
        ENGINE,
        BALANCE,
        "p, p_made = np.where(made, kept.p_hat, p), np.where(made, own, p_made)",
    ),
    Mutant(
        "1/M whatever the weights",
        (),
        ENGINE,
        'if mis == "1/M":',
        'if mis in ("1/M", "1/Z", "balance"):',
        ("reuse-one-over-m",),
    ),
    Mutant(
        "weights in pairs are divided by the sum of confidences",
        (),
        ENGINE,
        "return np.ones_like(kept.w)",
        "return one_over_m(M_k)",
        ("reuse-pairs-divided-again",),
    ),
    Mutant(
        "W is scaled down with M",
        ("HS-17",),
        ENGINE,
        CLOSED,
        "closed = finalize(replace(kept, y=y), total)\n"
        "    some = np.minimum(closed.M, cap) / closed.M\n"
        "    return cap_confidence(replace(closed, W=closed.W * some), cap)",
        ("reuse-w-capped-with-m",),
    ),
    Mutant(
        "S has the canonical confidence in it",
        (),
        ENGINE,
        "S = one_over_m(M_k)",
        "S = one_over_m([*M_k, c.M])",
        ("reuse-pairs-canonical-in-s",),
    ),
    Mutant(
        "source and receiver exchange their targets",
        (),
        ENGINE,
        DONOR,
        "pairwise_neighbor(M, k.weighted.p_hat, c.M, made, S, defensive)",
        ("reuse-pairs-exchanged",),
    ),
    Mutant(
        "the canonical sample keeps its whole weight",
        (),
        ENGINE,
        OWN,
        "weighted = [_with_weight(canonical, m * 0 + 1)]",
        ("reuse-canonical-counts-whole",),
    ),
    Mutant(
        "the canonical sample does not compete",
        (),
        ENGINE,
        OWN,
        "weighted = [_with_weight(canonical, m * 0)]",
        ("reuse-canonical-forgotten",),
    ),
    Mutant(
        "the canonical sample asks nobody",
        (),
        ENGINE,
        "target_at(k, y, c.p_hat, c.w > 0, target)",
        "target_at(k, y, c.p_hat, c.w < 0, target)",
        ("reuse-canonical-counts-whole",),
    ),
    Mutant(
        "weights in pairs stand beside M",
        (),
        ENGINE,
        "w=divide_or_zero(c.w, c.M) * m",
        "w=c.w * m",
        ("reuse-pairs-times-confidence",),
    ),
    Mutant(
        "defensive sources keep the canonical share",
        (),
        PAIRWISE,
        "total = plus(S, M_c) if defensive else S",
        "total = S",
        ("reuse-defensive-without-canonical",),
    ),
    Mutant(
        "the value of another slot is kept",
        (),
        ENGINE,
        "value = pick(slot, [c.value for c in stream])",
        "value = pick(len(stream) - 1 - slot, [c.value for c in stream])",
    ),
    Mutant(
        "samples are put where they were taken from",
        (),
        ENGINE,
        "np.argsort(np.concatenate(at))",
        "np.concatenate(at)",
    ),
]

EQUIVALENT = [
    Mutant(
        "M grows without limit",
        (),
        ENGINE,
        CLOSED,
        "return finalize(replace(kept, y=y), total)",
        ("reuse-never-capped",),
        kind="equivalent",
    ),
    Mutant(
        "the canonical source is the first that stands",
        ("EQ",),
        ENGINE,
        "canonical = own[-1]",
        "canonical = own[0]",
        kind="equivalent",
    ),
    Mutant(
        "1/Z counts the maker without asking",
        ("EQ",),
        ENGINE,
        "full & ~made, target)",
        "full, target)",
        kind="equivalent",
    ),
]

REUSE_MUTANTS = [*BIASES, *EQUIVALENT]
