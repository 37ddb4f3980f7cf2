"""MIS weights of passes that reuse samples: their settings, clauses and formulas."""

from restir_gi.reference.oracle.contract.fields import Setting

BALANCE, PAIRWISE, DEFENSIVE = "balance", "pairwise", "defensive"

MIS = Setting(
    "mis",
    "1/M | 1/Z",
    "weights of those that could have made a sample",
    more=(BALANCE, PAIRWISE, DEFENSIVE),
)

MIS_AT_REST = Setting(
    "mis",
    "1/Z",
    "weights of the two; 1/M, balance and pairwise are 1/Z where nothing moves",
    more=(DEFENSIVE,),
    default="1/Z",
)
"""Of Algorithm 3 where both samples come from one domain."""

SHARES = (
    "a declared weight is the one that is asked for",
    "a declared weight asks the target of the source",
    "a declared weight compares densities in the receiver's measure",
)
"""Clauses of passes in which something is shifted."""

SHARE_AT_REST = "the defensive weight leaves the new sample a share"

PAGE = """
## MIS weights

`mis` says how those that could have made a sample share it. By 1/M and 1/Z, which stand
with the passes, w has M, and the sum of weights is divided by Z. Its declared values
are those of [Lin22, Eqs. 36-38]. They compare densities, all in the measure of the
receiver x: with y as x has it,

```text
p_j(y) = p̂_j(y) / J(x_j → x)   for a source x_j that was shifted, with its own normal,
                               albedo and declared surface; 0 where it does not see y,
                               and where J is 0
p_j(y) = p̂(y)                  for what x itself has: past and own in spatial, own in
                               fused, the new sample in moved, both in temporal
```

Visibility of the receiver is no part of p. c is the canonical sample, which x itself
has drawn: its own reservoir in `spatial` and `fused`, the new sample with M = 1 in
`moved` and `temporal`. j runs over all others, the spatial past among them, k is one of
these, and s is who made the kept sample:

```text
balance:    w as by 1/Z, with M;  Z = Σ M p(y) / p_s(y), over all in the stream
pairwise:   S = Σ M_j;  w has m in place of M, and Z = 1
            m_k = M_k / S · S p_k(y_k) / (S p_k(y_k) + M_c p̂(y_k))
            m_c = Σ M_j / S · M_c p̂(y_c) / (S p_j(y_c) + M_c p̂(y_c)),  1 where S = 0
defensive:  T = S + M_c;  M / T in place of M / S, and m_c has M_c / T more
```

A sample is kept by the same rule, with these w. M is Σ M, capped when it is stored, as
by 1/Z. All of them leave the mean alone, as do 1/Z and any weights that sum to 1 over
those that could have made a sample; but in pairs the canonical sample has to be there,
M_c > 0, to take what others cannot make.
"""
"""Section of the contract's page."""
