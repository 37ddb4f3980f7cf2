"""What makes a verdict FAIL, one by one, each with a name that stays the same."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

Plain = Mapping[str, Any]
Kind = Literal[
    "pass", "bias", "together", "missing", "near", "extremes", "pictures", "verdict"
]


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that is wrong.

    Attributes
    ----------
    kind : str; a pass, a bias that is not accepted, a test of several passes, ...
    key : str; the same in every verdict on the same fault
    name : str; what it is called for people, in a few words
    told : str; the whole diagnosis
    of : Plain; the part of the verdict that says it
    """

    kind: Kind
    key: str
    name: str
    told: str
    of: Plain

    @property
    def first(self) -> str:
        """The first sentence, of one line."""
        return " ".join(self.told.split("\n")[0].split())


def faults(verdict: Plain) -> list[Fault]:
    """All that makes a verdict FAIL; none where it is not."""
    if verdict["status"] != "FAIL":
        return []
    if verdict["kind"] == "pictures":
        return [_of_pictures(verdict)]
    found = [*_of_passes(verdict), *_of_biases(verdict), *_of_steps(verdict)]
    found += [_line("missing", line) for line in verdict["missing"]]
    if not any(p["status"] != "not judged" for p in verdict["passes"]):
        found += [_line("near", line) for line in verdict["near"]]
    if verdict["asked"].get("extremes"):
        found += [_line("extremes", line) for line in verdict["at_extremes"]]
    return found or [_line("verdict", verdict["headline"])]


def stable_title(step: Plain) -> str:
    """A step's level and title, without how many runs it had time for."""
    return f"{level_of(step)} {re.sub(r' of [0-9,]+ runs$', '', step['title'])}"


def level_of(step: Plain) -> str:
    """Level of the ladder that a step belongs to."""
    return str(step["rung"])


def named_in(reason: Plain) -> list[str]:
    """Names of all explanations of a pass, each once."""
    return list(dict.fromkeys(name for one in reason["named"] for name in one))


def _of_passes(verdict: Plain) -> Iterator[Fault]:
    for one in verdict["passes"]:
        if one["status"] == "wrong":
            name = f"{one['name']} ({called(one)})"
            yield Fault("pass", one["name"], name, diagnosis_of(one), one)


def called(one: Plain) -> str:
    """What a wrong pass is called: its mistakes, else the term that is wrong."""
    reason = one["reason"]
    alternatives = [" with ".join(names) for names in reason["named"]]
    failed = [text.partition(": ")[2] for text in reason["failed"][:1]]
    named = " or ".join(alternatives) or reason["term"]
    return named or "".join(failed) or "no known mistake"


def diagnosis_of(one: Plain) -> str:
    """Diagnosis of a pass: its sentence, the conclusion, every fault, how to ask again.

    The first sentence is the first line.
    """
    lines = [one["sentence"] or one["name"]]
    if one["conclusion"]:
        lines.append(one["conclusion"])
    lines += one["faults"]
    lines += [f["output"] for f in one["failures"] if f["output"]]
    asks = [one["failing"], *one["failures"]]
    again = next((a["command"] for a in asks if a and a.get("command")), None)
    if again:
        lines.append(f"to ask for this case alone: {again}")
    return "\n".join(lines)


def _of_biases(verdict: Plain) -> Iterator[Fault]:
    declared = verdict["declaration"] or {"biases": []}
    for one in declared["biases"]:
        if not one["accepted"]:
            key = f"{one['pass']}: {', '.join(sorted(one['choices']))}"
            told = f"{one['told']}\n{declared['to_accept'] or ''}".rstrip()
            yield Fault("bias", key, f"{key}, biased by design", told, one)


def _of_steps(verdict: Plain) -> Iterator[Fault]:
    for step in verdict["steps"]:
        for text in step["together"]:
            yield together(step, text)


def together(step: Plain, text: str) -> Fault:
    """A fault of a test of several passes."""
    key = f"{stable_title(step)}: {_masked(text.partition(':')[0])}"
    return Fault("together", key, key, text, {"told": text})


def _line(kind: Kind, text: str) -> Fault:
    return Fault(kind, f"{kind}: {_masked(text)}", text, text, {"told": text})


def _masked(text: str) -> str:
    """A line without its counts of rows, which hang on how many were asked."""
    return re.sub(r"[0-9,]+ of [0-9,]+", "some", text)


def _of_pictures(verdict: Plain) -> Fault:
    lines = [verdict["headline"]]
    lines += [f"what accuses: {verdict['accuses']}"] if verdict.get("accuses") else []
    lines += verdict.get("likenesses", [])
    name = verdict["headline"].partition(";")[0]
    return Fault("pictures", "pictures", name, "\n".join(lines), verdict)
