"""What pairs and their images are replayed with: the contract, or a known mistake."""

from dataclasses import dataclass, field

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.reference.oracle.replay.rules import Rules


@dataclass(frozen=True, slots=True)
class PairRules:
    """What the passes calculate with.

    Attributes
    ----------
    inner : 'times', 'none', 'over' or 'twice'; Jacobian of the offset path in G
    turned : bool; k = 1 turns the sign of G
    reversed : bool; G is that of F_j − F_i
    alone : 'counts' or 'dropped'; base paths without offset path
    share : 'mis', 'half', 'none', 'without jacobian', 'over jacobian' or 'other'
        Weight ω: one half, 1, without the Jacobian, with its inverse, or that of the
        offset path.
    share_alone : 'whole' or 'half'; ω of a base path without offset path
    densities : bool; ω after resampling is that of densities, not of targets
    light : 'of magnitudes', 'of the sum' or 'of the part'
        p̂: the luminance of |·| by channel; |luminance|; the luminance of the part
        that has the sign once all channels are added.
    target_weighted : bool; p̂ has ω in it
    part : 'own', 'other', 'whole' or 'of the luminance'
        What a reservoir of a sign adds: its part by channel, that of the other sign,
        all of H, or all channels of H where its luminance has the sign.
    minus : 'subtracted' or 'added'; sign of what the reservoir of minus adds
    signed_target : bool; p̂ is of the reservoir's sign, not of the whole magnitude
    candidate : float; MIS weight of a new candidate
    candidates : int; M of a new reservoir
    divided : bool; W of a new reservoir is divided by the number of candidates
    nulls_count : bool; a reservoir of nulls has M = 1
    first_target : bool; W is divided by the target of k = 0, whatever is kept
    u_turned : bool; 1 − u decides
    shown : 'weighted' or 'unweighted'; whether what a reservoir adds has ω
    own_weight : bool; each sign's sample has its own W, not that of plus
    plus_alone : bool; the reservoir of minus is left out
    one_is_both : bool; a reservoir of both signs adds both
    offset_pixel : 'other' or 'own'; where the offset path goes
    step : 'onward', 'forward' or 'none'; how its place moves where k = 1
    refused : bool; f of a shift that does not exist is 0
    k_kept : bool; k remains
    rebuilt : 'all', 'value', 'jacobian' or 'nothing'; what of the offset path is
    outer : 'base', 'times inner', 'none' or 'over'; outer Jacobian
    reuse : ReuseRules; what is resampled with, beside targets
    inverse_signed : bool; what others could make is of the sign
    carried_at_others : bool; it has the offset paths from here
    normals : 'below', 'above', 'absolute' or 'ignored'; where cosines make an edge
    albedos : 'any channel', 'signed', 'luminance' or 'ignored'; what differs
    depths : 'larger', 'first', 'second', 'absolute' or 'ignored'
        What a difference is held against.
    every : bool; all three have to differ
    lone_hit : bool; a pixel that sees a point beside one that does not is an edge
    compared : 'both', 'first', 'second', 'any' or 'crossed'; of pairs that are alike
    edges_alone : bool; whether the pair found has to be an edge
    interior : bool; pairs that are no edge look for one too
    taken : 'first' or 'last'; which of several tries that are alike
    itself : bool; a pair may find itself
    square : 'lines', 'columns' or 'disc'; how places are counted
    border : 'lost' or 'clamped'; tries outside of the image
    other_axis : bool; the pair found is of the other axis
    pivot : 'nearer', 'farther', 'first', 'either' or 'depth alone'
        Pixel that a pair moves with; 'either': the second where both are alike.
    stepped : bool; the second pixel's place is brought to the first
    stepped_across : bool; along the other axis
    emission : bool; emission is in what the image is made of
    weighted : bool; W is in the pixel's colour
    forward : bool; differences of pairs change their sign
    exchanged : bool; axes are exchanged
    border_kept : bool; differences at the border are kept
    differences : 'forward', 'backward', 'reversed' or 'periodic'
        Between which pixels they lie, or with which sign.
    alpha : 'squared', 'plain', 'twice' or 'one'; on P in the normal equations
    alpha_on : 'pixels' or 'differences'; rows that it weighs
    divergence : bool; whether it has its sign
    edges : 'open', 'periodic' or 'black'; what lies outside of the image
    mixed : bool; channels are solved as their luminance
    added : bool; P is added to the image once more
    norm : 'asked' or 'squares'; which sum is the least
    """

    inner: str = "times"
    turned: bool = True
    reversed: bool = False
    alone: str = "counts"
    share: str = "mis"
    share_alone: str = "whole"
    densities: bool = False
    light: str = "of magnitudes"
    target_weighted: bool = True
    part: str = "own"
    minus: str = "subtracted"
    signed_target: bool = True
    candidate: float = 1.0
    candidates: int = 1
    divided: bool = False
    nulls_count: bool = True
    first_target: bool = False
    u_turned: bool = False
    shown: str = "weighted"
    own_weight: bool = True
    plus_alone: bool = False
    one_is_both: bool = True
    offset_pixel: str = "other"
    step: str = "onward"
    refused: bool = True
    k_kept: bool = True
    rebuilt: str = "all"
    outer: str = "base"
    reuse: ReuseRules = field(default_factory=ReuseRules)
    inverse_signed: bool = True
    carried_at_others: bool = False
    normals: str = "below"
    albedos: str = "any channel"
    depths: str = "larger"
    every: bool = False
    lone_hit: bool = True
    compared: str = "both"
    edges_alone: bool = True
    interior: bool = False
    taken: str = "first"
    itself: bool = False
    square: str = "lines"
    border: str = "lost"
    other_axis: bool = False
    pivot: str = "nearer"
    stepped: bool = True
    stepped_across: bool = False
    emission: bool = False
    weighted: bool = True
    forward: bool = True
    exchanged: bool = False
    border_kept: bool = False
    differences: str = "forward"
    alpha: str = "squared"
    alpha_on: str = "pixels"
    divergence: bool = True
    edges: str = "open"
    mixed: bool = False
    added: bool = False
    norm: str = "asked"


def pairing(rules: Rules) -> PairRules:
    """What the passes of pairs and images calculate with."""
    return rules.part or PairRules()
