"""Mistakes in the production code are found by the ladder, and called by name."""

import pytest

from tests.mutants.catalogue import BY_NAME, MUTANTS, NOTHING
from tests.mutants.harness import EXACT, kill
from tests.mutants.plant import source_of

QUICK = (
    "the distances are upside down",
    "one number for all neighbours",
    "M is capped before it divides",
    "1/M where 1/Z is needed",
    "Z does not ask for visibility",
    "the target is the red channel",
    "shading shows the target",
    "the search radius is not halved",
    "no temporal Jacobian when the visible point moves",
)


def test_every_edit_has_its_place():
    for mutant in MUTANTS:
        for module, old, _ in mutant.edits:
            assert source_of(module).count(old) == 1, (mutant.name, module)


def test_names_are_different():
    assert len(BY_NAME) == len(MUTANTS)


@pytest.mark.parametrize("mutant", [None, NOTHING], ids=["unedited", "edit of nothing"])
def test_without_a_mistake_nothing_is_seen(mutant):
    """Else a kill would not count."""
    assert kill(mutant, EXACT).first == ""


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.few(3)
def test_a_mistake_is_killed_under_its_name(name):
    found = kill(BY_NAME[name], EXACT)
    assert found.killed
    assert found.named in ("right", "several")


# Of confidences within the cap nothing tells a cap on arrival from none.
@pytest.mark.parametrize(
    ("name", "named"),
    [("the target lacks the cosine", "right"), ("M is not capped", "several")],
)
@pytest.mark.few(1)
def test_a_departure_is_named_and_passes(name, named):
    found = kill(BY_NAME[name], EXACT)
    assert (found.status, found.named) == ("PASS", named)


@pytest.mark.slow
def test_what_is_equivalent_passes():
    """But for another generator, in whose place random numbers are given as data."""
    kills = [kill(m, EXACT) for m in MUTANTS if m.kind == "equivalent"]
    assert [k.mutant.name for k in kills if k.killed] == ["another shift in the hash"]


@pytest.mark.slow
def test_the_ladder_kills_95_percent_and_names_70():
    kills = [kill(m, EXACT) for m in MUTANTS if m.kind == "bias"]
    dead = [k for k in kills if k.killed]
    assert len(dead) >= 0.95 * len(kills)
    assert all(k.total < 60 for k in kills)
    wrong = [k.mutant.name for k in dead if k.named == "WRONG"]
    named = [k for k in dead if k.named in ("right", "several")]
    assert wrong == []
    assert len(named) >= 0.7 * len(dead)
