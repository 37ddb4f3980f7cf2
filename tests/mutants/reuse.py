"""Mistakes in the reuse of whole samples.

In the manner of :mod:`tests.mutants.catalogue`.
"""

from tests.mutants.catalogue import Mutant

REUSE, OFFERS, PAIRS = (f"extensions.{name}" for name in ("reuse", "offers", "pairs"))
PAIRWISE = "reference.resampling.pairwise"

ARRIVING = "reused_candidates(here, target(value), jacobian)"
COUNTED = "here = Reservoirs(np.full(size, place, np.int8), W, M)"
MADE = "target(base) / offer.jacobian[at]"
THERE = "target(value) * jacobian, len(p_hat)"
HOLDS = "mine | (p > 0)"
CLOSED = "return cap_confidence(finalize(replace(chosen, y=y), total), cap)"
DONOR = "pairwise_donor(M, made, c.M, p_c, S, defensive)"
OWN = "weighted = [_with_weight(own, m)]"

BIASES = [
    Mutant(
        "a shifted sample has no Jacobian",
        ("HS-09",),
        OFFERS,
        ARRIVING,
        "reused_candidates(here, target(value))",
        ("reuse-jacobian-left-out",),
    ),
    Mutant(
        "a shifted sample has its Jacobian twice",
        (),
        OFFERS,
        ARRIVING,
        "reused_candidates(here, target(value), jacobian * jacobian)",
        ("reuse-jacobian-twice",),
    ),
    Mutant(
        "a sample is weighted by what it was worth at its donor",
        (),
        OFFERS,
        ARRIVING,
        "reused_candidates(here, target(take(r.y.value, row)), jacobian)",
        ("reuse-target-of-the-donor",),
    ),
    Mutant(
        "donors without a sample have no confidence",
        (),
        OFFERS,
        COUNTED,
        "here = Reservoirs(np.full(size, place, np.int8), W, np.where(W > 0, M, 0))",
        ("reuse-nulls-not-counted",),
    ),
    Mutant(
        "slots without a donor have the confidence of the first row",
        (),
        OFFERS,
        "W, M = (np.where(none, a * 0, a) for a in (r.W[row], r.M[row]))",
        "W, M = np.where(none, r.W[row] * 0, r.W[row]), r.M[row]",
    ),
    Mutant(
        "what a sample was worth is left in its donor's measure",
        (),
        OFFERS,
        MADE,
        "target(base)",
        ("reuse-made-without-jacobian",),
    ),
    Mutant(
        "what a sample was worth is multiplied by the Jacobian",
        (),
        OFFERS,
        MADE,
        "target(base) * offer.jacobian[at]",
        ("reuse-made-times-jacobian",),
    ),
    Mutant(
        "what a sample was worth is what it is worth here",
        (),
        OFFERS,
        MADE,
        "offer.candidates.p_hat[at]",
        ("reuse-made-at-the-receiver",),
    ),
    Mutant(
        "what others would give for a sample is left in their measure",
        (),
        OFFERS,
        THERE,
        "target(value) * jacobian * 2, len(p_hat)",
    ),
    Mutant(
        "Z leaves out who made the sample",
        (),
        REUSE,
        HOLDS,
        "p > 0",
        ("reuse-maker-not-in-z",),
    ),
    Mutant(
        "Z counts who could not have made the sample",
        (),
        REUSE,
        HOLDS,
        "mine | (p >= 0)",
        ("reuse-z-of-everybody", "reuse-one-over-m"),
    ),
    Mutant(
        "balance over the receiver's target",
        (),
        REUSE,
        "p_made = np.where(mine, made, p_made)",
        "p_made = p_made",
        ("reuse-balance-over-the-receiver",),
    ),
    Mutant(
        "balance with the maker at the receiver",
        (),
        REUSE,
        "p_k.append(np.where(mine, made, p))",
        "p_k.append(np.where(mine, chosen.p_hat, p))",
    ),
    Mutant(
        "1/M whatever the weights",
        (),
        REUSE,
        'if mis == "1/M":',
        'if mis in ("1/M", "1/Z", "balance"):',
        ("reuse-one-over-m",),
    ),
    Mutant(
        "weights in pairs are divided by the sum of confidences",
        (),
        REUSE,
        "return np.ones_like(chosen.w)",
        "return one_over_m(M_k)",
        ("reuse-pairs-divided-again", "reuse-one-over-m"),
    ),
    Mutant(
        "W is scaled down with M",
        ("HS-17",),
        REUSE,
        CLOSED,
        "kept = finalize(replace(chosen, y=y), total)\n"
        "    some = np.minimum(kept.M, cap) / kept.M\n"
        "    return cap_confidence(replace(kept, W=kept.W * some), cap)",
        ("reuse-w-capped-with-m",),
    ),
    Mutant(
        "S has the canonical confidence in it",
        (),
        PAIRS,
        "S = one_over_m(M_k)",
        "S = one_over_m([*M_k, c.M])",
        ("reuse-pairs-canonical-in-s",),
    ),
    Mutant(
        "donor and receiver exchange their targets",
        (),
        PAIRS,
        DONOR,
        "pairwise_donor(M, p_c, c.M, made, S, defensive)",
        ("reuse-pairs-exchanged",),
    ),
    Mutant(
        "the canonical sample keeps its whole weight",
        (),
        PAIRS,
        OWN,
        "weighted = [_with_weight(own, m * 0 + 1)]",
        ("reuse-canonical-counts-whole",),
    ),
    Mutant(
        "the canonical sample does not compete",
        (),
        PAIRS,
        OWN,
        "weighted = [_with_weight(own, m * 0)]",
        ("reuse-canonical-forgotten",),
    ),
    Mutant(
        "the canonical sample asks nobody",
        (),
        PAIRS,
        "target_at(offer, y, c.p_hat, c.w > 0, target)",
        "target_at(offer, y, c.p_hat, c.w < 0, target)",
        ("reuse-canonical-counts-whole",),
    ),
    Mutant(
        "weights in pairs stand beside M",
        (),
        PAIRS,
        "w=divide_or_zero(c.w, c.M) * m",
        "w=c.w * m",
        ("reuse-pairs-times-confidence",),
    ),
    Mutant(
        "defensive donors keep the canonical share",
        (),
        PAIRWISE,
        "total = plus(S, M_c) if defensive else S",
        "total = S",
        ("reuse-defensive-without-canonical",),
    ),
    Mutant(
        "the value of another slot is kept",
        (),
        OFFERS,
        "value = where(here, offer.value, value)",
        "value = where(~here, offer.value, value)",
    ),
]

EQUIVALENT = [
    Mutant(
        "M grows without limit",
        (),
        REUSE,
        CLOSED,
        "return finalize(replace(chosen, y=y), total)",
        ("reuse-never-capped",),
        kind="equivalent",
    ),
    Mutant(
        "the canonical donor is the first that stands",
        ("EQ",),
        PAIRS,
        "own = offers[places[-1]]",
        "own = offers[places[0]]",
        kind="equivalent",
    ),
    Mutant(
        "1/Z counts the maker without asking",
        ("EQ",),
        REUSE,
        "kept & ~mine, target)\n            held",
        "kept, target)\n            held",
        kind="equivalent",
    ),
]

REUSE_MUTANTS = [*BIASES, *EQUIVALENT]
