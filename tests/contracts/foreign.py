"""What the tests of foreign backends share."""

from pathlib import Path
from shutil import copytree, ignore_patterns

from restir_gi.reference.oracle.ladder import ladder, scene_probes
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.lattice import lattice_probes
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.steps import asked
from restir_gi.reference.oracle.verdict import run_ladder

CONTRACT = whole_contract()
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
FURTHER = ["fused", *(one.name for part in parts() for one in part.passes)]
"""Passes beside those from `random` to `shade`."""


NAMED = {
    "jacobian-divided": "jacobian-inverted",
    "jacobian-omitted": "jacobian-omitted",
    "jacobian-unsquared": "jacobian-unsquared",
    "jacobian-receiver-cosine": "jacobian-receiver-cosine",
    "jacobian-clamped": "jacobian-clamped-to-3",
    "cosine-omitted": "target-without-cosine",
    "cosine-twice": "target-cosine-twice",
    "missing-one-over-pi": "target-without-pi",
    "one-over-m": "one-over-m",
    "nulls-not-counted": "nulls-not-counted",
    "m-times-two": "neighbors-counted-double",
    "cap-missing": "never-capped",
    "confidence-missing": "confidence-missing-in-weight",
    "source-target": "divided-by-the-donors-target",
    "canonical-missing": "canonical-missing-in-z",
    "visibility-ignored-in-z": "visibility-missing-in-z",
    "visibility-ignored-in-weight": "visibility-missing-in-weight",
    "hidden-not-counted": "hidden-not-counted",
    "accept-old-sum": "accepts-by-the-old-sum",
    "wrong-pdf": "density-of-half-the-hemisphere",
    "random-reused": "one-number-for-all-neighbors",
    "depth-relative-to-own": "depth-relative-to-own",
    "radius-not-halved": "radius-not-halved",
    "albedo-missing": "shade-without-albedo",
    "cap-before-weight": "capped-before-weight",
}
"""Planted mistakes, and what diagnosis calls them."""


def passed_the_whole_ladder(backend):
    """Names of the passes that it does not have; all others are right."""
    try:
        found = run_ladder(
            CONTRACT,
            "float32",
            ladder(CONTRACT, backend),
            60,
            lambda: 0.0,
            lambda title: None,
        )
    finally:
        backend.close()
    assert [text for timed in found.steps for text in timed.step.faults] == []
    assert found.status == "PASS"
    return found.absent


def planted_copy(folder, to, old, new):
    """The folder of an example, in which one line reads otherwise.

    Returns the path of its ``backend.py``.
    """
    copy = copytree(folder, to / folder.name, ignore=ignore_patterns("__pycache__"))
    texts = {path: path.read_text(encoding="utf-8") for path in copy.iterdir()}
    (path,) = [path for path, text in texts.items() if old in text]
    assert texts[path].count(old) == 1
    path.write_text(texts[path].replace(old, new), encoding="utf-8")
    return copy / "backend.py"


def short_ladder(backend, probes):
    """Verdict by probes that are made once for all mistakes."""

    def take():
        return asked("L3", "all", CONTRACT, backend, probes)

    levels = iter([("L3", "all", take)])
    try:
        return run_ladder(
            CONTRACT, "float32", levels, 60, lambda: 0.0, lambda title: None
        )
    finally:
        backend.close()


def all_probes():
    """Kernels, lattices and one scene in which all mistakes show."""
    found = [*kernel_probes("float32"), *lattice_probes("float32")]
    return [*found, *scene_probes("cornell-box", "float32")]


ALSO = {
    "missing-one-over-pi": {"shade-without-pi"},
    "cosine-omitted": {"shade-without-cosine"},
    "cosine-twice": {"shade-cosine-twice"},
    # Where all that arrives is within the cap, a cap on arrival does nothing.
    "cap-missing": {
        "capped-on-arrival",
        "past-capped-on-arrival",
        "capped-everywhere-on-arrival",
        "cap-off-by-one",
    },
}
"""Other names that are right: of another pass, or of what gives the same numbers."""


DEPARTS = {"cap-missing"}
"""No bias comes of it: named, and not held against the backend."""


def assert_named(verdict, plant):
    """Each pass that is wrong has the mistake's name, or a right one beside it."""
    right = {NAMED[plant]} | ALSO.get(plant, set())
    names = [{h.name for h in one.matches} for one in verdict.diagnoses]
    assert verdict.status == ("PASS" if plant in DEPARTS else "FAIL")
    assert any(NAMED[plant] in found for found in names)
    assert all(found & right and len(found - right) <= 1 for found in names), names
