"""The pass of the contract about generalized resampling."""

from restir_gi.reference.oracle.contract.fields import Pass, Setting, bits, index, real

PATH_REUSE = Pass(
    name="path_reuse",
    summary="Which of the samples that K sources bring is kept, and its weight",
    formula=(
        "c = canonical; M_k = 0 where there_k = 0; p_k(s) = target_at_sk for k ≠ s, c, "
        "target_here_s for k = c, and target_base_s / jacobian_s for k = s ≠ c;\n"
        "w_k = m_k · target_here_k · W_k · jacobian_k, 0 where there_k = 0;\n"
        "the first slot is kept, then slot k in its place where "
        "u_k · (w_0 + ⋯ + w_k) < w_k; s is what is kept in the end;\n"
        "mis = 1/M: m_k = M_k, Z = ΣM_k; 1/Z: m_k = M_k, Z = Σ M_k of those with "
        "p_k(s) > 0; balance: m_k = M_k, Z = Σ M_k p_k(s) / p_s(s);\n"
        "pairwise: S = Σ M_k of k ≠ c, T = S; defensive: T = S + M_c; for both Z = 1,\n"
        "m_k = M_k / T · S p_k(k) / (S p_k(k) + M_c p_c(k)) for k ≠ c,\n"
        "m_c = Σ M_k / T · M_c p_c(c) / (S p_k(c) + M_c p_c(c)) over k ≠ c, plus "
        "M_c / T for defensive; for pairwise 1 where S = 0;\n"
        "W = Σw_k / (Z · target_here_s), M = min(ΣM_k, cap); W = 0 where Σw_k = 0"
    ),
    inputs=(
        real("W", "of the sources' reservoirs", "K"),
        real("M", "their confidences", "K"),
        bits("there", "1 where the slot has a source at all", "K"),
        real("target_base", "p̂ of a source's sample where it was made", "K"),
        real("target_here", "p̂ of it at the receiver; 0: no such path", "K"),
        real("jacobian", "of its shift to the receiver; 0: no such path", "K"),
        real(
            "target_at",
            "row s, column k: p̂ of the sample of slot s at source k, times the Jacobian"
            " of the shift there from the receiver; 0 where k cannot make it",
            "K",
            "K",
        ),
        real("u", "in [0, 1); the first decides nothing", "K"),
    ),
    outputs=(
        index("slot", "that is kept; not asked for where W = 0"),
        real("p_hat", "target_here_s, of what is kept; not asked for where W = 0"),
        real("W", "unbiased contribution weight"),
        real("M", "confidence"),
    ),
    settings=(
        Setting("mis", "1/M, 1/Z, balance, pairwise or defensive", "the weights"),
        Setting(
            "canonical",
            "whole number, 0 to K − 1",
            "slot of the receiver's own sample, which is not shifted: jacobian 1",
        ),
        Setting("cap", "number, 1 upwards", "limit of M, on the way out"),
    ),
    source=(
        "[Lin22, Eqs. 22 and 36 to 38]. A sample may be anything: its value "
        "where stands in the tables"
    ),
    clauses=(
        "the weight has the Jacobian once",
        "the target is that at the receiver",
        "nulls count",
        "slots without a source do not count",
        "the sum is divided as it is asked for",
        "only those count in 1/Z that could have made the sample",
        "the maker's target is brought into the receiver's measure",
        "pairs compare source and receiver",
        "the canonical sample has its share",
        "M is capped on the way out, and nothing else",
        "u decides as in every stream",
        "W = 0 where no weight arrives",
    ),
)
