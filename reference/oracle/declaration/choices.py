"""Keys of ``[choices]``: what each means, and the rules that a replay has for it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache
from math import inf, isfinite
from typing import Any

from restir_gi.reference.oracle.declaration.form import Form
from restir_gi.reference.oracle.diagnosis.alternatives import CAP, STORED
from restir_gi.reference.oracle.diagnosis.diagnose import HYPOTHESES, known_mistakes
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    REUSE,
    SHIFTED,
    Departure,
    Hypothesis,
)
from restir_gi.reference.oracle.diagnosis.jacobians import RIGHT as J_RIGHT
from restir_gi.reference.oracle.diagnosis.jacobians import SHIFTS
from restir_gi.reference.oracle.diagnosis.luminances import (
    largest_channel,
    mean_of_channels,
    rec_601,
    sum_of_channels,
)
from restir_gi.reference.oracle.diagnosis.targets import P_RIGHT, TARGETS_IN
from restir_gi.reference.oracle.diagnosis.weights import W_RIGHT
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.mis import OWN, UNBIASED
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.oracle.replay.slots import ORDERS
from restir_gi.reference.oracle.replay.storage import STORAGES
from restir_gi.reference.oracle.replay.target_rules import TargetRules

Follows = Callable[[Any], tuple[Hypothesis, ...]]

CLOSED = ("finalize", "initial", *REUSE)
BOTH = ("scattered", "outgoing")


@dataclass(frozen=True, slots=True)
class Key:
    """A choice that a declaration may name.

    Attributes
    ----------
    name : str; with a dot where it stands in a table of its own
    form : mapping; JSON schema of its values; ``description``: what would be right
    meaning : str; one line
    contract : object; what the contract chooses
    example : object; another value
    follows : callable; from a value to what it changes
    """

    name: str
    form: Form
    meaning: str
    contract: Any
    example: Any
    follows: Follows


@cache
def _by_rules() -> tuple[tuple[Any, Hypothesis], ...]:
    return tuple((h.rules, h) for h in HYPOTHESES)


def choice(
    name: str,
    what: str,
    formula: str,
    right: str,
    passes: tuple[str, ...],
    departure: Departure = "",
    **rules: Any,
) -> Hypothesis:
    """A choice with its numbers; under the name that the catalogue has for it, if any.

    Parameters
    ----------
    name, what, formula, right : str; as of a `Hypothesis`
    passes : tuple of str; where it can show
    departure : str; of which kind it is; empty: it is biased
    **rules : Any; fields of `Rules`
    """
    changed = replace(CONTRACT_RULES, **rules)
    known = next((h for made, h in _by_rules() if made == changed), None)
    if known is None:
        return Hypothesis(
            name, what, formula, right, passes, changed, departure=departure
        )
    more = tuple(p for p in passes if p not in known.passes)
    return replace(known, passes=(*known.passes, *more))


def number(value: Any) -> float:
    """A number, or a fraction in quotes: "1/3"."""
    return float(Fraction(value)) if isinstance(value, str) else float(value)


def _limits(value: Any) -> tuple[float, float]:
    least, most = map(number, value)
    return least, most


def _span(limits: tuple[float, float]) -> str:
    """The limits in a name: of [1/m, m] the one number, as the catalogue has it."""
    least, most = limits
    if least > 0 and isfinite(most) and abs(least * most - 1) < 1e-6:
        return f"{most:.6g}"
    return f"{least:.6g}-{most:.6g}"


def _interval(limits: tuple[float, float]) -> str:
    return f"[{limits[0]:.6g}, {limits[1]:.6g}]"


def _order(value: str) -> tuple[Hypothesis, ...]:
    if value == "contract":
        return ()
    what = f"the stream is in the order {value}: the same distribution"
    right = "the past, then the pixel's own, then neighbours in their order"
    return (choice(value, what, value, right, REUSE, "order", order=value),)


@cache
def catalogue() -> Mapping[str, Hypothesis]:
    """Choices and mistakes that have a name, by it."""
    return {h.name: h for h in known_mistakes()}


def _named(name: str) -> Hypothesis:
    return catalogue()[name]


def _u(value: str) -> tuple[Hypothesis, ...]:
    return () if value == "u" else (_named("keeps-the-other-side"),)


CAPS: Mapping[str, tuple[str, str]] = {
    "when stored": ("closed", ""),
    "on arrival": ("never", "own"),
    "on arrival, neighbors too": ("never", "all"),
    "past on arrival": ("never", "past"),
    "both": ("closed", "own"),
    "both, neighbors too": ("closed", "all"),
    "both, past alone": ("closed", "past"),
    "never": ("never", ""),
}
"""When M is capped, and what is capped as it arrives."""


def _cap(value: str) -> tuple[Hypothesis, ...]:
    when, arriving = CAPS[value]
    if (when, arriving) == ("closed", ""):
        return ()
    made = choice(
        "past-capped-twice",
        "M of the past is capped when it arrives, and that of all when it is stored",
        "w = p̂ W min(M, cap) of the past, M = min(Σ M, cap)",
        CAP,
        REUSE,
        "confidence",
        cap_when=when,
        cap_arriving=arriving,
    )
    return (made,)


def _whole_M(value: bool) -> tuple[Hypothesis, ...]:
    return (_named("whole-confidence"),) if value else ()


def _most_M(value: Any) -> tuple[Hypothesis, ...]:
    most = number(value)
    made = choice(
        f"confidence-at-most-{most:.6g}",
        f"M is stored in a type that holds {most:g} at most",
        f"M = min(Σ M, cap, {most:g})",
        CAP,
        REUSE,
        "confidence",
        most_confidence=most,
    )
    return (made,)


MIS = ("as asked", "1/M", *UNBIASED, OWN)


def _mis(value: str) -> tuple[Hypothesis, ...]:
    if value == "as asked":
        return ()
    made = choice(
        "weights-of-its-own",
        "the weights are the backend's own and sum to 1; W is judged by its mean",
        "W = Σ m p̂ W J / p̂(y), Σ m = 1 over those that could have made y",
        "W = Σ w / (p̂(y) Z)",
        REUSE,
        "mis",
        normalization=value,
    )
    return (made,)


def _own_measures(value: bool) -> tuple[Hypothesis, ...]:
    if value:
        return ()
    made = choice(
        "mis-weights-without-jacobian",
        "MIS weights compare densities each in its own measure",
        "m of targets without their Jacobians",
        "m of densities in the receiver's measure",
        SHIFTED,
        "mis",
        mis_jacobian=False,
    )
    return (made,)


def _visibility(value: str) -> tuple[Hypothesis, ...]:
    return (_named("visibility-missing-in-weight"),) if value == "shading" else ()


def _domain_sees(value: bool) -> tuple[Hypothesis, ...]:
    return () if value else (_named("visibility-missing-in-z"),)


def _refused(value: Any) -> tuple[Hypothesis, ...]:
    limits = _limits(value)
    made = choice(
        f"jacobian-refused-beyond-{_span(limits)}",
        f"shifts with J outside of {_interval(limits)} are refused, and Z does not"
        " know",
        f"w = 0 where J is outside of {_interval(limits)}",
        J_RIGHT,
        SHIFTS,
        refused=limits,
    )
    return (made,)


def _refused_both_ways(value: Any) -> tuple[Hypothesis, ...]:
    limits = _limits(value)
    made = choice(
        f"jacobian-refused-both-ways-at-{_span(limits)}",
        f"shifts with J outside of {_interval(limits)} are refused, both ways: right in"
        " mean",
        f"w = 0 outside of {_interval(limits)}, and such a source does not count in Z",
        "w = p̂ W M J, whatever J is",
        SHIFTS,
        "domain",
        refused=limits,
        refused_both_ways=True,
    )
    return (made,)


def _clamped(value: Any) -> tuple[Hypothesis, ...]:
    limits = _limits(value)
    made = choice(
        f"jacobian-clamped-to-{_span(limits)}",
        f"the Jacobian is clamped to {_interval(limits)}",
        f"J = clamp(J, {limits[0]:.6g}, {limits[1]:.6g})",
        J_RIGHT,
        SHIFTS,
        clamped=limits,
    )
    return (made,)


def _no_jacobian(value: bool) -> tuple[Hypothesis, ...]:
    return (_named("jacobian-omitted"),) if value else ()


def _most_W(value: Any) -> tuple[Hypothesis, ...]:
    most = number(value)
    made = choice(
        f"weight-cut-at-{most:.6g}",
        f"W is cut at {most:g}",
        f"W = min(W, {most:g})",
        W_RIGHT,
        CLOSED,
        W_most=most,
    )
    return (made,)


def _oldest(value: Any) -> tuple[Hypothesis, ...]:
    limits = _limits(value if isinstance(value, list) else [value, value])
    ages = " to ".join(f"{age:g}" for age in sorted(set(limits)))
    made = choice(
        f"forgotten-at-age-{ages.replace(' to ', '-')}",
        f"the past is not reused once its sample has survived {ages} frames",
        f"M₀ = W₀ = 0 where age₀ ≥ {ages}",
        "the past is reused, however old its sample is",
        ("temporal", "moved"),
        max_age=limits,
    )
    return (made,)


DARK_TOO = "1/pdf, dark samples too"


def _null_W(value: str) -> tuple[Hypothesis, ...]:
    # Of a null, which has no light, any W is the contract's.
    return (_named("dark-sample-keeps-its-density"),) if value == DARK_TOO else ()


def _least_divisor(value: Any) -> tuple[Hypothesis, ...]:
    least = number(value)
    made = choice(
        f"divisor-at-least-{least:.6g}",
        f"the target is kept above {least:g} where it divides",
        f"W = Σ w / (max(p̂(y), {least:g}) Z)",
        W_RIGHT,
        CLOSED,
        divisor_least=least,
    )
    return (made,)


LUMINANCES = {
    "rec709": luminance,
    "rec601": rec_601,
    "mean": mean_of_channels,
    "sum": sum_of_channels,
    "largest": largest_channel,
}


def _target(name: str, what: str, formula: str, **change: Any) -> Follows:
    """What follows of a word that says yes or no."""

    def follows(value: bool) -> tuple[Hypothesis, ...]:
        if value == getattr(TargetRules(), next(iter(change))):
            return ()
        return (_of_target(name, what, formula, **change),)

    return follows


def _of_target(name: str, what: str, formula: str, **change: Any) -> Hypothesis:
    rules = TargetRules(**change)
    return choice(name, what, formula, P_RIGHT, TARGETS_IN, "target", target=rules)


def _kind(value: str) -> tuple[Hypothesis, ...]:
    return () if value == "as asked" else (_named(f"target-always-{value}"),)


def _light(value: str) -> tuple[Hypothesis, ...]:
    if value == "rec709":
        return ()
    return (_of_target(value, value, value, light=LUMINANCES[value]),)


def _cosines(value: int) -> tuple[Hypothesis, ...]:
    if value == 1:
        return ()
    name = {0: "target-without-cosine", 2: "target-cosine-twice"}[value]
    return (_named(name),)


def _pis(value: int) -> tuple[Hypothesis, ...]:
    if value == 1:
        return ()
    return (_named({0: "target-without-pi", 2: "target-pi-twice"}[value]),)


def _scale(value: Any) -> tuple[Hypothesis, ...]:
    factor = number(value)
    if factor == 1:
        return ()
    name = f"target-times-{factor:.6g}"
    what = f"every target is multiplied by {factor:g}: the same distribution"
    made = _of_target(name, what, f"{factor:g} p̂", scale=factor, scaled_in=BOTH)
    return (made,)


def _least(value: Any) -> tuple[Hypothesis, ...]:
    least = number(value)
    name = f"target-at-least-{least:.6g}"
    what = f"the target is kept above {least:g} where there is light: right in mean"
    formula = f"p̂ = max(p̂, {least:g}) where p̂ > 0"
    return (_of_target(name, what, formula, least=least),)


def _least_scattered(value: Any) -> tuple[Hypothesis, ...]:
    least = number(value)
    name = f"scattered-at-least-{least:.6g}"
    what = (
        f"the target of Equation 9 is kept above {least:g} where there is light: right"
        " in mean"
    )
    formula = f"p̂ = max(p̂, {least:g}) where p̂ > 0, in scattered"
    made = _of_target(name, what, formula, least=least, least_in=("scattered",))
    return (made,)


def _back(value: str) -> tuple[Hypothesis, ...]:
    if value == "target":
        return ()
    names = ("back-left-to-the-jacobian", "jacobian-cut-at-the-back")
    return tuple(map(_named, names))


def _shading_asks_back(value: bool) -> tuple[Hypothesis, ...]:
    return () if value else (_named("shade-back-of-sample"),)


def _storage(value: str) -> tuple[Hypothesis, ...]:
    if value == "float32":
        return ()
    made = choice(value, value, value, STORED, REUSE, "storage", storage=value)
    return (made,)


BOILING = Hypothesis(
    "boiling-filter",
    "reservoirs that outshine their tile are emptied",
    "W = M = 0 where light · strength > mean · (10 − 9 strength)",
    "no reservoir is emptied for what it holds",
    ("boiling",),
    CONTRACT_RULES,
    ("RTXDI",),
)


def _boiling(value: bool) -> tuple[Hypothesis, ...]:
    return (BOILING,) if value else ()


def _names(value: Any) -> tuple[Hypothesis, ...]:
    return tuple(_named(name) for name in value)


def _nothing(value: Any) -> tuple[Hypothesis, ...]:
    return ()


def _one_of(*words: str) -> Form:
    told = ", ".join(f'"{word}"' for word in words[:-1])
    return {"enum": list(words), "description": f'one of {told} or "{words[-1]}"'}


YES: Form = {"type": "boolean", "description": "true or false"}
_FRACTION: Form = {"type": "string", "pattern": "^[1-9][0-9]*/[1-9][0-9]*$"}


def _amount(**limits: Any) -> Form:
    return {"anyOf": [{"type": "number", **limits}, _FRACTION]}


POSITIVE: Form = {
    **_amount(exclusiveMinimum=0),
    "description": 'a number above 0, or a fraction such as "1/3"',
}
LIMITS: Form = {
    "type": "array",
    "items": _amount(minimum=0),
    "minItems": 2,
    "maxItems": 2,
    "description": "two numbers, the least and the most, such as [0.1, 10] or"
    ' ["1/3", 3], where 0 and inf are none',
}
AGES: Form = {
    "anyOf": [*_amount(exclusiveMinimum=0)["anyOf"], LIMITS],
    "description": "a number above 0, or two, the least and the most",
}

KEYS: tuple[Key, ...] = (
    Key(
        "order",
        _one_of("contract", *ORDERS),
        "who comes when in the stream of candidates, and whose number u decides",
        "contract",
        "own-first",
        _order,
    ),
    Key(
        "u",
        _one_of("u", "1 - u"),
        "a candidate is kept where u, or 1 − u, is below its share",
        "u",
        "1 - u",
        _u,
    ),
    Key("cap", _one_of(*CAPS), "where M is capped", "when stored", "on arrival", _cap),
    Key("M.whole", YES, "M is a whole number when it is stored", False, True, _whole_M),
    Key("M.most", POSITIVE, "the largest M that its type holds", inf, 255, _most_M),
    Key(
        "mis",
        _one_of(*MIS),
        "weights of those that could have made a sample; `own`: others that sum to 1",
        "as asked",
        "balance",
        _mis,
    ),
    Key(
        "mis_jacobian",
        YES,
        "MIS weights compare densities in one measure, by Jacobians",
        True,
        False,
        _own_measures,
    ),
    Key(
        "visibility",
        _one_of("target", "weight", "shading"),
        "what is 0 where the receiver does not see a sample",
        "weight",
        "shading",
        _visibility,
    ),
    Key(
        "visibility_in_domain",
        YES,
        "whether a source could have made a sample asks what it sees",
        True,
        False,
        _domain_sees,
    ),
    Key(
        "jacobian.refused",
        LIMITS,
        "shifts with J outside are refused, and the weights do not know",
        [0, inf],
        [0.1, 10],
        _refused,
    ),
    Key(
        "jacobian.refused_both_ways",
        LIMITS,
        "shifts with J outside are refused, and the weights know",
        [0, inf],
        [0.1, 10],
        _refused_both_ways,
    ),
    Key(
        "jacobian.clamped",
        LIMITS,
        "J is clamped, after what was refused",
        [0, inf],
        ["1/3", 3],
        _clamped,
    ),
    Key("jacobian.omitted", YES, "J is left out", False, True, _no_jacobian),
    Key(
        "max_age",
        AGES,
        "the past is not reused once its sample has survived so many frames, or [from,"
        " to] where each pixel draws its limit; shows in captures whose reservoirs"
        " have their age",
        inf,
        [15, 30],
        _oldest,
    ),
    Key("W_most", POSITIVE, "W is cut there", inf, 10, _most_W),
    Key(
        "W_of_nulls",
        _one_of("0", "1/pdf", DARK_TOO),
        "W of a new sample without light; dark ones have light, and a target of 0",
        "0",
        "1/pdf",
        _null_W,
    ),
    Key(
        "divisor_least",
        POSITIVE,
        "p̂ is raised to it where it divides, and nowhere else",
        0,
        0.001,
        _least_divisor,
    ),
    Key(
        "target.kind",
        _one_of("as asked", *BOTH),
        "Equation 9 or 10, whatever is asked for",
        "as asked",
        "outgoing",
        _kind,
    ),
    Key(
        "target.luminance",
        _one_of(*LUMINANCES),
        "what stands for luminance",
        "rec709",
        "rec601",
        _light,
    ),
    Key(
        "target.least",
        POSITIVE,
        "a target above 0 is raised to it",
        0,
        0.001,
        _least,
    ),
    Key(
        "target.scattered_least",
        POSITIVE,
        "a target of Equation 9 above 0 is raised to it",
        0,
        0.001,
        _least_scattered,
    ),
    Key(
        "target.root",
        YES,
        "the root stands for the target",
        False,
        True,
        _target("root-of-the-target", "", "", root=True),
    ),
    Key(
        "target.albedo",
        YES,
        "Equation 9 has the albedo",
        True,
        False,
        _target("target-without-albedo", "", "", albedo=False),
    ),
    Key(
        "target.cosines",
        {"enum": [0, 1, 2], "description": "0, 1 or 2"},
        "power of cos θ in Equation 9",
        1,
        0,
        _cosines,
    ),
    Key(
        "target.pis",
        {"enum": [0, 1, 2], "description": "0, 1 or 2"},
        "times that Equation 9 is divided by π",
        1,
        0,
        _pis,
    ),
    Key(
        "target.geometry_term",
        YES,
        "Equation 9 has cos φ / d², of an area measure",
        False,
        True,
        _target("target-with-geometry-term", "", "", area_measure=True),
    ),
    Key("target.scale", POSITIVE, "factor of every target", 1, 2, _scale),
    Key(
        "target.back",
        _one_of("target", "jacobian"),
        "what is 0 where the back of a sample is seen",
        "target",
        "jacobian",
        _back,
    ),
    Key(
        "shading_asks_back",
        YES,
        "shading is 0 where the back of a sample is seen; else W has to be",
        True,
        False,
        _shading_asks_back,
    ),
    Key(
        "storage",
        _one_of("float32", *STORAGES),
        "how reservoirs are stored between passes",
        "float32",
        "half",
        _storage,
    ),
    Key(
        "boiling",
        YES,
        "reservoirs go through a filter of pass `boiling`",
        False,
        True,
        _boiling,
    ),
    Key(
        "names",
        {
            "type": "array",
            "items": {"type": "string"},
            "description": "a list of names from the page of known mistakes",
        },
        "choices and mistakes by their names in the catalogue, as after --declare",
        [],
        ["stream-reversed"],
        _names,
    ),
    Key(
        "generator",
        _one_of("contract", "own"),
        "the random numbers are those of pass `random`, or others",
        "contract",
        "own",
        _nothing,
    ),
    Key(
        "pixel",
        _one_of("center", "box"),
        "where in a pixel the rays of its pictures begin, as --pixel says",
        "center",
        "box",
        _nothing,
    ),
)

OF_ALL = ("boiling", "generator", "pixel")
"""Keys that no single pass has."""

OF_PASSES = ("initial", "temporal", "moved", "spatial", "fused")
"""Passes with choices of their own, in tables such as ``[choices.spatial]``."""

EXCLUSIVE: tuple[tuple[str, str, str], ...] = (
    (
        "jacobian.refused",
        "jacobian.refused_both_ways",
        "a shift is refused one way or both ways; leave one out",
    ),
    (
        "jacobian.refused",
        "target.back",
        "what the Jacobian cuts is refused both ways; say jacobian.refused_both_ways",
    ),
    (
        "jacobian.omitted",
        "target.back",
        "a Jacobian that is left out cuts nothing; leave one out",
    ),
    (
        "target.least",
        "target.scattered_least",
        "one floor is of both equations, the other of Equation 9; leave one out",
    ),
)
"""Keys that cannot both be other than the contract's, and what would be right."""
