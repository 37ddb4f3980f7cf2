"""Negative controls of the enumeration: planted mistakes, and what refutes each.

``pytest -m slow tests/exact`` leaves the kill matrix in pytest's temporary folder.
"""

import pytest

from tests.exact import claims
from tests.exact.mutants import CLAIMS, MUTANTS, PRODUCTION, SURVIVORS

KILLS = [(mutant, claim) for mutant in MUTANTS for claim in mutant.killed_by]


def is_refuted(mutant, claim):
    """Whether a claim, true of the kernels, finds a fault in the mutant."""
    return next(claim(mutant.plant()), None) is not None


def test_the_mutants_are_many_and_different():
    edits = {(mutant.module, mutant.old, mutant.new) for mutant in MUTANTS}
    assert len(edits) == len(MUTANTS) >= 40
    assert all(mutant.killed_by for mutant in MUTANTS)


@pytest.mark.parametrize(
    ("mutant", "claim"), KILLS, ids=[f"{m.name} - {claim}" for m, claim in KILLS]
)
def test_mutant_is_refuted(mutant, claim):
    assert is_refuted(mutant, getattr(claims, claim))


@pytest.mark.parametrize("mutant", SURVIVORS, ids=lambda mutant: mutant.name)
def test_what_an_expectation_cannot_see(mutant):
    """Unbiased all the same: they need another kind of evidence, and get it."""
    code = mutant.plant()
    for claim in (claims.several_candidates, claims.spatial_pass, claims.balance_pass):
        assert list(claim(code)) == []


@pytest.mark.parametrize("mutant", SURVIVORS[:2], ids=lambda mutant: mutant.name)
def test_other_weights_are_another_law(mutant):
    """The survivors do change something: the law of W, though not its mean."""

    def law(code):
        frames = claims.fresh_frame(code)
        return claims.resampled(code, frames, 0, mis="balance").as_dict()

    assert law(mutant.plant()) != law(PRODUCTION)


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
