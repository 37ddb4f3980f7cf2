"""What of a verdict is new since another one, the baseline.

A fault is known, and let through, where the baseline has it for the same reason.  All
that the oracle cannot show to be the same is new: the same mistakes by name, with every
row explained by them; else the same wrong term, in outputs and cases that were wrong
before, in no more rows than chance explains, and no further off.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import hypot
from pathlib import Path
from typing import Any

from scipy.special import ndtri

from restir_gi.reference.oracle.statistics.intervals import student_deviations
from restir_gi.reference.reports.integration.faults import (
    Fault,
    Plain,
    faults,
    stable_title,
)
from restir_gi.reference.reports.verdict.schema import VERSION, fault_of_form
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file

ALPHA = 1e-6
"""Probability that what is the same is called new, of what hangs on chance."""

EXCESS = 2.0
"""Differences are in units of what rounding allows.  Two answers that are the same but
for rounding are within one such unit of each other's exact value, each: so the largest
difference of one exceeds that of the other by two at most."""

NOISIER = 3.0
"""Times the error of the baseline's pictures, from which nothing is said of the same
bias.  With eight pictures of either the errors of one renderer differ by more in one
check of two hundred, by the F distribution with 7 and 7 degrees of freedom."""

MOST_BYTES = 2**28
OF_THE_SAME = (
    *("seed", "precision", "quick", "against"),
    *("scene", "frame", "frames", "size", "light", "bounces", "pixel", "layer"),
)
"""Options that both verdicts must have been made with."""


@dataclass(slots=True)
class SinceBaseline:
    """A verdict beside its baseline.

    Attributes
    ----------
    known : list of str; faults that are let through, a name each
    new : list of str; faults that the baseline does not have, a sentence each
    fixed : list of str; faults of the baseline that are gone
    changed : list of str; what of the known ones is other than it was
    unjudged : list of str; faults of the baseline of which nothing is known now
    unknown : bool; whether too little is known for a success
    """

    known: list[str] = field(default_factory=list)
    new: list[str] = field(default_factory=list)
    fixed: list[str] = field(default_factory=list)
    changed: list[str] = field(default_factory=list)
    unjudged: list[str] = field(default_factory=list)
    unknown: bool = False

    def status(self, verdict: Plain) -> str:
        """What the exit code says, with known faults let through."""
        if self.new or verdict["status"] != "FAIL":
            return "FAIL" if self.new else str(verdict["status"])
        if self.unknown:
            return "UNDECIDED"
        return "QUICK" if verdict["asked"].get("quick") else "PASS"


def read_baseline(path: Path) -> dict[str, Any]:
    """A verdict that was written before.

    Raises UsageError: it cannot be read, or is no verdict of this version.
    """
    try:
        found = json.loads(read_file(path, MOST_BYTES))
    except (ValueError, RecursionError) as error:
        why = f"it is no JSON: {' '.join(str(error).split())}"
        raise UsageError(_refusal(path, why)) from error
    version = found.get("schema") if isinstance(found, dict) else None
    if version != VERSION:
        has = f"its schema is {version!r}" if version else "it has no key schema"
        raise UsageError(_refusal(path, f"{has}, and this version reads {VERSION!r}"))
    if fault := fault_of_form(found):
        raise UsageError(_refusal(path, fault))
    verdict: dict[str, Any] = found
    return verdict


def _refusal(path: Path, why: str) -> str:
    return (
        f"--baseline {path} is no verdict: {why}; make it by restir check --out, or"
        " --json"
    )


def refuse_other(
    path: Path, baseline: Plain, kind: str, backend: str, asked: Plain
) -> None:
    """Raise unless a baseline is of what is checked now.

    Raises UsageError: another backend, or other options that decide what is asked.
    """
    now_asked: Plain = {"kind": kind, "backend": backend, "asked": asked}
    about = "what is judged", "BACKEND", *OF_THE_SAME
    there, here = (
        (one["kind"], one["backend"], *map(one["asked"].get, OF_THE_SAME))
        for one in (baseline, now_asked)
    )
    for name, was, now in zip(about, there, here, strict=True):
        if was != now:
            raise UsageError(
                f"--baseline {path} is of another check: {name} is {was} there, and"
                f" {now} here; make a new one"
            )


def compared(verdict: Plain, baseline: Plain) -> SinceBaseline:
    """What of a verdict is new.

    Parameters
    ----------
    baseline : Plain; of the same backend, as `refuse_other` has it
    """
    found = SinceBaseline(unknown=_is_incomplete(verdict))
    now, before = faults(verdict), {f.key: f for f in faults(baseline)}
    for fault in now:
        was = before.get(fault.key)
        _compare(found, fault, was if was and was.kind == fault.kind else None)
    if verdict["kind"] != "pictures":
        found.new += _grown_mean(verdict, baseline)
    keys = {fault.key for fault in now}
    for key, was in before.items():
        if key not in keys:
            gone = _is_gone(was, verdict)
            (found.fixed if gone else found.unjudged).append(was.name)
    return found


def as_plain(path: Path, found: SinceBaseline, verdict: Plain) -> dict[str, Any]:
    """A comparison for programs: the key ``baseline`` of a verdict."""
    told = {
        "file": str(path),
        "status": found.status(verdict),
        "known": found.known,
        "new": found.new,
        "fixed": found.fixed,
        "changed": found.changed,
        "unjudged": found.unjudged,
    }
    return told | {"told": list(_lines(told))}


def _lines(told: Plain) -> Iterator[str]:
    """A comparison for people, a line each; the last says what the exit code says."""
    yield from (f"new since the baseline: {text}" for text in told["new"])
    yield from (f"fixed since the baseline: {name}" for name in told["fixed"])
    for name in told["unjudged"]:
        yield f"in the baseline, and not judged now: {name}"
    yield from (f"other than in the baseline: {text}" for text in told["changed"])
    many, known = len(told["known"]), "; ".join(told["known"])
    faults_of = "1 known fault is" if many == 1 else f"{many} known faults are"
    let = f"{faults_of} let through: {known}" if many else "no known fault"
    yield f"{told['status']} beside the baseline {told['file']}: {let}"


def _compare(found: SinceBaseline, fault: Fault, was: Fault | None) -> None:
    if was is None:
        found.new.append(fault.first)
        return
    ways = {"pass": _pass_differs, "bias": _bias_differs, "pictures": _pictures_differ}
    other = list(ways[fault.kind](fault, was)) if fault.kind in ways else []
    if fault.kind in ("near", "verdict") or _is_broken(fault):
        other.append("nothing was judged, which is never let through")
    if other:
        found.new.append(f"{fault.first}; {'; '.join(other)}")
        return
    if fault.kind == "pictures":
        doubts = list(_doubts(fault.of, was.of))
        found.unknown |= bool(doubts)
        found.changed += doubts
    found.known.append(fault.name)
    if fault.first != was.first:
        found.changed.append(f"{fault.first}; it was: {was.first}")


def _is_broken(fault: Fault) -> bool:
    return fault.kind == "pictures" and fault.of.get("evidence") == "broken"


def _pass_differs(fault: Fault, was: Fault) -> Iterator[str]:
    """In what a wrong pass is not wrong as it was; nothing where it is."""
    now, before = fault.of["reason"], was.of["reason"]
    if now["named"] != before["named"]:
        yield f"the baseline has {was.name}"
    for key, words in (("failed", "calls"), ("tests", "tests")):
        if further := _further(now[key], before[key]):
            yield f"further {words} fail: {further}"
    if now["named"]:
        return  # which explain every row, to rounding
    if (now["term"], now["nearest"]) != (before["term"], before["nearest"]):
        yield f"the baseline has {was.name}"
    for key, words in (("outputs", "outputs are"), ("cases", "cases are")):
        if further := _further(now[key], before[key]):
            yield f"further {words} wrong: {further}"
    yield from _grown_excess(fault.of["excess"], was.of["excess"])
    if _more_rows(fault.of, was.of):
        yield (
            f"more rows are wrong: {_share(fault.of)}, and {_share(was.of)} in the"
            " baseline"
        )


def _further(now: list[str], before: list[str]) -> str:
    return ", ".join(name for name in now if name not in before)


def _share(one: Plain) -> str:
    return f"{one['wrong_rows']:,} of {one['rows']:,}"


def _grown_excess(now: Mapping[str, Any], before: Mapping[str, Any]) -> Iterator[str]:
    for name, excess in now.items():
        was = before.get(name, 0.0)
        if was is None:
            continue  # beyond all numbers
        if excess is None or excess > was + EXCESS:
            size = "beyond all numbers" if excess is None else f"{excess:.3g}"
            yield (
                f"{name} is further off: {size} times what rounding allows, and"
                f" {was:.3g} in the baseline"
            )


def _more_rows(now: Plain, before: Plain) -> bool:
    """Whether the share of wrong rows has grown by more than chance, Fisher's test."""
    from scipy.stats import hypergeom  # which takes a second

    wrong, rows = now["wrong_rows"], now["rows"]
    every, bad = rows + before["rows"], wrong + before["wrong_rows"]
    return bool(wrong and hypergeom.sf(wrong - 1, every, bad, rows) <= ALPHA)


def _bias_differs(fault: Fault, was: Fault) -> Iterator[str]:
    """Whether a bias by design has another size than it had."""
    now, before = fault.of["light"], was.of["light"]
    if now != before and fault.told != was.told:
        yield f"it was: {was.first}"


def _grown_mean(verdict: Plain, baseline: Plain) -> Iterator[str]:
    """A bias of the mean of whole runs that is larger than it was, beyond chance."""
    now, before = verdict["measured"], baseline["measured"]
    if verdict["status"] != "FAIL" or not now or not before:
        return
    numbers = [one[key] for one in (now, before) for key in ("relative", "error")]
    if any(number is None for number in numbers):
        if numbers[:2] != numbers[2:]:
            yield f"the bias of the mean is {now['told']}; it was: {before['told']}"
        return
    relative, error, was, error_was = numbers
    allowed = -ndtri(ALPHA / 2) * hypot(error, error_was)
    if abs(relative - was) > allowed and abs(relative) > abs(was):
        yield f"the bias of the mean has grown: {now['told']}; it was: {before['told']}"


def _is_incomplete(verdict: Plain) -> bool:
    """Whether nothing was judged, or steps had no time, or want more."""
    if verdict["kind"] == "pictures":
        return False
    if all(one["status"] == "not judged" for one in verdict["passes"]):
        return True
    steps = verdict["steps"]
    wanting = any(s["unasked"] or (s["binds"] and s["more"]) for s in steps)
    return bool(verdict["left"]) or wanting


def _is_gone(was: Fault, verdict: Plain) -> bool:
    """Whether a fault of the baseline was looked for and not found."""
    if verdict["status"] == "UNDECIDED" and verdict["kind"] == "pictures":
        return False
    if was.kind == "pass":
        one = next((p for p in verdict["passes"] if p["name"] == was.key), None)
        return one is not None and one["status"] not in (
            "not judged",
            "undecided",
            "wrong",
        )
    if was.kind == "together":
        taken = [s for s in verdict["steps"] if s["asked"] > s["unanswered"]]
        return any(was.key.startswith(f"{stable_title(s)}: ") for s in taken) and not (
            verdict["left"] or verdict["not_asked"]
        )
    return not verdict.get("not_asked")


# ---------------------------------------------------------------- pictures


def _pictures_differ(fault: Fault, was: Fault) -> Iterator[str]:
    """In what pictures are not wrong as they were."""
    now, before = fault.of, was.of
    evidence = [one["evidence"] == "broken" for one in (now, before)]
    if evidence[0] != evidence[1]:
        yield f"the baseline has: {was.name}"
        return
    if now["negative"] and not before["negative"]:
        yield "pixels are negative, and were not"
    known = {one["name"]: one for one in before["means"]}
    pairs = [(m, known[m["name"]]) for m in now["means"] if m["name"] in known]
    if len(pairs) < len(now["means"]) or not pairs:
        yield "the baseline has no such means"
        return
    deviations = float(-ndtri(ALPHA / 2 / len(pairs)))
    least = max(2, min(now["pictures"], before["pictures"]))
    deviations = student_deviations(deviations, least)
    for mean, mean_was in pairs:
        yield from _mean_differs(mean, mean_was, deviations)


def _mean_differs(now: Plain, was: Plain, deviations: float) -> Iterator[str]:
    numbers = [one[key] for one in (now, was) for key in ("difference", "error")]
    if any(number is None for number in numbers):
        if numbers[:2] != numbers[2:]:
            yield f"the mean of {now['name']} is not what it was"
        return
    difference, error, difference_was, error_was = numbers
    # Both are held against one truth, whose own error is in both.
    moved = difference - difference_was
    if abs(moved) <= deviations * hypot(error, error_was) + _rounding(now, was):
        return
    if difference * difference_was > 0 and abs(difference) < abs(difference_was):
        return  # nearer to the truth, on the same side
    yield (
        f"the mean of {now['name']} is off by {_off(now)}, and by {_off(was)} in the"
        " baseline"
    )


def _rounding(now: Plain, was: Plain) -> float:
    """Of sums of pixels in single precision, that are the same but for rounding."""
    size = max(abs(one["truth"] or 0.0) + abs(one["difference"]) for one in (now, was))
    return float(2.0**-20 * size)


def _off(one: Plain) -> str:
    if one["relative"] is None or one["relative_error"] is None:
        return f"{one['difference']:.3g}"
    return f"{100 * one['relative']:+.3g} % ± {100 * one['relative_error']:.2g} %"


def _doubts(now: Plain, before: Plain) -> Iterator[str]:
    """Why too little is known of pictures to call their bias the same."""
    error, was = (one["means"][0]["error"] for one in (now, before))
    if error is None or was is None or error > NOISIER * was:
        yield (
            "the pictures are so much noisier than those of the baseline that a larger"
            " bias would not be noticed"
        )
