"""A verdict as JUnit XML, which every CI system shows.

A suite ``passes`` has a test case for each pass of the contract; a suite for each level
has one for each step that tests several passes at once; a suite ``verdict`` says what
the exit code says.  Names do not hang on seeds and times, so that a CI system can
follow a test over the weeks.
"""

import re
from collections.abc import Iterable, Iterator
from xml.etree import ElementTree as Xml

from restir_gi.reference.reports.integration.faults import (
    Fault,
    Plain,
    diagnosis_of,
    faults,
    level_of,
    stable_title,
    together,
)

NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 has no form for; also half of a surrogate pair."""

PREFIX = "restir"


def junit_text(verdict: Plain) -> str:
    """A verdict as JUnit XML."""
    known = set((verdict.get("baseline") or {}).get("known", ()))
    suites = list(_suites(verdict, known))
    root = Xml.Element("testsuites", name=f"restir check {_clean(verdict['backend'])}")
    for suite in suites:
        if len(suite):
            root.append(suite)
            _count(suite)
    for what in ("tests", "failures", "errors", "skipped"):
        root.set(what, str(sum(int(s.get(what, "0")) for s in root)))
    Xml.indent(root)
    return Xml.tostring(root, encoding="unicode", xml_declaration=False).join(
        ('<?xml version="1.0" encoding="UTF-8"?>\n', "\n")
    )


def _suites(verdict: Plain, known: set[str]) -> Iterator[Xml.Element]:
    found = faults(verdict)
    if verdict["kind"] == "pictures":
        suite = _suite("pictures")
        _outcome(_case(suite, "pictures"), found, known)
        _properties(suite, _pictures_told(verdict))
        yield suite
    else:
        yield _passes(verdict, found, known)
        titles = [*verdict["left"], *verdict["not_asked"]]
        levels = set(map(level_of, verdict["steps"]))
        for level in sorted(levels | {title.split()[0] for title in titles}):
            yield _level(verdict, level, known)
        yield _further(found, known)
    yield _whole(verdict)


def _passes(verdict: Plain, found: list[Fault], known: set[str]) -> Xml.Element:
    """A case for each pass, and how its biases that are accepted are called."""
    suite = _suite("passes")
    wrong = {f.key: f for f in found if f.kind == "pass"}
    declared = verdict["declaration"] or {"biases": []}
    for one in verdict["passes"]:
        case = _case(suite, one["name"])
        name, status = one["name"], one["status"]
        biases = [b for b in declared["biases"] if b["pass"] == name]
        _properties(case, [("status", status), *_explained(one)])
        if name in wrong:
            _outcome(case, [wrong[name]], known)
        elif status == "not judged":
            _skip(case, _why_not(verdict, name))
        told = [b["told"] for b in biases if b["accepted"]]
        told += [diagnosis_of(one)] if status in ("departs", "by design") else []
        if told:
            Xml.SubElement(case, "system-out").text = _clean("\n".join(told))
    return suite


def _explained(one: Plain) -> Iterator[tuple[str, str]]:
    for key in ("departures", "designed", "mistakes"):
        names = [name for each in one["explanations"] for name in each[key]]
        if names:
            yield key, ", ".join(dict.fromkeys(names))


def _why_not(verdict: Plain, name: str) -> str:
    if name in verdict["absent"]:
        return "the backend does not have it"
    asked = verdict["asked"]
    chosen = name in asked["only"] if asked.get("only") else True
    if not chosen or name in asked.get("skip", ()):
        return "not asked"
    if verdict["left"] or any(step["unasked"] for step in verdict["steps"]):
        return "not judged: there was no time"
    return "not judged: no step that was taken asks for it"


def _level(verdict: Plain, level: str, known: set[str]) -> Xml.Element:
    """Steps of a level that test several passes at once, or that had no time."""
    suite = _suite(level)
    for step in verdict["steps"]:
        if level_of(step) != level:
            continue
        case = _case(suite, stable_title(step), step["seconds"])
        text = "\n".join(step["together"])
        if step["asked"] == step["unanswered"] and not step["unasked"]:
            _skip(case, "the backend has nothing that it asks for")
        elif step["together"]:
            each = [together(step, one) for one in step["together"]]
            worst = next((f for f in each if f.name not in known), each[0])
            _failure(case, worst.first, text, worst.name in known)
        elif step["void"] and step["faults"]:
            _skip(case, "not held against the backend: rests on what it does otherwise")
        elif step["unasked"]:
            _skip(case, f"no time: {step['unasked'][0]}")
        if step["wrong_passes"]:
            told = f"wrong in {', '.join(step['wrong_passes'])}, told in suite passes"
            Xml.SubElement(case, "system-out").text = _clean(told)
    for title in (*verdict["left"], *verdict["not_asked"]):
        if title.startswith(f"{level} "):
            why = "no time" if title in verdict["left"] else "not asked, by --quick"
            _skip(_case(suite, title), why)
    return suite


def _further(found: list[Fault], known: set[str]) -> Xml.Element:
    """What is wrong and is neither a pass nor a step, a case each."""
    suite = _suite("requirements")
    for fault in found:
        if fault.kind in ("bias", "missing", "near", "extremes"):
            _outcome(_case(suite, fault.key), [fault], known)
    return suite


def _whole(verdict: Plain) -> Xml.Element:
    """What the exit code says, if no other case does."""
    suite = _suite("verdict")
    case = _case(suite, "verdict")
    beside = verdict.get("baseline")
    status = beside["status"] if beside else verdict["status"]
    text = f"{verdict['status']}: {verdict['headline']}"
    if beside:
        text = f"{beside['told'][-1]}; the verdict: {text}"
    if status == "UNDECIDED":
        error = Xml.SubElement(case, "error", message=_clean(text), type=status)
        error.text = _clean("\n".join([text, *verdict.get("left", ())]))
    elif status == "FAIL":
        new = beside["new"] if beside else []
        _failure(case, text, "\n".join([text, *new]), False)
    else:
        Xml.SubElement(case, "system-out").text = _clean(text)
    return suite


def _pictures_told(verdict: Plain) -> Iterator[tuple[str, str]]:
    if "looks" in verdict:
        yield "pictures", str(verdict["pictures"])
        yield "convention", verdict["convention"]["words"]


def _outcome(case: Xml.Element, found: Iterable[Fault], known: set[str]) -> None:
    for fault in found:
        _failure(case, fault.first, fault.told, fault.name in known)


def _failure(case: Xml.Element, first: str, text: str, is_known: bool) -> None:
    """A failure, or what is skipped since the baseline has it."""
    if is_known:
        _skip(case, f"known in the baseline: {first}", text)
        return
    line = _clean(" ".join(first.split()))
    failure = Xml.SubElement(case, "failure", message=line, type="wrong")
    failure.text = _clean(text)


def _skip(case: Xml.Element, why: str, text: str = "") -> None:
    Xml.SubElement(case, "skipped", message=_clean(why)).text = _clean(text) or None


def _suite(name: str) -> Xml.Element:
    return Xml.Element("testsuite", name=f"{PREFIX}.{name}")


def _case(suite: Xml.Element, name: str, seconds: float = 0.0) -> Xml.Element:
    about = {"classname": suite.get("name", ""), "name": _clean(name)}
    return Xml.SubElement(suite, "testcase", about, time=f"{seconds:.3f}")


def _properties(of: Xml.Element, pairs: Iterable[tuple[str, str]]) -> None:
    listed = list(pairs)
    if listed:
        # The first child, as the schemas of CI systems have it.
        properties = Xml.Element("properties")
        of.insert(0, properties)
        for name, value in listed:
            about = {"name": name, "value": _clean(value)}
            Xml.SubElement(properties, "property", about)


def _count(suite: Xml.Element) -> None:
    cases = suite.findall("testcase")
    suite.set("tests", str(len(cases)))
    for key, tag in (
        ("failures", "failure"),
        ("errors", "error"),
        ("skipped", "skipped"),
    ):
        suite.set(key, str(sum(case.find(tag) is not None for case in cases)))
    suite.set("time", f"{sum(float(case.get('time', '0')) for case in cases):.3f}")


def _clean(text: str) -> str:
    """Text that XML can hold: what it has no form for is written out."""
    return NOT_XML.sub(lambda found: f"\\x{ord(found[0]):02x}", text)
