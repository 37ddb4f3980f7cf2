"""What a backend declared, what it follows of that, and what was found besides."""

from typing import Any

from restir_gi.reference.oracle.declaration.followed import BiasByDesign
from restir_gi.reference.oracle.verdict import Verdict
from restir_gi.reference.reports.verdict.rows import as_number


def declaration_of(verdict: Verdict) -> dict[str, Any] | None:
    """The declaration of a backend for programs; ``None`` where there is none."""
    said = verdict.declaration
    if not said.says_anything:
        return None
    return {
        "has": dict(said.has),
        "choices": {h.name: list(h.passes) for h in said.hypotheses},
        "accept": sorted(said.accept),
        "generator": said.generator,
        "followed": [
            {
                "pass": one.pass_name,
                "state": one.state,
                "declared": list(one.declared),
                "found": list(one.found),
                "undeclared": list(one.undeclared),
                "told": one.text,
            }
            for one in verdict.followed
        ],
        "biases": [_bias(one) for one in verdict.biases],
        "measured": measured_of(verdict),
        "to_accept": verdict.to_accept or None,
    }


def measured_of(verdict: Verdict) -> dict[str, Any] | None:
    """Bias of the mean of whole runs for programs; ``None`` where none were made."""
    measured = verdict.measured
    if measured is None:
        return None
    return {
        "relative": as_number(measured.relative),
        "error": as_number(measured.error),
        "runs": measured.runs,
        "told": measured.text,
    }


def _bias(one: BiasByDesign) -> dict[str, Any]:
    size = one.size
    return {
        "pass": one.pass_name,
        "choices": list(one.names),
        "accepted": one.accepted,
        "light": size
        and {"beside": size.beside, "least": size.least, "most": size.most},
        "told": one.text,
    }


def biased_by_design(verdict: Verdict) -> str:
    """Which choices bias what, and by how much, in one line.

    As measured, if whole runs were made, else as calculated where it is most.
    """
    names = dict.fromkeys(name for one in verdict.biases for name in one.names)
    passes = dict.fromkeys(one.pass_name for one in verdict.biases)
    where = f"biased by design in {', '.join(names)}, in {', '.join(passes)}"
    if verdict.measured is not None:
        return f"{where}: {verdict.measured.text}"
    sizes = [one.size for one in verdict.biases if one.size is not None]
    most = max(sizes, key=lambda size: abs(size.beside), default=None)
    return where if most is None else f"{where}: {most.text} (summed exactly)"
