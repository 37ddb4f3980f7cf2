"""For each clause of the contract a way to ignore it: which answers would be others.

A way takes a question, the right answers to it and the precision, and tells which rows
a backend would have wrong that ignores the clause.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from math import cos, pi, radians

import numpy as np

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.contract.weights import MIS
from restir_gi.reference.oracle.diagnosis.diagnose import known_mistakes
from restir_gi.reference.oracle.parts import judge_of
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

PRECISION = "float32"


@dataclass(frozen=True, eq=False)
class AskedCase:
    """A case, and what a right backend gives."""

    case: object
    right: dict

    def wrong(self, outputs=None, rules=CONTRACT_RULES, case=None):
        """Rows that no rounding explains, (N,) bool."""
        judge = judge_of(self.case.pass_name)
        with np.errstate(all="ignore"):
            found = judge(case or self.case, outputs or self.right, rules, PRECISION)
        return found.wrong

    def terms(self, name):
        """A term of the replay of the right answers."""
        judge = judge_of(self.case.pass_name)
        found = judge(self.case, self.right, CONTRACT_RULES, PRECISION)
        return found.terms[name]


def right_answers(case):
    """What the built-in backend gives."""
    with np.errstate(all="ignore"):
        own = getattr(BuiltIn(PRECISION), case.pass_name)
        return own(**case.inputs, **case.settings)


Way = Callable[[AskedCase], np.ndarray]


@cache
def _rules(name):
    return next(h.rules for h in known_mistakes() if h.name == name)


def known(*names: str) -> tuple[Way, ...]:
    """Mistakes that the diagnosis knows: each ignores the clause."""
    return tuple(
        lambda asked, name=name: asked.wrong(rules=_rules(name)) for name in names
    )


def given(**changes) -> tuple[Way, ...]:
    """Backends that see other inputs: each a function of the inputs."""

    def way(asked):
        inputs = dict(asked.case.inputs)
        for name, change in changes.items():
            if name not in inputs:  # given with other settings
                continue
            inputs[name] = change(asked.case.inputs).astype(inputs[name].dtype)
        return asked.wrong(right_answers(replace(asked.case, inputs=inputs)))

    return (way,)


def answered(where, **values) -> tuple[Way, ...]:
    """Backends that answer other numbers in some rows.

    Parameters
    ----------
    where : callable; from what was asked to (N,) bool
    **values : number, or callable from what was asked to an array
    """

    def way(asked):
        rows, outputs = where(asked), dict(asked.right)
        for name, value in values.items():
            found = value(asked) if callable(value) else value
            mask = rows.reshape(rows.shape + (1,) * (outputs[name].ndim - 1))
            outputs[name] = np.where(mask, found, outputs[name]).astype(
                outputs[name].dtype
            )
        return asked.wrong(outputs) & rows

    return (way,)


def set_to(**settings) -> tuple[Way, ...]:
    """Backends that calculate with other settings."""

    def way(asked):
        found = {k: v(asked.case) if callable(v) else v for k, v in settings.items()}
        changed = replace(asked.case, settings={**asked.case.settings, **found})
        return asked.wrong(case=changed)

    return (way,)


def without(*names: str) -> tuple[Way, ...]:
    """Backends that overlook settings which have to be declared."""

    def way(asked):
        kept = {n: v for n, v in asked.case.settings.items() if n not in names}
        if kept == asked.case.settings:
            return np.zeros(asked.case.rows, bool)
        return asked.wrong(right_answers(replace(asked.case, settings=kept)))

    return (way,)


# ------------------------------------------------ what rows are


def _typical(name):
    """A density in place of all."""

    def change(inputs):
        return np.where(inputs[name] > 0, np.float32(1 / (2 * pi)), 0)

    return change


def _toward(inputs, x="visible_position", y="position", normal="visible_normal"):
    v = inputs[y].astype(float) - inputs[x]
    return (inputs[normal] * v).sum(axis=1)


def _below(asked):
    """Below the horizon, lit, and with light that would be reflected."""
    i = asked.case.inputs
    shows = _toward(i, normal="normal") < 0
    return (_toward(i) < 0) & shows & (i["albedo"] * i["radiance"]).any(axis=1)


def _nothing_kept(asked):
    return asked.terms("sum of w") == 0


def _light_in_vain(asked):
    return _nothing_kept(asked) & asked.right["radiance"].any(axis=1)


def _first_has_none(asked):
    first, second = (asked.terms(f"w of slot {k}") for k in (0, 1))
    return (first == 0) & (second > 0)


def _past(name):
    return lambda asked: asked.case.inputs[f"past_{name}"]


def _edge_on(asked):
    i = asked.case.inputs
    sides = [_toward(i, x, "position", "normal") == 0 for x in ("x_from", "x_to")]
    return np.any(sides, axis=0) & ~_touching(asked)


def _touching(asked):
    i = asked.case.inputs
    sides = [(i[x] == i["position"]).all(axis=1) for x in ("x_from", "x_to")]
    return np.any(sides, axis=0)


def _scaled_words(asked):
    return asked.right["words"].astype(float) * 2.0**-32


def _low_bits(asked):
    return (asked.right["words"] & 0xFFFFFF) * 2.0**-24


def everywhere(asked):
    """All rows."""
    return np.ones(asked.case.rows, bool)


def _without(column):
    def change(inputs):
        key = inputs["key"].copy()
        key[:, column] = 0
        return key

    return change


def _zero(*names):
    def where(asked):
        return np.any([asked.case.inputs[n] == 0 for n in names], axis=0)

    return where


# ------------------------------------------------ search for neighbours, plainly


def neighbors(case, rounding=np.rint, halves=True, least=True, clamped=False):
    """Pass ``neighbors``, once more."""
    s, i = case.settings, case.inputs
    width, row = int(s["width"]), np.arange(case.rows)
    height, n = case.rows // width, i["visible_normal"].astype(float)
    floor = float(s["min_radius"])
    radius = np.full(case.rows, max(float(s["radius"]) * width, floor))
    found = []
    for k in range(i["u"].shape[1]):
        u = i["u"][:, k].astype(float)
        reach = radius * np.sqrt(u[:, 0])
        x, y = (
            start + rounding(reach * turn(2 * pi * u[:, 1]))
            for start, turn in ((row % width, np.cos), (row // width, np.sin))
        )
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        if clamped:
            x, y, inside = x.clip(0, width - 1), y.clip(0, height - 1), inside | True
        to = np.where(inside, y * width + x, 0).astype(int)
        z, z_to = (d.astype(float) for d in (i["depth"], i["depth"][to]))
        alike = (n * n[to]).sum(axis=1) >= cos(radians(float(s["max_angle"])))
        alike &= np.abs(z - z_to) <= float(s["max_depth"]) * np.maximum(z, z_to)
        usable = inside & alike & (z > 0) & (z_to > 0)
        found.append(np.where(usable & (to != row), to, -1))
        if halves == "itself too":
            usable = usable & (to != row)
        narrower = np.maximum(radius / 2, floor if least else 0.0)
        radius = np.where(usable | (not halves), radius, narrower)
    return np.stack(found, axis=1).astype(np.int32)


def _where_border(border, *names):
    """Mistakes that are looked for where a border is asked for."""
    return tuple(
        lambda asked, way=way: (
            way(asked) & (asked.case.settings.get("border") == border)
        )
        for way in known(*names)
    )


def _search(**changes):
    def way(asked):
        if {"search", "border"} & {*asked.case.settings}:
            return np.zeros(asked.case.rows, bool)
        return asked.wrong({"neighbors": neighbors(asked.case, **changes)})

    return (way,)


def _itself(asked):
    """The pixel in place of −1."""
    if {"search", "border"} & {*asked.case.settings}:
        return np.zeros(asked.case.rows, bool)
    wrong = neighbors(asked.case)
    itself = asked.case.inputs["u"][:, :, 0] == 0
    seen = (asked.case.inputs["depth"] > 0)[:, None] & itself
    row = np.arange(len(wrong))[:, None]
    return asked.wrong({"neighbors": np.where(seen, row, wrong).astype(np.int32)})


def _in_layout(layout, **values) -> tuple[Way, ...]:
    """Backends that answer other numbers in one layout.

    Parameters
    ----------
    **values : callable, from an output to another one
    """

    def way(asked):
        if asked.case.settings.get("layout", "paper") != layout:
            return np.zeros(asked.case.rows, bool)
        changed = {n: value(asked.right[n]) for n, value in values.items()}
        return asked.wrong(asked.right | changed)

    return (way,)


def _exchanged(one, other):
    """Words of which two change places."""

    def change(words):
        found = words.copy()
        found[:, [one, other]] = words[:, [other, one]]
        return found

    return change


# ------------------------------------------------ the clauses


PLACES_OF_RTXDI = (
    "rtxdi-m-and-age-exchanged",
    "rtxdi-misc-below",
    "rtxdi-w-before-radiance",
    "rtxdi-normal-last",
)
PLACES_OF_PATHS = (
    "rtxdi-path-m-below-z",
    "rtxdi-path-density-before-jacobian",
    "rtxdi-path-target-before-radiance",
    "rtxdi-path-lengths-exchanged",
    "rtxdi-path-age-above",
    "rtxdi-path-boosts-in-bit-5",
)


def _for_declared(way):
    """The same where a weight is asked for that has to be declared."""

    def found(asked):
        declared = asked.case.settings.get("mis") in MIS.more
        return way(asked) if declared else np.zeros(asked.case.rows, bool)

    return found


TARGET = known("target-always-scattered", "target-always-outgoing")


def _calculated(asked):
    """As if the target were that of Equation 10."""
    if "p_hat_given" not in asked.case.inputs:
        return np.zeros(asked.case.rows, bool)
    inputs = {n: a for n, a in asked.case.inputs.items() if n != "p_hat_given"}
    settings = {**asked.case.settings, "target": "outgoing"}
    other = replace(asked.case, inputs=inputs, settings=settings)
    return asked.wrong(case=other)


GIVEN = (_calculated,)
STREAM = {
    "the target is the one that is asked for": TARGET,
    "a target that is given is taken as it is": GIVEN,
    "W is divided by the target of what is kept": known("target-of-the-first"),
    "M is capped when it is stored": known("never-capped", "cap-off-by-one"),
    "M counts where nothing is kept": answered(_nothing_kept, M=0),
    "W = 0 where nothing is kept although there is light": answered(
        _light_in_vain, W=1
    ),
}
TEMPORAL = STREAM | {
    "the past has w₀ = p̂ W₀ M₀": known(
        "confidence-missing-in-weight",
        "target-missing-in-weight",
        "dropped-where-w-large",
    ),
    "the new sample has the density of its row": (
        *known("density-left-out", "density-multiplied"),
        *given(new_pdf=_typical("new_pdf")),
    ),
    "w₁ = 0 where pdf is 0": given(
        new_pdf=lambda i: np.where(i["new_pdf"] == 0, 1, i["new_pdf"])
    ),
    "the new sample is kept where u (w₀ + w₁) < w₁": known(
        "accepts-by-the-old-sum", "keeps-the-other-side", "always-accepts"
    ),
    "the new sample is kept where w₀ = 0 < w₁": answered(
        _first_has_none,
        **{name: _past(name) for name in ("position", "normal", "radiance")},
    ),
    "Z counts both, before the cap": known("capped-before-weight", "first-not-counted"),
    "nulls count, in the past and now": known(
        "nulls-not-counted", "reused-nulls-not-counted"
    ),
    "an empty past does not count": known("empty-counts"),
}
AT_REST = {
    "the defensive weight leaves the new sample a share": known(
        "defensive-without-share", "one-over-z-where-defensive"
    ),
}
SHIFTED = {
    "w has the Jacobian of the shift": known(
        "jacobian-omitted",
        "jacobian-inverted",
        "jacobian-unsquared",
        "jacobian-without-cosines",
    ),
    "J is not limited": known(
        "jacobian-clamped-to-3", "jacobian-at-most-10", "jacobian-rejected-beyond-10"
    ),
    "w = 0 where the receiver does not see the sample": known(
        "visibility-missing-in-weight"
    ),
    "M of what is not seen counts": known("hidden-not-counted"),
    "w = 0 below the horizon and where the back is seen": known(
        "light-below-the-horizon", "back-of-sample-shines"
    ),
    "the sum is divided as it is asked for": known("one-over-m", "one-over-z-where-m"),
    "the domain asks the horizon of the source": known(
        "receivers-target-in-z", "horizon-missing-in-z"
    ),
    "the domain asks on which side the sample shines": known("side-missing-in-z"),
    "the domain asks what the source sees": known("visibility-missing-in-z"),
    "the domain asks the view of the source": known(
        "view-of-the-receiver-in-the-domain"
    ),
    "who made the sample is in the domain": known("maker-missing-in-z"),
    "a declared weight is the one that is asked for": known(
        *(f"one-over-z-where-{asked}" for asked in MIS.more),
        *(f"one-over-m-where-{asked}" for asked in MIS.more),
    ),
    "a declared weight asks the target of the source": tuple(
        _for_declared(way) for way in known("receivers-target-in-z")
    ),
    "a declared weight compares densities in the receiver's measure": known(
        "mis-weights-without-jacobian"
    ),
}


def _scatters(where):
    """Of passes that evaluate f: mistakes of that pass."""
    return {
        "a declared surface has its lobe beside the diffuse part": known(
            f"{where}-lobe-left-out", f"{where}-diffuse-left-out"
        ),
        "a declared surface takes F at the half vector": known(
            f"{where}-fresnel-at-the-normal", f"{where}-fresnel-left-out"
        ),
        "a declared surface is 0 where the view is below the horizon": known(
            f"{where}-diffuse-seen-from-below"
        ),
    }


def _nothing_arrives(asked):
    return asked.right["W"] == 0


SUPPORTS = "pair-reuse-one-over-m", "pair-reuse-z-of-everybody"
CARRIED = (
    "outer-shift-offset-carried",
    "outer-shift-value-carried",
    "outer-shift-inner-carried",
)
SOLVED = {
    "nothing leads out of the image": known("poisson-periodic"),
    "alpha is on the pixels": known("poisson-alpha-on-differences"),
    "differences are to the right and down": known(
        "differences-backward", "poisson-divergence-sign"
    ),
}

LIKENESS = {
    "declared thresholds are those that are given": without(
        "thresholds", "most_albedo", "least_cosine", "most_depth"
    ),
    "declared normals may be turned round": without("normals"),
}

PAIR_WAYS: dict[str, dict[str, tuple[Way, ...]]] = {
    "pair_value": {
        "the offset path has the Jacobian once": known(
            "pair-inner-jacobian-left-out",
            "pair-inner-jacobian-divides",
            "pair-inner-jacobian-twice",
        ),
        "k = 1 turns the sign": known("pair-second-sign-not-turned"),
        "the difference is that of i less j": known("pair-difference-reversed"),
        "a base path alone counts": known("pair-alone-dropped"),
    },
    "pair_weight": {
        "both ways to draw the two paths share": known(
            "pair-weight-one-half", "pair-weight-left-out", "pair-weight-of-the-offset"
        ),
        "the offset path's density has the Jacobian": known(
            "pair-weight-without-jacobian", "pair-weight-over-jacobian"
        ),
        "1 without an offset path": known("pair-alone-halved"),
        "0 where the base path cannot be": answered(_zero("p_base"), omega=1),
    },
    "pair_target": {
        "H has the weight of the base path": known(
            "pair-weight-left-out", "pair-target-unweighted", "pair-weight-one-half"
        ),
        "reservoirs of a sign have that part alone": known(
            "pair-target-of-both-signs", "pair-parts-exchanged"
        ),
        "the negative part is negative": known("pair-negative-part-added"),
        "each channel is split by itself": known("pair-split-by-luminance"),
        "magnitudes are taken before the luminance": known(
            "pair-target-of-the-sum", "pair-target-of-the-part"
        ),
    },
    "pair_initial": {
        "each candidate has the weight 1": known("pair-candidates-halved"),
        "two candidates count as one": known(
            "pair-candidates-count-twice", "pair-divided-by-candidates"
        ),
        "nulls count": known("pair-nulls-not-counted"),
        "the target is that of the reservoir's sign": known(
            "pair-target-of-both-signs", "pair-target-of-the-sum"
        ),
        "W is divided by the target of what is kept": known("pair-target-of-the-first"),
        "u decides as in every stream": known("pair-u-turned"),
        "W = 0 where no weight arrives": answered(_nothing_arrives, W=1),
    },
    "inner_shift": {
        "the offset path is in the other pixel": known("inner-shift-to-the-own-pixel"),
        "its place moves from the base path's pixel to the other": known(
            "inner-shift-step-not-turned", "inner-shift-place-stays"
        ),
        "0 where the shift does not exist": known("shift-that-fails-has-a-value"),
    },
    "outer_shift": {
        "k remains": known("outer-shift-to-the-other-pixel"),
        "the Jacobian is that of the base path alone": known(
            "outer-jacobian-times-inner",
            "outer-jacobian-left-out",
            "outer-jacobian-divides",
        ),
        "the offset path is rebuilt": known(*CARRIED),
        "0 where the base path has no place": known("shift-that-fails-has-a-value"),
    },
    "pair_reuse": {
        "the target is that of the pair and sign here": known(
            "pair-reuse-target-of-the-source", "pair-target-of-both-signs"
        ),
        "the offset path is the one rebuilt here": known(*CARRIED),
        "the outer Jacobian is that of the base path alone": known(
            "outer-jacobian-times-inner", "outer-jacobian-left-out"
        ),
        "supports are those of the sign": known(
            *SUPPORTS, "pair-reuse-supports-of-both-signs"
        ),
        "what others could make is asked with their offset paths": known(
            "pair-reuse-offset-carried-back"
        ),
        "the sum is divided as it is asked for": known(
            "pair-reuse-one-over-m",
            "pair-reuse-made-without-jacobian",
            "pair-reuse-canonical-counts-whole",
        ),
        "nulls count": known("pair-reuse-nulls-not-counted"),
        "slots without a source do not count": known("pair-reuse-empty-slots-counted"),
        "M is capped on the way out": known("pair-reuse-never-capped"),
        "u decides as in every stream": known("pair-u-turned"),
        "W = 0 where no weight arrives": answered(_nothing_arrives, W=1),
    },
    "pair_estimate": {
        "each reservoir adds the part of its sign": known(
            "pair-whole-in-each-sign", "pair-parts-exchanged", "pair-shown-by-luminance"
        ),
        "the negative part is subtracted": known("pair-negative-part-added"),
        "each sample has the W of its reservoir": known("pair-weight-of-plus-for-both"),
        "the contribution has the weight of the base path": known(
            "pair-shown-without-weight", "pair-weight-one-half"
        ),
        "one reservoir stands for both signs": known("pair-one-reservoir-read-as-two"),
    },
    "after_estimate": {
        "targets stand in the place of densities": known("after-densities-for-targets"),
        "the offset path's target has the Jacobian": known(
            "pair-weight-without-jacobian", "pair-weight-over-jacobian"
        ),
        "both paths are added, with the sign of k": known(
            "pair-second-left-out", "pair-second-sign-not-turned"
        ),
        "each path has its own W": known("pair-weight-of-plus-for-both"),
    },
    "edge_pair": LIKENESS
    | {
        "any channel of the albedo, in absolute value": known(
            "edge-albedo-signed", "edge-albedo-luminance", "edge-albedo-not-compared"
        ),
        "a cosine below 0.9": known(
            "edge-normals-above",
            "edge-normals-either-side",
            "edge-normals-not-compared",
        ),
        "depths relative to the larger one": known(
            "edge-depth-of-the-first",
            "edge-depth-of-the-second",
            "edge-depth-in-metres",
            "edge-depth-not-compared",
        ),
        "any of the three is enough": known("edge-all-three"),
        "1 where one pixel alone sees a point": known("edge-lone-pixel-not-asked"),
        "0 where none does": answered(
            lambda a: (a.case.inputs["hit_a"] == 0) & (a.case.inputs["hit_b"] == 0),
            edge=1,
        ),
    },
    "pair_search": LIKENESS
    | {
        "pairs that are no edge have none": known("search-of-interior-pairs"),
        "the pair found is an edge as well": known("search-finds-interior-pairs"),
        "both pixels are compared, in their order": known(
            "search-first-pixels-compared",
            "search-second-pixels-compared",
            "search-one-pixel-is-enough",
            "search-pixels-crossed",
        ),
        "the first that is alike is taken": known("search-last-taken"),
        "the pair itself is not": known("search-finds-itself"),
        "the places of the square are counted line by line": known(
            "search-columns-first"
        ),
        "tries outside of the image are lost": known("search-clamped"),
        "of the same axis": known("search-of-the-other-axis"),
    },
    "pair_motion": {
        "the nearer pixel is the pivot": known(
            "motion-with-the-farther", "motion-with-the-first"
        ),
        "a pixel that sees nothing is the farther one": known("motion-with-nothing"),
        "the first where both are alike": known("motion-second-where-alike"),
        "the pair is where its pivot was": known(
            "motion-not-stepped-back", "motion-axes-exchanged"
        ),
        "−1 where the pivot was nowhere": answered(
            lambda a: (
                (a.case.inputs["before_first"] < 0)
                & (a.case.inputs["before_second"] < 0)
            ),
            row=0,
        ),
        "−1 where the pair would lead out of the image": known(
            "motion-out-of-the-image"
        ),
    },
    "primal": {
        "the path has its W": known("primal-without-weight"),
        "emission seen directly is added later": known("primal-with-emission"),
    },
    "pair_differences": {
        "the sign turns": known("differences-sign-of-pairs"),
        "axes are not exchanged": known("differences-axes-exchanged"),
        "0 at the last column and line": known("differences-beyond-the-border"),
    },
    "differences": {
        "neighbour less pixel": known(
            "differences-backward", "differences-of-the-pixel-less-neighbour"
        ),
        "axes are not exchanged": known("differences-axes-exchanged"),
        "0 at the last column and line": known("differences-periodic"),
    },
    "poisson_l2": SOLVED
    | {
        "nothing leads out of the image": known(
            "poisson-periodic", "poisson-black-border"
        ),
        "alpha is squared": known(
            "poisson-alpha-not-squared",
            "poisson-alpha-squared-once-more",
            "poisson-alpha-left-out",
        ),
        "axes are not exchanged": known("differences-axes-exchanged"),
        "the sign of the divergence": known("poisson-divergence-sign"),
        "channels are solved by themselves": known(
            "poisson-of-the-luminance", "poisson-primal-added"
        ),
    },
    "poisson_l1": SOLVED
    | {
        "a declared norm is that of each channel": without("norm"),
        "absolute values, not squares": known("poisson-squares-for-absolute-values"),
        "alpha is not squared": known(
            "poisson-alpha-squared-once-more", "poisson-alpha-left-out"
        ),
        "E is near its minimum": answered(
            everywhere, color=lambda a: a.case.inputs["primal"]
        ),
    },
}


WAYS: dict[str, dict[str, tuple[Way, ...]]] = {
    "random": {
        "each word of the key changes the numbers": tuple(
            way for word in range(4) for way in given(key=_without(word))
        ),
        "u takes the upper 24 bits of a word": (
            *answered(everywhere, u=_scaled_words),
            *answered(everywhere, u=_low_bits),
        ),
    },
    "direction": {
        "the cosine with the normal is that of the source": known(
            "directions-of-the-other-sampler", "direction-root-forgotten"
        ),
        "the density is that of the source": known(
            "density-of-the-other-sampler", "uniform-density-for-cosine"
        ),
        "the azimuth is 2π u₁": known("half-of-the-azimuths", "azimuth-in-turns"),
        "directions leave on the side of the normal": known("normal-points-inward"),
    },
    "target": {
        "scattered has albedo, cos θ and 1/π": known(
            "target-without-albedo", "target-without-cosine", "target-without-pi"
        ),
        "outgoing has none of them": known("target-always-scattered"),
        "luminance has the weights of Rec. 709": known(
            "luminance-of-rec-601", "mean-of-channels"
        ),
        "0 where the sample is below the horizon": known(
            "light-below-the-horizon", "outgoing-without-horizon"
        ),
        "0 where the sample shows its back": known("back-of-sample-shines"),
        **_scatters("target"),
    },
    "jacobian": {
        "the cosines are those at x_s, the receiver's above": known(
            "jacobian-without-cosines",
            "jacobian-cosines-upside-down",
        ),
        "the distances are squared, the source's above": known(
            "jacobian-unsquared", "jacobian-distances-upside-down"
        ),
        "J is not limited": known(
            "jacobian-clamped-to-3",
            "jacobian-at-most-10",
            "jacobian-rejected-beyond-10",
        ),
        "the back of the patch counts as its front": known("jacobian-cut-at-the-back"),
        "0 where cos φ_from or cos φ_to is 0": answered(_edge_on, jacobian=1),
        "0 where points touch": answered(_touching, jacobian=1),
    },
    "merge": {
        "the second is kept where u (w_a + w_b) < w_b": known(
            "accepts-by-the-old-sum", "keeps-the-other-side", "always-accepts"
        ),
        "a weight is kept beside 0, whatever u is": answered(
            lambda a: (a.case.inputs["w_a"] == 0) & (a.case.inputs["w_b"] > 0),
            second=0,
        ),
        "a weight of 0 is never kept beside another": answered(
            lambda a: (
                (a.case.inputs["w_b"] == 0)
                & (a.case.inputs["u"] == 0)
                & (a.case.inputs["w_a"] > 0)
            ),
            second=1,
        ),
        "w and M are sums, M of what has no weight too": (
            *known("sum-of-weights-lost", "confidence-lost"),
            *answered(_zero("w_b"), M=lambda a: a.case.inputs["M_a"]),
        ),
    },
    "finalize": {
        "w is divided by Z and by p̂": known(
            "not-normalized", "not-divided-by-target", "normalized-twice"
        ),
        "W is not limited": known("weight-cut-at-10"),
        "0 where p̂ is 0": answered(_zero("p_hat"), W=1),
        "0 where Z is 0": answered(_zero("Z"), W=1),
    },
    "similar": {
        "the normals differ by max_angle at most": set_to(max_angle=180.0),
        "the depths differ by max_depth of the larger at most": (
            *set_to(max_depth=10.0),
            *known("depth-relative-to-own"),
        ),
        "0 where a depth is 0": answered(
            lambda a: (a.case.inputs["depth_a"] == 0) & (a.case.inputs["depth_b"] == 0),
            similar=1,
        ),
    },
    "initial": {
        "the target is the one that is asked for": TARGET,
        "a target that is given is taken as it is": GIVEN,
        "W has the density of its row": (
            *known("density-left-out", "density-multiplied"),
            *given(pdf=_typical("pdf")),
        ),
        "nulls count": known("nulls-not-counted"),
        "W = 0 where pdf is 0": answered(
            lambda a: (a.case.inputs["pdf"] == 0) & (a.right["p_hat"] > 0), W=1
        ),
        "W = 0 where p̂ is 0 although there is light": answered(
            lambda a: (a.right["p_hat"] == 0) & a.case.inputs["radiance"].any(axis=1),
            W=1,
        ),
    },
    "temporal": TEMPORAL | AT_REST,
    "moved": TEMPORAL
    | SHIFTED
    | {
        "the domain asks the albedo of the source": given(
            past_albedo=lambda i: np.ones_like(i["past_albedo"])
        ),
    },
    "neighbors": {
        "the radius is a share of the width": set_to(
            radius=lambda case: 0.5 * case.settings.get("radius", 0.0)
        ),
        "offsets are uniform on the disk": given(u=lambda i: i["u"] ** [2, 1]),
        "offsets are rounded to the nearest whole": (
            *_search(rounding=np.floor),
            *_search(rounding=np.trunc),
        ),
        "−1 outside of the image": _search(clamped=True),
        "−1 where the pixel is not similar": (
            *set_to(max_angle=180.0),
            *set_to(max_depth=10.0),
            *known("depth-relative-to-own"),
        ),
        "the radius halves after a failure": known("radius-not-halved"),
        "the radius does not fall below the least": _search(least=False),
        "the pixel itself is −1": (_itself,),
        "the pixel itself does not halve the radius": _search(halves="itself too"),
        "the offsets of a table are taken as they are": known(
            "table-columns-and-rows-exchanged",
            "table-offsets-subtracted",
            "table-rows-upwards",
        ),
        "places outside are clamped, if that is asked": _where_border(
            "clamped", "border-refused", "border-mirrored", "border-wrapped"
        ),
        "places outside are mirrored, if that is asked": _where_border(
            "mirrored",
            "border-refused",
            "border-clamped",
            "border-mirrored-about-centers",
            "border-mirrored-about-edges",
        ),
    },
    "spatial": STREAM
    | SHIFTED
    | {
        "reused samples have w = p̂ W M": known(
            "confidence-missing-in-weight",
            "target-missing-in-weight",
            "dropped-where-w-large",
            "neighbors-counted-double",
        ),
        "the stream is past, own and neighbours in order": known(
            "stream-reversed", "canonical-not-merged"
        ),
        "each decision has a number of its own": known(
            "one-number-for-all-neighbors", "one-number-for-all-decisions"
        ),
        "a candidate is kept where u (w_before + w) < w": known(
            "accepts-by-the-old-sum", "keeps-the-other-side", "always-accepts"
        ),
        "Z adds the M of each, before the cap": known(
            "capped-before-weight", "last-confidence-in-z", "one-each-in-z"
        ),
        "nulls count": known("reused-nulls-not-counted"),
        "empty rows do not count": known("empty-counts"),
        "a neighbour −1 has no weight and no M": known(
            "rejected-counted", "none-is-pixel-0"
        ),
        "past and own are always in the domain": known("canonical-missing-in-z"),
        "the domain asks the albedo of the source": given(
            albedo=lambda i: np.ones_like(i["albedo"])
        ),
    },
    "fused": STREAM
    | SHIFTED
    | {
        "reused samples have w = p̂ W M": known(
            "confidence-missing-in-weight",
            "target-missing-in-weight",
            "dropped-where-w-large",
            "neighbors-counted-double",
        ),
        "the stream is own, then the sources in order": known(
            "stream-reversed", "neighbors-turned", "canonical-not-merged"
        ),
        "each decision has a number of its own": known("one-number-for-all-neighbors"),
        "a candidate is kept where u (w_before + w) < w": known(
            "accepts-by-the-old-sum", "keeps-the-other-side", "always-accepts"
        ),
        "Z adds the M of each, before the cap": known(
            "capped-before-weight", "last-confidence-in-z", "one-each-in-z"
        ),
        "nulls count": known("reused-nulls-not-counted"),
        "empty rows do not count": known("empty-counts"),
        "a source −1 has no weight and no M": known(
            "rejected-counted", "none-is-pixel-0"
        ),
        "own is always in the domain": known("canonical-missing-in-z"),
        "the source is the past's point, not the pixel of its row": known(
            "sources-of-this-frame"
        ),
        "the domain asks the albedo of the source": given(
            past_albedo=lambda i: np.ones_like(i["past_albedo"])
        ),
    },
    "shade": {
        "the integrand has albedo, cos θ and 1/π": known(
            "shade-without-albedo", "shade-without-cosine", "shade-without-pi"
        ),
        "the integrand is multiplied by W": known("shade-without-weight"),
        "0 where the sample is below the horizon": answered(_below, color=1),
        "0 where the sample shows its back": known("shade-back-of-sample"),
        "0 where the sample is not seen, if that is asked": known(
            "shade-visibility-ignored", "shade-visibility-turned"
        ),
        **_scatters("shade"),
    },
    "gbuffer": {
        "rays go through the centres of pixels": known("pixel-corner"),
        "y counts downwards, x to the right": known(
            "image-upside-down", "image-mirrored"
        ),
        "the angle of view is the horizontal one": known("angle-of-the-height"),
        "up is made orthogonal to the view": known("up-as-it-is"),
        "the depth is along the axis": known("distance-for-depth"),
        "nothing behind the pinhole is hit": known("behind-the-camera"),
        "the normal is turned to the side that is seen": known("normal-not-turned"),
        "triangles are met from both sides": known("back-faces-not-met"),
        "all is 0 where there is no hit": answered(
            lambda a: a.right["hit"] == 0, depth=1
        ),
    },
    "reproject": {
        "the place is cut off to a whole pixel": known(
            "place-rounded", "place-half-a-pixel-aside"
        ),
        "places outside of the image have no row": known(
            "place-clamped", "place-beyond-the-border", "place-truncated"
        ),
        "points behind the pinhole have no row": known("behind-the-camera"),
        "misses have no row": known("misses-go-on"),
        "the normal is that of the place before": known(
            "own-pixel-tested", "normals-not-tested"
        ),
        "the depth is that of the place before": known(
            "own-depth-tested", "similarity-not-tested"
        ),
        "the depths differ by max_depth of the larger at most": known(
            "place-depth-relative-to-own"
        ),
        "the angle of view is the horizontal one": known("angle-of-the-height"),
        "up is made orthogonal to the view": known("up-as-it-is"),
    },
    "validation": {
        "the tolerance is relative to the larger luminance": known(
            "validation-absolute",
            "validation-relative-to-then",
            "validation-relative-to-now",
        ),
        "luminance has the weights of Rec. 709": known(
            "filters-by-rec-601", "validation-by-channels"
        ),
        "samples that became darker, and brighter, are cleared": known(
            "validation-of-darker-alone", "validation-of-brighter-alone"
        ),
        "nulls stay": known("validation-clears-nulls", "validation-asks-nulls"),
        "a sample that is no longer met is cleared": known("validation-without-ray"),
        "M is cleared too": known("validation-keeps-m"),
    },
    "boiling": {
        "light is luminance times W": known("boiling-by-w-alone", "boiling-without-w"),
        "luminance has the weights of Rec. 709": known("filters-by-rec-601"),
        "the mean is that of pixels with light": known("boiling-mean-over-all"),
        "tiles have 16 × 16 pixels and are cut off": known(
            "boiling-tiles-of-8", "boiling-mean-of-the-image"
        ),
        "the limit has the strength in both factors": known(
            "boiling-limit-not-divided"
        ),
        "M is cleared too": known("boiling-keeps-m"),
    },
    "checkerboard": {
        "the half changes from frame to frame": known(
            "checkerboard-stands-still", "checkerboard-other-half"
        ),
        "rows and columns take turns": known(
            "checkerboard-of-columns", "checkerboard-of-pixel-numbers"
        ),
        "pixels without history draw": known("checkerboard-without-history"),
    },
    "roulette": {
        "tiles decide together, and are cut off at the right": known(
            "roulette-by-pixels", "roulette-tiles-rounded-down"
        ),
        "the frame and the seed are in the key": (
            *known("roulette-stands-still"),
            *set_to(seed=5),
        ),
        "what goes on is divided by the probability": known("roulette-not-divided"),
        "u = probability does not go on": set_to(
            probability=lambda case: case.settings["probability"] * (1 + 2.0**-20)
        ),
    },
    "pack": {
        "the fields stand in their places": known(
            "v-before-u", "m-before-blue", "seed-before-w", "halves-from-above"
        ),
        "the lower half of normals is folded": known("octahedron-not-folded"),
        "normals are divided by |x| + |y| + |z|": known("octahedron-not-divided"),
        "the sign of 0 is +1": known("sign-of-0-is-0"),
        "numbers are rounded to nearest": known(
            "pack-halves-toward-0", "pack-normals-toward-0"
        ),
        "what is too large becomes the largest": known(
            "pack-halves-overflow", "pack-m-wraps"
        ),
        "small halves are kept": known("small-halves-are-0"),
        "a positive M becomes 1 at least": known("pack-m-becomes-0"),
        "restir_pt: the last word is the age": _in_layout(
            "restir_pt", words=_exchanged(10, 11)
        ),
        "rtxdi: the fields stand in their places": known(*PLACES_OF_RTXDI),
        "rtxdi: M and age are 255 at most": known(
            "rtxdi-m-runs-over",
            "rtxdi-m-wraps",
            "rtxdi-age-runs-over",
            "rtxdi-age-wraps",
        ),
        "rtxdi: the application's bits are kept": known("rtxdi-misc-left-out"),
        "rtxdi: L is a logarithm to the base 2": known("log-luv-natural"),
        "rtxdi: level and chromaticities are rounded down": known("log-luv-rounded"),
        "rtxdi: u′ stands above v′": known("log-luv-v-first"),
        "rtxdi_path: the fields stand in their places": known(*PLACES_OF_PATHS),
        "rtxdi_path: a component of 0 has the code 32767": known(
            "rtxdi-path-normal-with-sign"
        ),
        "rtxdi_path: components are rounded to nearest": known(
            "rtxdi-path-normals-cut"
        ),
        "rtxdi_path: M is a half, 65504 at most": known(
            "rtxdi-path-m-overflows", "rtxdi-path-m-is-a-count"
        ),
        "rtxdi_path: of an age five bits are kept": known(
            "rtxdi-path-age-runs-over", "rtxdi-path-age-stops"
        ),
        "rtxdi_path: a light that was sampled has an infinite red": (
            *known("rtxdi-path-light-not-marked"),
            *_in_layout("rtxdi_path", words=_exchanged(9, 10)),
        ),
    },
    "unpack": {
        "the fields stand in their places": known(
            "v-before-u", "m-before-blue", "seed-before-w", "halves-from-above"
        ),
        "the lower half of normals is folded": known("octahedron-not-folded"),
        "codes have a sign, and −32768 is −32767": known(
            "unpack-without-sign", "octahedron-by-32768"
        ),
        "M has no sign": known("unpack-m-with-sign"),
        "normals are made unit vectors": known("unpack-not-normalized"),
        "small halves are kept": known("small-halves-are-0"),
        "infinity is the largest number, NaN is 0": answered(
            lambda a: np.abs(a.right["radiance"]).max(axis=1) >= np.float32(65504),
            radiance=0,
        ),
        "restir_pt: the last word is the age": _in_layout(
            "restir_pt", age=lambda age: age + np.uint32(1)
        ),
        "rtxdi: the fields stand in their places": known(*PLACES_OF_RTXDI),
        "rtxdi: a cell is read at its middle": known("log-luv-without-half"),
        "rtxdi: L is a logarithm to the base 2": known("log-luv-natural"),
        "rtxdi: u′ stands above v′": known("log-luv-v-first"),
        "rtxdi: channels are 0 at least": known("log-luv-negative"),
        "rtxdi_path: the fields stand in their places": known(*PLACES_OF_PATHS),
        "rtxdi_path: a component of 0 has the code 32767": known(
            "rtxdi-path-normal-with-sign"
        ),
        "rtxdi_path: normals are made unit vectors": known(
            "rtxdi-path-normals-not-normalized"
        ),
        "rtxdi_path: M is a half": known("rtxdi-path-m-is-a-count"),
        "rtxdi_path: an age has five bits": known("rtxdi-path-age-not-masked"),
        "rtxdi_path: an infinite red stands for a light": known(
            "rtxdi-path-light-not-marked"
        ),
    },
    "path_reuse": {
        "the weight has the Jacobian once": known(
            "reuse-jacobian-left-out", "reuse-jacobian-divides", "reuse-jacobian-twice"
        ),
        "the target is that at the receiver": known("reuse-target-of-the-donor"),
        "nulls count": known("reuse-nulls-not-counted"),
        "slots without a source do not count": known("reuse-empty-slots-counted"),
        "the sum is divided as it is asked for": known(
            "reuse-one-over-m", "reuse-z-for-balance", "reuse-balance-for-z"
        ),
        "only those count in 1/Z that could have made the sample": known(
            "reuse-z-of-everybody", "reuse-maker-not-in-z"
        ),
        "the maker's target is brought into the receiver's measure": known(
            "reuse-made-without-jacobian",
            "reuse-made-times-jacobian",
            "reuse-made-at-the-receiver",
        ),
        "pairs compare source and receiver": known(
            "reuse-pairs-exchanged",
            "reuse-pairs-canonical-in-s",
            "reuse-pairs-times-confidence",
            "reuse-pairs-divided-again",
        ),
        "the canonical sample has its share": known(
            "reuse-canonical-counts-whole",
            "reuse-canonical-forgotten",
            "reuse-defensive-without-canonical",
        ),
        "M is capped on the way out, and nothing else": known(
            "reuse-never-capped",
            "reuse-capped-beforehand",
            "reuse-capped-in-weights-alone",
            "reuse-w-capped-with-m",
        ),
        "u decides as in every stream": known("reuse-u-turned"),
        "W = 0 where no weight arrives": answered(lambda a: a.right["W"] == 0, W=1),
    },
    "cell_base": {
        "the whole field of view, in radians": known(
            "cell-base-in-degrees", "cell-base-of-half-the-field"
        ),
        "the larger of the two quotients counts": known(
            "cell-base-of-the-smaller-quotient"
        ),
        "the height is told from the width": known("cell-base-of-the-other-side"),
        "a cell is seen under 45 degrees at most": known("cell-base-not-bounded"),
    },
    "cell_level": {
        "the level is rounded down": known(
            "cell-level-rounded-up", "cell-level-to-the-nearest"
        ),
        "the smallest cells have an edge of a millimetre": known(
            "cell-level-in-metres"
        ),
        "no level is below 0": known("cell-level-below-0"),
        "the distance is that from the eye": known("cell-level-from-the-origin"),
        "a look-up has the eye and the base of the frame that built the grid": known(
            "cell-level-by-this-eye"
        ),
    },
    "cell_jitter": {
        "the point stays in its tangent plane": known(
            "cell-jitter-in-the-ground-plane"
        ),
        "it moves by up to √2 edges": known(
            "cell-jitter-without-root-2", "cell-jitter-by-half"
        ),
        "it moves to both sides": known("cell-jitter-one-sided"),
        "each tangent has a number of its own": known("cell-jitter-along-a-diagonal"),
    },
    "cell_key": {
        "positions are rounded down, below 0 too": known(
            "cell-key-truncated", "cell-key-rounded"
        ),
        "the edge is a millimetre times a power of two": known(
            "cell-key-in-metres", "cell-key-edge-grows-evenly"
        ),
        "the normal is told apart in as many parts as are asked for": known(
            "cell-key-without-normal"
        ),
        "the x of the normal counts in units, the z in squares": known(
            "cell-key-normal-turned"
        ),
    },
    "cell_hash": {
        "the fields are nested in their order": known(
            "cell-hash-z-y-x",
            "cell-hash-without-level",
            "cell-hash-without-facing",
            "cell-hash-combined",
        ),
        "negative coordinates keep their bits": known("cell-hash-of-negatives-as-0"),
        "the checksum is another hash": known(
            "cell-checksum-is-the-hash", "cell-hashes-exchanged"
        ),
        "the checksum is at least 1": known("cell-checksum-may-be-0"),
    },
    "cell_insert": {
        "the vertices of a cell share a slot": known(
            "cell-insert-a-slot-each", "cell-insert-of-winners-alone"
        ),
        "cells of a bucket have slots of their own": known(
            "cell-insert-without-checksum", "cell-insert-into-the-last-slot"
        ),
        "all 16 slots of a bucket are used, without holes": (
            *known(
                "cell-insert-leaves-out-the-last-slot", "cell-insert-tries-one-slot"
            ),
            *answered(
                lambda a: (a.right["slot"] >= 0) & (a.right["slot"] % 16 == 0),
                slot=lambda a: a.right["slot"] + 15,
            ),
        ),
        "a vertex is lost where its bucket is full, and nowhere else": (
            *known("cell-insert-goes-on-in-the-next-bucket"),
            *answered(lambda a: a.right["slot"] % 16 == 1, slot=-1),
        ),
        "vertices that are not active have no slot": known("cell-insert-of-everybody"),
    },
    "cell_count": {
        "counters begin at 0": known("cell-counters-not-cleared"),
        "places begin at 0": known("cell-places-from-1"),
        "each place is given once": answered(
            lambda a: a.right["place"] > 0, place=lambda a: a.right["place"] - 1
        ),
        "vertices without a slot are not counted": answered(
            lambda a: a.case.inputs["slot"] < 0, place=0
        ),
    },
    "cell_scan": {
        "the cell itself is left out": known("cell-scan-inclusive"),
        "the sum goes on over all rows": known(
            *(f"cell-scan-restarts-every-{rows}" for rows in (64, 128, 256, 512, 1024))
        ),
    },
    "cell_scatter": {
        "the base is that of the cell": given(start=lambda i: 0 * i["start"]),
        "vertices are numbered by their rows": known(
            "cell-scatter-of-append-numbers", "cell-scatter-of-slots"
        ),
        "vertices without a slot are not stored": known(
            "cell-scatter-of-append-numbers"
        ),
    },
    "cell_find": {
        "all 16 slots are looked at": known(
            "cell-find-in-the-first-slot", "cell-find-leaves-out-the-last-slot"
        ),
        "the checksum decides": known("cell-find-without-checksum"),
        "nothing is found where the cell is not there": known(
            "cell-find-ends-in-a-free-slot", "cell-find-goes-on-in-the-next-bucket"
        ),
    },
    "cell_visit": {
        "vertices are those of the cell": known(
            "cell-visit-beyond-the-cell", "cell-visit-of-the-next-cell"
        ),
        "no vertex is taken twice": known("cell-visit-twice"),
        "as many are taken as are asked for, or as there are": answered(
            lambda a: a.right["vertex"][:, 0] >= 0, vertex=-1
        ),
        "all vertices of a cell have the same chance": known(
            "cell-visit-from-the-first"
        ),
        "an empty look-up finds nobody": answered(
            lambda a: a.case.inputs["slot"] < 0, vertex=0
        ),
    },
    "cell_similar": {
        "who faces alike is a neighbour": known("cell-similar-inverted"),
        "the cosine stands in its fourth power": known(
            "cell-similar-by-the-cosine", "cell-similar-by-the-square"
        ),
        "who faces the other way is none": known("cell-similar-on-both-sides"),
    },
    "light_target": {
        "the surface has its cosine": known("light-target-without-the-surfaces-cosine"),
        "the light has its cosine": known("light-target-without-the-lights-cosine"),
        "the distance is squared": known(
            "light-target-distance-once", "light-target-without-distance"
        ),
        "the reflectance is albedo / π": known(
            "light-target-without-albedo", "light-target-without-pi"
        ),
        "the area of the light is in it": known("light-target-without-area"),
        "0 where the light is below the horizon": known(
            "light-target-below-the-horizon"
        ),
        "0 where the light shows its back": known("light-target-lit-from-behind"),
    },
    "light_candidates": {
        "w is divided by the probability of the light": known(
            "light-candidates-without-the-choice", "light-candidates-times-pdf"
        ),
        "w is divided by the density on the light": known(
            "light-candidates-without-the-density", "light-candidates-without-pdf"
        ),
        "nulls count": known("light-candidates-without-nulls"),
        "the sum is divided by K": known("light-candidates-not-divided"),
        "W is divided by the target of what is kept": known(
            "light-candidates-target-of-the-first"
        ),
        "u decides as in every stream": known(
            "light-candidates-kept-by-the-sum-before", "light-candidates-u-turned"
        ),
        "W = 0 where no weight arrives": answered(lambda a: a.right["W"] == 0, W=1),
    },
    "light_reuse": {
        "the vertex's own reservoir competes": known("light-reuse-canonical-forgotten"),
        "the target is that at the vertex that looks up": known(
            "light-reuse-target-of-the-donor"
        ),
        "nulls count": known("light-reuse-nulls-not-counted"),
        "look-ups that found nobody do not count": known(
            "light-reuse-empty-slots-counted"
        ),
        "the sum is divided as it is asked for": known(
            "light-reuse-one-over-m",
            "light-reuse-z-for-balance",
            "light-reuse-z-of-everybody",
            "light-reuse-maker-not-in-z",
        ),
        "M is capped on the way out": known(
            "light-reuse-never-capped", "light-reuse-capped-beforehand"
        ),
        "W = 0 where no weight arrives": answered(lambda a: a.right["W"] == 0, W=1),
    },
    "bounce_reservoir": {
        "the longer path has the weight of the step": known(
            "bounce-without-the-step", "bounce-target-of-the-suffix"
        ),
        "the suffix has its W": known("bounce-without-the-suffixes-weight"),
        "paths that end at the next vertex compete": known("bounce-ends-forgotten"),
        "a path without light counts": known("bounce-nulls-not-counted"),
        "W is divided by the target of what is kept": known("bounce-averaged"),
        "u decides as in every stream": known(
            "bounce-kept-by-the-sum-before", "bounce-u-turned"
        ),
        "W = 0 where no weight arrives": answered(lambda a: a.right["W"] == 0, W=1),
    },
    "path_cache": {
        "nulls are stored": known("path-cache-of-useful-paths"),
        "a suffix that cannot be joined is stored as a null": known(
            "path-cache-of-joined-paths", "path-cache-joint-not-asked"
        ),
        "vertices that are not rough are not stored": known(
            "path-cache-of-smooth-vertices"
        ),
        "M of nulls stays": known("path-cache-nulls-without-confidence"),
    },
    "suffix_reach": {
        "longer paths do not exist": known("suffix-reach-not-asked"),
        "the longest path exists": known("suffix-reach-one-less"),
        "the bounces before the vertex count": known("suffix-reach-from-the-pixel"),
    },
    "joinable": {
        "thresholds are perceptual roughness": known("alpha-for-roughness"),
        "both ends are rough": known("first-end-rough", "second-end-rough"),
        "single directions are not joined": known("single-directions-joined"),
        "the distance is above the least one, in extents": known(
            "least-distance-not-asked", "least-distance-in-metres"
        ),
        "0 where the distance is 0": answered(_zero("distance"), joinable=1),
    },
    "path_jacobian": {
        "the offset path stands above": known("path-jacobian-inverted"),
        "the densities are in it": known(
            "path-jacobian-without-left-density", "path-jacobian-without-onward-density"
        ),
        "the solid angles are in it": known(
            "path-jacobian-without-cosine",
            "path-jacobian-distance-once",
            "path-jacobian-without-distance",
        ),
        "0 where any factor is 0": answered(
            lambda a: a.right["jacobian"] == 0, jacobian=1
        ),
    },
    "shift": {
        "both ends of a joint are rough": known("first-end-rough", "second-end-rough"),
        "the joint is far enough away": known("least-distance-not-asked"),
        "the joint is seen, from its front": known(
            "hidden-joint-accepted", "joint-seen-from-behind"
        ),
        "a path that could be joined earlier does not exist": known(
            "earlier-joints-accepted", "joint-before-accepted"
        ),
        "points left by a delta lobe are no joints": known(
            "delta-left-is-no-joint-forgotten"
        ),
        "the walk is long enough": known("path-length-not-asked"),
        "points beyond the last joint are not joined": set_to(last_joint=127),
        "only joints at x_2 where replays is 0": known("replays-not-asked"),
        "the throughput is the offset path's": known(
            "bases-throughput", "throughput-left-out"
        ),
        "the density at x_c is divided by, but not where the light was chosen": known(
            "chosen-light-has-a-density", "offset-without-onward-density"
        ),
        "the share is that of the offset path and of its technique": known(
            "share-of-the-base", "share-of-the-other-technique", "share-left-out"
        ),
        "the share is 1 where pdf_light is 0": answered(
            lambda a: (
                (a.case.inputs["pdf_light"] == 0)
                & (a.case.inputs["technique"] == 1)
                & (a.case.inputs["joint"] == a.case.inputs["end"])
                & (a.right["jacobian"] > 0)
            ),
            value=0,
            jacobian=0,
        ),
        "the Jacobian is that of the offset path over the base path": known(
            "path-jacobian-inverted", "path-jacobian-omitted", "offset-distance-once"
        ),
        "the Jacobian of what is replayed is 1": known("replayed-over-density"),
    },
    **PAIR_WAYS,
}
