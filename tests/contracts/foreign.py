"""What the tests of foreign backends share."""

from reference.oracle.contract.registry import CONTRACT
from reference.oracle.ladder import scene_probes
from reference.oracle.rungs.kernels import kernel_probes
from reference.oracle.rungs.lattice import lattice_probes
from reference.oracle.steps import Step, ask_all
from reference.oracle.verdict import climb

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
}
"""Planted mistakes, and what diagnosis calls them."""


def short_ladder(backend, probes):
    """Verdict by probes that are made once for all mistakes."""

    def take():
        return Step("L3", "all", ask_all(CONTRACT, backend, probes))

    rungs = iter([("L3", "all", take)])
    try:
        return climb(CONTRACT, "float32", rungs, 60, lambda: 0.0, lambda title: None)
    finally:
        backend.close()


def all_probes():
    """Kernels, lattices and one scene in which all mistakes show."""
    found = [*kernel_probes("float32"), *lattice_probes("float32")]
    return [*found, *scene_probes("cornell-box", "float32")]


def assert_named(verdict, plant):
    """Some pass has the mistake's name alone, and none has only another."""
    assert verdict.status == "FAIL"
    names = [{h.name for h in one.matches} for one in verdict.diagnoses]
    assert {NAMED[plant]} in names
    aliases = {"shade-without-pi"} if plant == "missing-one-over-pi" else set()
    assert all(n <= {NAMED[plant]} | aliases for n in names), names
