"""Which answers of a pass a mistake has to explain."""

from collections.abc import Mapping, Sequence

from restir_gi.reference.oracle.levels.probe import Answer

SEVERAL: Mapping[str, str] = {"pack": "layout", "unpack": "layout"}
"""Passes that are several in one, by a setting: what is wrong with one of its values
need not be wrong with another."""


def at_fault(name: str, answers: Sequence[Answer]) -> list[list[Answer]]:
    """Answers to each value of a setting with which something is wrong.

    All answers together, where the pass is one, or where nothing is wrong.
    """
    if name not in SEVERAL:
        return [list(answers)]
    groups: dict[object, list[Answer]] = {}
    for answer in answers:
        value = answer.probe.case.settings.get(SEVERAL[name])
        groups.setdefault(value, []).append(answer)
    wrong = [
        group
        for group in groups.values()
        if any(a.finding is not None and not a.finding.passed for a in group)
    ]
    return wrong or [list(answers)]
