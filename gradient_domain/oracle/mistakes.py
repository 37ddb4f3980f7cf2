"""Known mistakes in pairs of paths, and in images that are made from differences."""

from dataclasses import replace
from typing import Any

from restir_gi.extensions.oracle.reuse.rules import ReuseRules
from restir_gi.gradient_domain.oracle.rules import PairRules
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Departure,
    Hypothesis,
    mistake,
)

TARGETS = ("pair_target", "pair_initial", "pair_reuse")
SHOWN = (*TARGETS, "pair_estimate")
WEIGHTED = (*SHOWN, "after_estimate")
VALUES = ("pair_value", *WEIGHTED)
SHARES = ("pair_weight", *WEIGHTED)
BY_DENSITY = ("pair_weight", "after_estimate")
"""Where densities may be other than 1, so that they do not cancel."""

EDGES = ("edge_pair", "pair_search")
SEARCH, MOTION = ("pair_search",), ("pair_motion",)
REUSE, INITIAL, ESTIMATE = ("pair_reuse",), ("pair_initial",), ("pair_estimate",)
INNER, OUTER = ("inner_shift",), ("outer_shift",)
SOLVERS = ("poisson_l2", "poisson_l1")
IMAGES = ("pair_differences", "differences", *SOLVERS)

G = "k = 0: G = base − offset · inner; k = 1: G = offset · inner − base"
OMEGA = "omega = p_base / (p_base + p_offset · inner)"
P_HAT = "p_hat = 0.2126 |r| + 0.7152 |g| + 0.0722 |b| of the contribution"
PART = "plus: max(H, 0), minus: −max(−H, 0), by channel"
W = "w_c = p_hat_c · W_c, W = (w_0 + w_1) / p_hat, M = 1"
DELTA = "delta = contribution_0 · W_0 + contribution_1 · W_1"
OFFSET = "the offset path is rebuilt in the other pair"
J = "jacobian = jacobian_at_k"
EDGE = "|albedo_a − albedo_b| > 0.1 in any channel, or normal_a · normal_b < 0.9, or \
|depth_a − depth_b| > 0.1 · max(depth_a, depth_b)"
ALIKE = "its first pixel looks like the first, its second like the second"
PIVOT = "pivot = second where depth_second < depth_first, else first"
A_L2 = "(alpha² + D_xᵀ D_x + D_yᵀ D_y) I = alpha² P + D_xᵀ dx + D_yᵀ dy"
E_L1 = "E = Σ |alpha (I − P)| + Σ |D_x I − dx| + Σ |D_y I − dy|"
IMAGE = f"{A_L2}; or the least {E_L1}"
AUTHORS = "gradient-restir"


def _known(
    name: str,
    what: str,
    wrong: str,
    right: str,
    passes: tuple[str, ...],
    *seen: str,
    departure: Departure = "",
    **rules: Any,
) -> Hypothesis:
    part = PairRules(**rules)
    return mistake(
        name, what, wrong, right, passes, *seen, departure=departure, part=part
    )


VALUE_MISTAKES = (
    _known(
        "pair-inner-jacobian-left-out",
        "the offset path has no Jacobian",
        "G = base − offset",
        G,
        VALUES,
        inner="none",
    ),
    _known(
        "pair-inner-jacobian-divides",
        "the offset path is divided by its Jacobian",
        "G = base − offset / inner",
        G,
        VALUES,
        inner="over",
    ),
    _known(
        "pair-inner-jacobian-twice",
        "the Jacobian is in the offset path's contribution, and multiplied once more",
        "G = base − offset · inner²",
        G,
        VALUES,
        inner="twice",
    ),
    _known(
        "pair-second-sign-not-turned",
        "samples of k = 1 have the sign of those of k = 0",
        "G = base − offset · inner for both k",
        G,
        VALUES,
        turned=False,
    ),
    _known(
        "pair-difference-reversed",
        "the difference is that of j less i",
        "k = 0: G = offset · inner − base; k = 1: G = base − offset · inner",
        G,
        VALUES,
        AUTHORS,
        reversed=True,
    ),
    _known(
        "pair-alone-dropped",
        "base paths without offset path contribute nothing: silhouettes lose them",
        "G = 0 where inner = 0",
        "G = ±base where inner = 0",
        VALUES,
        alone="dropped",
    ),
)

# Whatever ω is, the difference is right where it sums to 1 over both ways to draw a
# pair of paths: with another density, or a Jacobian less, it does.
SHARE_MISTAKES = (
    _known(
        "pair-weight-one-half",
        "both ways to draw two paths count one half, whatever their densities",
        "omega = 1/2",
        OMEGA,
        SHARES,
        departure="mis",
        share="half",
    ),
    _known(
        "pair-weight-left-out",
        "both ways to draw two paths count fully: differences are doubled",
        "omega = 1",
        OMEGA,
        # In weights of reservoirs it is another target, and is shown by the last one.
        ("pair_weight", "pair_target", "after_estimate"),
        share="none",
    ),
    _known(
        "pair-weight-without-jacobian",
        "the offset path's density is not brought into the base path's measure",
        "omega = p_base / (p_base + p_offset)",
        OMEGA,
        BY_DENSITY,
        departure="mis",
        share="without jacobian",
    ),
    _known(
        "pair-weight-over-jacobian",
        "the offset path's density is divided by the Jacobian",
        "omega = p_base / (p_base + p_offset / inner)",
        OMEGA,
        BY_DENSITY,
        departure="mis",
        share="over jacobian",
    ),
    _known(
        "pair-weight-of-the-offset",
        "the base path has the weight of the offset path",
        "omega = p_offset · inner / (p_base + p_offset · inner)",
        OMEGA,
        SHARES,
        departure="mis",
        share="other",
    ),
    _known(
        "pair-alone-halved",
        "base paths without offset path count one half",
        "omega = 1/2 where inner = 0",
        "omega = 1 where inner = 0",
        SHARES,
        share_alone="half",
    ),
    _known(
        "after-densities-for-targets",
        "resampled paths are weighted as if they were new ones",
        "ω = 1 / (1 + inner)",
        "ω = p / (p + q · inner), with the targets p of the base path, q of the offset",
        ("after_estimate",),
        departure="mis",
        densities=True,
    ),
)

TARGET_MISTAKES = (
    _known(
        "pair-target-of-the-sum",
        "the target is the magnitude of the luminance: channels of both signs cancel",
        "p_hat = |0.2126 r + 0.7152 g + 0.0722 b| of H",
        P_HAT,
        TARGETS,
        AUTHORS,
        light="of the sum",
    ),
    _known(
        "pair-target-of-the-part",
        "the target is the part of the luminance that has the sign",
        "p_hat = max(± luminance of H, 0)",
        P_HAT,
        TARGETS,
        light="of the part",
    ),
    _known(
        "pair-target-unweighted",
        "the target is that of G, without the weight of the base path",
        "p_hat = luminance of |G| by channel",
        "p_hat = luminance of |ω G| by channel",
        TARGETS,
        departure="target",
        target_weighted=False,
    ),
    _known(
        "pair-target-of-both-signs",
        "reservoirs of a sign have the target of the whole magnitude",
        "p_hat = luminance of |H|",
        "p_hat = luminance of the magnitude of what the reservoir adds",
        TARGETS,
        departure="target",
        signed_target=False,
    ),
    _known(
        "pair-parts-exchanged",
        "the reservoir of plus has the part of minus",
        "plus: −max(−H, 0), minus: max(H, 0)",
        PART,
        # In weights of reservoirs it is the difference of j less i.
        ("pair_target", "pair_estimate"),
        part="other",
    ),
    _known(
        "pair-negative-part-added",
        "the negative part is added: all differences are positive",
        "minus: max(−H, 0)",
        PART,
        ("pair_target", "pair_estimate"),
        minus="added",
    ),
    _known(
        "pair-whole-in-each-sign",
        "a reservoir of a sign adds all of its sample: mixed ones count twice",
        "contribution = H",
        PART,
        ("pair_estimate",),
        part="whole",
    ),
    replace(
        _known(
            "pair-split-by-luminance",
            "a sample belongs to the sign of its luminance, with all channels",
            "plus: H where its luminance is above 0, else 0",
            PART,
            TARGETS,
            departure="target",
            part="of the luminance",
        ),
        needs=("pair_estimate", "pair-shown-by-luminance"),
    ),
    _known(
        "pair-shown-by-luminance",
        "a sample is shown whole, by the reservoir that has the sign of its luminance",
        "plus: H where its luminance is above 0, else 0",
        PART,
        ("pair_estimate",),
        departure="target",
        # What a reservoir by channels shows it has: the other way round it lacks some.
        part="of the luminance",
    ),
)

INITIAL_MISTAKES = (
    _known(
        "pair-candidates-halved",
        "the candidates of k = 0 and 1 have the weight 1/2 each",
        "w_c = 1/2 · p_hat_c · W_c",
        W,
        INITIAL,
        candidate=0.5,
    ),
    _known(
        "pair-candidates-count-twice",
        "a new reservoir has the confidence of two samples",
        "M = 2",
        W,
        INITIAL,
        departure="confidence",
        candidates=2,
    ),
    _known(
        "pair-divided-by-candidates",
        "W is divided by the number of candidates, as if they were of one domain",
        "W = (w_0 + w_1) / (2 p_hat), M = 2",
        W,
        INITIAL,
        divided=True,
        candidates=2,
    ),
    _known(
        "pair-nulls-not-counted",
        "candidates that are worth nothing for a sign do not count",
        "M = 0 where both w are 0",
        W,
        INITIAL,
        AUTHORS,
        nulls_count=False,
    ),
    _known(
        "pair-target-of-the-first",
        "W is divided by the target of k = 0, whichever is kept",
        "W = (w_0 + w_1) / p_hat_0",
        W,
        INITIAL,
        first_target=True,
    ),
    _known(
        "pair-u-turned",
        "the number decides the other way round",
        "kept where (1 − u) · (w_0 + ⋯ + w_k) < w_k",
        "kept where u · (w_0 + ⋯ + w_k) < w_k",
        (*INITIAL, *REUSE),
        departure="order",
        u_turned=True,
    ),
)

ESTIMATE_MISTAKES = (
    _known(
        "pair-shown-without-weight",
        "what is shown has not the weight that the target has",
        "contribution = G where H has the sign",
        DELTA,
        ESTIMATE,
        shown="unweighted",
    ),
    _known(
        "pair-weight-of-plus-for-both",
        "both samples are shown with the W of the first",
        "delta = contribution_0 · W_0 + contribution_1 · W_0",
        DELTA,
        ("pair_estimate", "after_estimate"),
        own_weight=False,
    ),
    _known(
        "pair-second-left-out",
        "the first sample alone is shown",
        "delta = contribution_0 · W_0",
        DELTA,
        ("pair_estimate", "after_estimate"),
        plus_alone=True,
    ),
    _known(
        "pair-one-reservoir-read-as-two",
        "a reservoir of both signs is read as that of plus",
        "delta = max(H_0, 0) · W_0 − max(−H_1, 0) · W_1 where reservoirs = one",
        "delta = H_0 · W_0 where reservoirs = one",
        ESTIMATE,
        one_is_both=False,
    ),
)

SHIFT_MISTAKES_OF_PAIRS = (
    _known(
        "inner-shift-to-the-own-pixel",
        "the offset path is that in the base path's own pixel",
        "pixel = first where k = 0, second where k = 1",
        "pixel = second where k = 0, first where k = 1",
        INNER,
        offset_pixel="own",
    ),
    _known(
        "inner-shift-step-not-turned",
        "places of k = 1 move away from the other pixel",
        "x_to = x + dx for both k",
        "x_to = x − dx where k = 1",
        INNER,
        step="forward",
    ),
    _known(
        "inner-shift-place-stays",
        "the offset path is seen through the base path's place",
        "x_to = x",
        "x_to = x ± dx",
        INNER,
        step="none",
    ),
    _known(
        "shift-that-fails-has-a-value",
        "what a shift leaves that does not exist is taken for a path",
        "values as they are where the Jacobian is 0",
        "values are 0 where the Jacobian is 0",
        (*INNER, *OUTER),
        refused=False,
    ),
    _known(
        "outer-shift-to-the-other-pixel",
        "the base path goes to the pixel of the other k",
        "pixel = second where k = 0, first where k = 1",
        "k remains: pixel = first where k = 0, second where k = 1",
        OUTER,
        k_kept=False,
    ),
    _known(
        "outer-shift-offset-carried",
        "the offset path remains that of the pair that the sample comes from",
        "offset = offset_from, inner = inner_from",
        OFFSET,
        (*OUTER, *REUSE),
        rebuilt="nothing",
    ),
    _known(
        "outer-shift-value-carried",
        "the offset path's contribution remains, beside a new Jacobian",
        "offset = offset_from",
        OFFSET,
        (*OUTER, *REUSE),
        rebuilt="jacobian",
    ),
    _known(
        "outer-shift-inner-carried",
        "the inner Jacobian remains, beside a new contribution",
        "inner = inner_from",
        OFFSET,
        (*OUTER, *REUSE),
        rebuilt="value",
    ),
    _known(
        "outer-jacobian-times-inner",
        "the outer Jacobian is multiplied by that of the offset path",
        "jacobian = jacobian_at_k · inner",
        J,
        (*OUTER, *REUSE),
        outer="times inner",
    ),
    _known(
        "outer-jacobian-left-out",
        "the outer shift has no Jacobian",
        "jacobian = 1",
        J,
        (*OUTER, *REUSE),
        outer="none",
        reuse=ReuseRules(jacobian="none", made="none"),
    ),
    _known(
        "outer-jacobian-divides",
        "the outer Jacobian is that of the way back",
        "jacobian = 1 / jacobian_at_k",
        J,
        OUTER,
        outer="over",
    ),
)

REUSE_MISTAKES_OF_PAIRS = (
    _known(
        "pair-reuse-target-of-the-source",
        "a sample has the target of the pair that it comes from",
        "w_k = m_k · target_base_k · W_k · jacobian_k",
        "w_k = m_k · target_here_k · W_k · jacobian_k",
        REUSE,
        reuse=ReuseRules(target_base=True),
    ),
    _known(
        "pair-reuse-jacobian-left-out",
        "the weight of a shifted sample has no Jacobian",
        "w_k = m_k · target_here_k · W_k",
        "w_k = m_k · target_here_k · W_k · jacobian_k",
        REUSE,
        reuse=ReuseRules(jacobian="none"),
    ),
    _known(
        "pair-reuse-pairs-exchanged",
        "in pairwise weights the targets of source and receiver are exchanged",
        "m_k = M_k / T · S p_c(k) / (S p_c(k) + M_c p_k(k))",
        "m_k = M_k / T · S p_k(k) / (S p_k(k) + M_c p_c(k))",
        REUSE,
        reuse=ReuseRules(exchanged=True),
    ),
    _known(
        "pair-reuse-nulls-not-counted",
        "sources without a sample do not count",
        "M_k = 0 where W_k = 0",
        "M_k counts where W_k = 0 too",
        REUSE,
        AUTHORS,
        reuse=ReuseRules(nulls_count=False),
    ),
    _known(
        "pair-reuse-empty-slots-counted",
        "slots without a source count",
        "ΣM_k over all slots",
        "M_k = 0 where there_k = 0",
        REUSE,
        reuse=ReuseRules(empty_count=True),
    ),
    _known(
        "pair-reuse-one-over-m",
        "samples are reused within a sign with 1/M, which asks nobody's support",
        "Z = ΣM_k",
        "Z = Σ M_k of those with p_k(s) > 0",
        REUSE,
        AUTHORS,
        reuse=ReuseRules(replaced=("1/Z", "balance")),
    ),
    _known(
        "pair-reuse-z-of-everybody",
        "Z counts sources that could not have made the sample",
        "Z = Σ M_k",
        "Z = Σ M_k of those with p_k(s) > 0",
        REUSE,
        reuse=ReuseRules(replaced=("1/Z",)),
    ),
    _known(
        "pair-reuse-supports-of-both-signs",
        "others are asked for the magnitude, whatever the sign of their reservoirs",
        "target_at of |H|",
        "target_at of the part that has the sign",
        REUSE,
        inverse_signed=False,
    ),
    _known(
        "pair-reuse-offset-carried-back",
        "others are asked with the offset path that the sample has here",
        "target_at_sq of base_at_sq, offset_s, inner_s",
        "target_at_sq of base_at_sq, offset_at_sq, inner_at_sq",
        REUSE,
        carried_at_others=True,
    ),
    _known(
        "pair-reuse-made-without-jacobian",
        "what a sample was worth is left in the measure of its source",
        "p_s(s) = target_base_s",
        "p_s(s) = target_base_s / jacobian_s",
        REUSE,
        reuse=ReuseRules(made="none"),
    ),
    _known(
        "pair-reuse-canonical-counts-whole",
        "the canonical sample keeps its whole weight beside the others",
        "m_c = 1",
        "m_c = Σ M_k / T · M_c p_c(c) / (S p_k(c) + M_c p_c(c))",
        REUSE,
        reuse=ReuseRules(canonical_share="whole"),
    ),
    _known(
        "pair-reuse-never-capped",
        "confidence grows without limit",
        "M = ΣM_k",
        "M = min(ΣM_k, cap)",
        REUSE,
        departure="confidence",
        reuse=ReuseRules(capped="never"),
    ),
)

EDGE_MISTAKES = (
    _known(
        "edge-normals-above",
        "pairs whose normals agree are edges, as it is printed",
        "normal_a · normal_b > 0.9",
        EDGE,
        EDGES,
        "[Wang25, section 4.3.2]",
        normals="above",
    ),
    _known(
        "edge-normals-either-side",
        "opposite normals look alike",
        "|normal_a · normal_b| < 0.9",
        EDGE,
        EDGES,
        AUTHORS,
        normals="absolute",
    ),
    _known(
        "edge-normals-not-compared",
        "normals are not compared",
        "albedos and depths alone",
        EDGE,
        EDGES,
        normals="ignored",
    ),
    _known(
        "edge-albedo-signed",
        "a pixel is unlike a darker one alone: the pair has an order",
        "albedo_a − albedo_b > 0.1",
        EDGE,
        EDGES,
        AUTHORS,
        albedos="signed",
    ),
    _known(
        "edge-albedo-luminance",
        "colours of one luminance look alike",
        "|luminance of albedo_a − albedo_b| > 0.1",
        EDGE,
        EDGES,
        albedos="luminance",
    ),
    _known(
        "edge-albedo-not-compared",
        "albedos are not compared",
        "normals and depths alone",
        EDGE,
        EDGES,
        albedos="ignored",
    ),
    _known(
        "edge-depth-of-the-first",
        "depths are relative to the first pixel, as it is printed",
        "|depth_a − depth_b| > 0.1 · depth_a",
        EDGE,
        EDGES,
        "[Wang25, section 4.3.2]",
        depths="first",
    ),
    _known(
        "edge-depth-of-the-second",
        "depths are relative to the second pixel",
        "|depth_a − depth_b| > 0.1 · depth_b",
        EDGE,
        EDGES,
        depths="second",
    ),
    _known(
        "edge-depth-in-metres",
        "depths are not relative",
        "|depth_a − depth_b| > 0.1",
        EDGE,
        EDGES,
        depths="absolute",
    ),
    _known(
        "edge-depth-not-compared",
        "depths are not compared",
        "albedos and normals alone",
        EDGE,
        EDGES,
        depths="ignored",
    ),
    _known(
        "edge-all-three",
        "albedo, normal and depth all have to differ",
        "and in place of or",
        EDGE,
        EDGES,
        every=True,
    ),
    _known(
        "edge-lone-pixel-not-asked",
        "a pixel that sees a point beside one that does not is no edge",
        "edge = 0 where one of the two sees nothing",
        "edge = 1 where just one of the two sees a point",
        EDGES,
        lone_hit=False,
    ),
)

SEARCH_MISTAKES = (
    _known(
        "search-first-pixels-compared",
        "pairs are alike whose first pixels are",
        "its first pixel looks like the first",
        ALIKE,
        SEARCH,
        compared="first",
    ),
    _known(
        "search-second-pixels-compared",
        "pairs are alike whose second pixels are",
        "its second pixel looks like the second",
        ALIKE,
        SEARCH,
        compared="second",
    ),
    _known(
        "search-one-pixel-is-enough",
        "pairs are alike of which either pixel is",
        "its first pixel looks like the first, or its second like the second",
        ALIKE,
        SEARCH,
        compared="any",
    ),
    _known(
        "search-pixels-crossed",
        "edges of the other order are alike",
        "its first pixel looks like the second, its second like the first",
        ALIKE,
        SEARCH,
        compared="crossed",
    ),
    _known(
        "search-finds-interior-pairs",
        "the pair found need not be an edge",
        "both its pixels look alike",
        "it is an edge pair, and both its pixels look alike",
        SEARCH,
        edges_alone=False,
    ),
    _known(
        "search-of-interior-pairs",
        "pairs that are no edge look for one too",
        "all pairs look around",
        "neighbor = −1 for pairs that are no edge",
        SEARCH,
        interior=True,
        edges_alone=False,
    ),
    _known(
        "search-last-taken",
        "the last pair that is alike is taken",
        "neighbor = first pixel of the last try that is taken",
        "neighbor = first pixel of the first try that is taken",
        SEARCH,
        taken="last",
    ),
    _known(
        "search-finds-itself",
        "a pair may be its own neighbour: its sample counts twice",
        "q = the middle of the square is taken",
        "it is not the pair itself",
        SEARCH,
        itself=True,
    ),
    _known(
        "search-columns-first",
        "places of the square are counted column by column",
        "(x + floor(q / n) − radius, y + q mod n − radius)",
        "(x + q mod n − radius, y + floor(q / n) − radius)",
        SEARCH,
        square="columns",
    ),
    _known(
        "search-clamped",
        "tries outside of the image are moved to its border",
        "places are clamped",
        "a pair outside of the image is not taken",
        SEARCH,
        border="clamped",
    ),
    _known(
        "search-of-the-other-axis",
        "horizontal pairs look among vertical ones, and the other way round",
        "of the other axis",
        "of the same axis",
        SEARCH,
        other_axis=True,
    ),
)

MOTION_MISTAKES = (
    _known(
        "motion-with-the-farther",
        "the pair moves with the pixel that is farther away",
        "pivot = second where depth_second > depth_first, else first",
        PIVOT,
        MOTION,
        pivot="farther",
    ),
    _known(
        "motion-with-the-first",
        "the pair moves with its first pixel",
        "pivot = first",
        PIVOT,
        MOTION,
        pivot="first",
    ),
    _known(
        "motion-second-where-alike",
        "the second pixel is the pivot where both are alike",
        "pivot = second where depth_second ≤ depth_first, else first",
        PIVOT,
        MOTION,
        pivot="either",
    ),
    _known(
        "motion-with-nothing",
        "a pixel that sees nothing has depth 0, and passes for the nearer one",
        "depths alone are compared",
        "a pixel that sees nothing is the farther one",
        MOTION,
        pivot="depth alone",
    ),
    _known(
        "motion-not-stepped-back",
        "where the second pixel is the pivot, its place is taken for the first's",
        "row = before_second",
        "row = the pixel to the left of before_second, or above it",
        MOTION,
        stepped=False,
    ),
    _known(
        "motion-axes-exchanged",
        "horizontal pairs step back a line, vertical ones a column",
        "the pixel above before_second for axis 0",
        "the pixel to the left of before_second for axis 0",
        MOTION,
        stepped_across=True,
    ),
    _known(
        "motion-out-of-the-image",
        "pairs of the last frame may lead out of the image on its far side",
        "row = before, in the last column or line too",
        "−1 where the second pixel would be outside of the image",
        MOTION,
        border="kept",
    ),
)

IMAGE_MISTAKES = (
    _known(
        "primal-with-emission",
        "emission seen directly is in what the image is solved from",
        "color = value · W + emission",
        "color = value · W, and emission is added to the image",
        ("primal",),
        emission=True,
    ),
    _known(
        "primal-without-weight",
        "the path's contribution is shown without W",
        "color = value",
        "color = value · W",
        ("primal",),
        weighted=False,
    ),
    _known(
        "differences-sign-of-pairs",
        "differences of pairs are taken for forward differences: edges are inverted",
        "dx = delta_x, dy = delta_y",
        "dx = −delta_x, dy = −delta_y",
        ("pair_differences",),
        AUTHORS,
        forward=False,
    ),
    _known(
        "differences-axes-exchanged",
        "differences to the right and down are exchanged",
        "dx is the lower neighbour's, dy the right one's",
        "dx is the right neighbour's, dy the lower one's",
        IMAGES,
        exchanged=True,
    ),
    _known(
        "differences-beyond-the-border",
        "what stands in the last column and line is taken for a difference",
        "dx = −delta_x in the last column, too",
        "0 in the last column for dx, and in the last line for dy",
        ("pair_differences",),
        border_kept=True,
    ),
    _known(
        "differences-backward",
        "differences are those to the pixel before",
        "dx(x, y) belongs to color(x, y) − color(x − 1, y)",
        "dx(x, y) belongs to color(x + 1, y) − color(x, y)",
        ("differences", *SOLVERS),
        differences="backward",
    ),
    _known(
        "differences-of-the-pixel-less-neighbour",
        "differences have the sign of pixel less neighbour",
        "dx = color(x, y) − color(x + 1, y)",
        "dx = color(x + 1, y) − color(x, y)",
        ("differences",),
        differences="reversed",
    ),
    _known(
        "differences-periodic",
        "the neighbour of the last pixel of a line is the first",
        "dx(W − 1, y) = color(0, y) − color(W − 1, y)",
        "0 in the last column and line",
        ("differences",),
        differences="periodic",
    ),
)

SOLVER_MISTAKES = (
    _known(
        "poisson-alpha-not-squared",
        "alpha weighs squares, and not the rows whose squares they are",
        "(alpha + D_xᵀ D_x + D_yᵀ D_y) I = alpha P + D_xᵀ dx + D_yᵀ dy",
        A_L2,
        ("poisson_l2",),
        alpha="plain",
    ),
    _known(
        "poisson-alpha-squared-once-more",
        "alpha is squared once too often",
        "alpha² in place of alpha on the rows of P",
        IMAGE,
        SOLVERS,
        alpha="twice",
    ),
    _known(
        "poisson-alpha-left-out",
        "pixels weigh as much as differences",
        "alpha = 1",
        IMAGE,
        SOLVERS,
        alpha="one",
    ),
    _known(
        "poisson-alpha-on-differences",
        "alpha weighs the differences",
        "|I − P|² + |alpha (D_x I − dx)|² + |alpha (D_y I − dy)|²",
        IMAGE,
        SOLVERS,
        alpha_on="differences",
    ),
    _known(
        "poisson-periodic",
        "the image goes on at its other side",
        "the last pixel of a line is the neighbour of the first",
        "nothing leads out of the image",
        SOLVERS,
        edges="periodic",
    ),
    _known(
        "poisson-black-border",
        "every pixel has four neighbours, of which those outside are black",
        "(alpha² + 4) I − Σ I of the neighbours, at the border too",
        A_L2,
        ("poisson_l2",),
        edges="black",
    ),
    _known(
        "poisson-divergence-sign",
        "the divergence has the wrong sign: edges are inverted",
        "(alpha² + D_xᵀ D_x + D_yᵀ D_y) I = alpha² P − D_xᵀ dx − D_yᵀ dy",
        IMAGE,
        SOLVERS,
        divergence=False,
    ),
    _known(
        "poisson-of-the-luminance",
        "one image is solved, and stands for all channels",
        "P, dx and dy are their luminance",
        "each channel by itself",
        SOLVERS,
        mixed=True,
    ),
    _known(
        "poisson-primal-added",
        "the pixels are added to the image that is solved from them",
        "color = I + P",
        "color = I",
        SOLVERS,
        added=True,
    ),
    _known(
        "poisson-squares-for-absolute-values",
        "least squares are given for least absolute values",
        "the least |alpha (I − P)|² + |D_x I − dx|² + |D_y I − dy|²",
        f"the least {E_L1}",
        ("poisson_l1",),
        norm="squares",
    ),
)

GRADIENT_MISTAKES: tuple[Hypothesis, ...] = (
    *VALUE_MISTAKES,
    *SHARE_MISTAKES,
    *TARGET_MISTAKES,
    *INITIAL_MISTAKES,
    *ESTIMATE_MISTAKES,
    *SHIFT_MISTAKES_OF_PAIRS,
    *REUSE_MISTAKES_OF_PAIRS,
    *EDGE_MISTAKES,
    *SEARCH_MISTAKES,
    *MOTION_MISTAKES,
    *IMAGE_MISTAKES,
    *SOLVER_MISTAKES,
)
