"""Negative controls of the enumeration: planted mistakes, and what refutes each.

``pytest -m slow tests/exact`` leaves the kill matrix in pytest's temporary folder.
"""

import pytest

from tests.exact import claims
from tests.exact.mutants import CLAIMS, MUTANTS, SURVIVORS, is_refuted
from tests.mutants.plant import planted, source_of

KILLS = [(mutant, claim) for mutant in MUTANTS for claim in mutant.killed_by]


def test_the_mutants_are_many_and_different():
    edits = {mutant.edits for mutant in MUTANTS}
    assert len(edits) == len(MUTANTS) >= 55
    assert all(mutant.killed_by for mutant in MUTANTS)


@pytest.mark.parametrize("mutant", MUTANTS + SURVIVORS, ids=lambda mutant: mutant.name)
def test_every_edit_has_its_place(mutant):
    for module, old, _ in mutant.edits:
        assert source_of(module).count(old) == 1


@pytest.mark.parametrize(
    ("mutant", "claim"), KILLS, ids=[f"{m.name} - {claim}" for m, claim in KILLS]
)
def test_mutant_is_refuted(mutant, claim):
    assert is_refuted(mutant, getattr(claims, claim))


@pytest.mark.parametrize("mutant", SURVIVORS, ids=lambda mutant: mutant.name)
def test_what_an_expectation_cannot_see(mutant):
    """Unbiased all the same: they need another kind of evidence, and get it."""
    for claim in (claims.several_candidates, claims.spatial_pass, claims.balance_pass):
        assert not is_refuted(mutant, claim)


@pytest.mark.parametrize("mutant", SURVIVORS[:2], ids=lambda mutant: mutant.name)
def test_other_weights_are_another_law(mutant):
    """The survivors do change something: the law of W, though not its mean."""
    frames = claims.fresh_frame()
    whole = claims.spatial_law(frames, 0, mis="balance").as_dict()
    with planted(mutant):
        assert claims.spatial_law(frames, 0, mis="balance").as_dict() != whole


@pytest.mark.slow
def test_kill_matrix(tmp_path):
    """Which claim kills which mutant, all against all."""
    lines = []
    for mutant in MUTANTS + SURVIVORS:
        killers = [claim.__name__ for claim in CLAIMS if is_refuted(mutant, claim)]
        assert set(mutant.killed_by) <= set(killers)
        assert bool(killers) == bool(mutant.killed_by)
        lines.append(f"{mutant.name}: {', '.join(killers) or 'survives'}")
    (tmp_path / "kill_matrix.txt").write_text("\n".join(lines), encoding="utf-8")
