"""A verdict as SARIF 2.1.0, which code hosts show beside the code."""

import ast
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from restir_gi.reference.reports.integration.faults import (
    Fault,
    Plain,
    diagnosis_of,
    faults,
    named_in,
)
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.files import read_file
from restir_gi.reference.system.version import project_version

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
PAGE = "docs/explanation/bugs.md"
MOST_SOURCE = 2**24

GENERAL = {
    "no-known-mistake": "A pass is wrong, and no known mistake explains every row.",
    "together": "Passes are wrong together: a test of several of them fails.",
    "required": "A pass that is required was not judged.",
    "biased-by-design": "A declared choice is biased.",
    "extremes": "Wrong beyond the working range, with numbers that no scene has.",
    "pictures": "The pictures are other than the truth.",
    "verdict": "The backend is wrong.",
}
"""Rules that are no known mistake."""

RULE_OF = {
    "bias": "biased-by-design",
    "together": "together",
    "missing": "required",
    "near": "required",
    "extremes": "extremes",
    "pictures": "pictures",
    "verdict": "verdict",
}


def sarif_of(verdict: Plain) -> dict[str, Any]:
    """A verdict as an object of SARIF 2.1.0.

    Rules are the known mistakes that are named, without a link: the page of them
    (`PAGE`) stands in no public place, so that its text is in the rule.
    """
    place = _Place(verdict)
    results = list(_results(verdict, place))
    ids = list(dict.fromkeys(result["ruleId"] for result in results))
    mistakes = {m["name"]: m for m in verdict.get("mistakes", ())}
    for result in results:
        result["ruleIndex"] = ids.index(result["ruleId"])
    driver = {
        "name": "restir-gi-oracle",
        "version": project_version(),
        "rules": [_rule(name, mistakes.get(name)) for name in ids],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "utf16CodeUnits",
        "invocations": [{"executionSuccessful": True}],
        "properties": {
            "status": verdict["status"],
            "headline": verdict["headline"],
            "backend": verdict["backend"],
        },
        "results": results,
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _rule(name: str, mistake: Plain | None) -> dict[str, Any]:
    if mistake is None:
        text = GENERAL[name]
        return {"id": name, "shortDescription": {"text": text}, "help": {"text": text}}
    text = f"{mistake['mistake'][:1].upper()}{mistake['mistake'][1:].rstrip('.')}."
    lines = [text, f"wrong: {mistake['wrong']}", f"right: {mistake['right']}"]
    lines += [f"seen: {'; '.join(mistake['seen'])}"] if mistake["seen"] else []
    return {
        "id": name,
        "shortDescription": {"text": text},
        "fullDescription": {"text": "\n".join(lines[:3])},
        "help": {"text": "\n".join(lines)},
        "properties": {"page": f"{PAGE}#{name}"},
    }


def _results(verdict: Plain, place: "_Place") -> Iterator[dict[str, Any]]:
    beside = verdict.get("baseline")
    known = set(beside["known"]) if beside else set()
    found = faults(verdict)
    for fault in found:
        for rule in _rules_of(fault):
            result = _result(rule, "error", fault.told, place, fault)
            if beside:
                is_known = fault.name in known
                result["baselineState"] = "unchanged" if is_known else "new"
                if is_known:
                    why = f"known in {beside['file']}"
                    result["suppressions"] = [
                        {
                            "kind": "external",
                            "status": "accepted",
                            "justification": why,
                        }
                    ]
            yield result
    if verdict["kind"] == "pictures":
        return
    yield from _notes(verdict, place)
    if not verdict["asked"].get("extremes"):
        for line in verdict["at_extremes"]:
            name = line.partition(":")[0]
            yield _result("extremes", "warning", line, place, None, name)


def _notes(verdict: Plain, place: "_Place") -> Iterator[dict[str, Any]]:
    """Biases that are accepted, and passes that depart without one."""
    declared = verdict["declaration"] or {"biases": []}
    for one in declared["biases"]:
        if one["accepted"]:
            for name in one["choices"]:
                rule = name if _is_told(verdict, name) else "biased-by-design"
                yield _result(rule, "note", one["told"], place, None, one["pass"])
    for one in verdict["passes"]:
        if one["status"] == "departs":
            for name in named_in(one["reason"]):
                yield _result(name, "note", diagnosis_of(one), place, None, one["name"])


def _is_told(verdict: Plain, name: str) -> bool:
    return any(mistake["name"] == name for mistake in verdict["mistakes"])


def _rules_of(fault: Fault) -> list[str]:
    """Rules that a fault breaks: each mistake of the first explanation of a pass."""
    if fault.kind != "pass":
        return [RULE_OF[fault.kind]]
    explanations = fault.of["explanations"]
    return (explanations[0]["mistakes"] if explanations else []) or ["no-known-mistake"]


def _result(
    rule: str,
    level: str,
    told: str,
    place: "_Place",
    fault: Fault | None,
    of: str = "",
) -> dict[str, Any]:
    where = of or (fault.of["name"] if fault and fault.kind == "pass" else "")
    key = f"{rule} {where} {fault.key if fault else ''}"
    return {
        "ruleId": rule,
        "level": level,
        "message": {"text": told},
        "locations": [place.of(where)],
        "partialFingerprints": {
            "restirFault/v1": hashlib.sha256(key.encode("utf-8", "replace")).hexdigest()
        },
    }


class _Place:
    """Where a result is shown: a file of the backend, else its words."""

    def __init__(self, verdict: Plain) -> None:
        self._words = verdict["backend"]
        self._file = _file_of(verdict)
        is_python = self._file is not None and self._file.suffix == ".py"
        self._lines = _lines_of(self._file) if self._file and is_python else {}

    def of(self, pass_name: str) -> dict[str, Any]:
        """Location of a pass; of the whole where it has none."""
        name = pass_name or self._words
        full = f"{self._words}/{pass_name}" if pass_name else self._words
        logical: dict[str, Any] = {"name": name, "fullyQualifiedName": full}
        if self._file is None:
            return {"logicalLocations": [logical]}
        physical: dict[str, Any] = {
            "artifactLocation": _artifact(self._file),
            "region": {"startLine": self._lines.get(pass_name, 1)},
        }
        return {"physicalLocation": physical, "logicalLocations": [logical]}


def _file_of(verdict: Plain) -> Path | None:
    """The Python file of a backend, or the manifest of a capture."""
    words = verdict["backend"]
    path = Path(words.partition(":")[0] if ".py" in words else words)
    try:
        if verdict["kind"] == "capture":
            return path if path.is_file() else path / "capture.toml"
        is_python = verdict["kind"] == "passes" and path.suffix == ".py"
        return path if is_python and path.is_file() else None
    except (OSError, ValueError):  # a command line may be longer than any name
        return None


def _lines_of(path: Path) -> dict[str, int]:
    """Where in a Python file each function begins, the first of a name."""
    try:
        tree = ast.parse(read_file(path, MOST_SOURCE))
    except (UsageError, SyntaxError, ValueError, RecursionError):
        return {}
    found: dict[str, int] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            found.setdefault(node.name, node.lineno)
    return found


def _artifact(path: Path) -> dict[str, str]:
    """Location of a file: relative to the working directory where it is below that."""
    full = Path(os.path.abspath(path))
    try:
        relative = full.relative_to(Path.cwd())
    except ValueError:
        return {"uri": full.as_uri()}
    uri = (Path("/") / relative).as_uri().removeprefix("file:///")
    return {"uri": uri, "uriBaseId": "%SRCROOT%"}
