"""What reuse of whole samples is replayed with: the contract, or a known mistake."""

from dataclasses import dataclass

from restir_gi.reference.oracle.replay.rules import Rules


@dataclass(frozen=True, slots=True)
class ReuseRules:
    """What the pass calculates with.

    Attributes
    ----------
    jacobian : 'times', 'none', 'over' or 'twice'
        In the weight of a sample that was shifted.
    target_base : bool; the sources' target takes the place of the receiver's
    nulls_count : bool; M of sources without a sample
    empty_count : bool; M of slots without a source
    replaced : tuple of str; weights, not in pairs, that are not taken where asked for
    normalization : str; what stands in their place
    every_domain : bool; Z counts who could not have made the sample too
    maker_counts : bool; who made the sample is in Z
    made : 'over', 'none', 'times' or 'here'
        Target of a sample where it was made: over the Jacobian, without it, times it,
        or that at the receiver.
    maker_divides : bool
        The balance heuristic is divided by the maker's target, not the receiver's.
    canonical_in_s : bool
        S of the sources' weights has the confidence of the canonical slot in it.
    defensive_total : bool; T of the sources' weights has it, where it should
    canonical_share : 'of all', 'whole' or 'none'; of the canonical sample
    exchanged : bool; in pairs, the targets of source and receiver
    beside_confidence : bool; weights in pairs are multiplied by M_k as well
    divided_again : bool; weights in pairs are divided by ΣM as well
    capped : 'M', 'before', 'weights', 'W' or 'never'
        What is capped: M on the way out, M of all sources beforehand and no more, M in
        their weights but not in Z, W with M, or nothing.
    u_turned : bool; 1 − u decides
    held : str; as what W and M are stored between passes, by its name in `HALVES`
    """

    jacobian: str = "times"
    target_base: bool = False
    nulls_count: bool = True
    empty_count: bool = False
    replaced: tuple[str, ...] = ()
    normalization: str = "1/M"
    every_domain: bool = False
    maker_counts: bool = True
    made: str = "over"
    maker_divides: bool = True
    canonical_in_s: bool = False
    defensive_total: bool = True
    canonical_share: str = "of all"
    exchanged: bool = False
    beside_confidence: bool = False
    divided_again: bool = False
    capped: str = "M"
    u_turned: bool = False
    held: str = "exact"


def reusing(rules: Rules) -> ReuseRules:
    """What the pass calculates with."""
    return rules.part or ReuseRules()
