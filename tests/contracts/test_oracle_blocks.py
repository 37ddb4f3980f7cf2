"""A replay in blocks finds what one of all rows at once does."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.capture.shares import candidates_of
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.parts import judge_of
from restir_gi.reference.oracle.replay import blocks
from restir_gi.reference.oracle.replay.reuse import STREAMS
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES

BACKEND = BuiltIn("float32")
CASES = {probe.case.pass_name: probe.case for probe in row_probes("float32")}
"""The last one of each pass."""
RULES = {
    "the contract's": CONTRACT_RULES,
    # A neighbour that is not there is then row 0 of all, not of the block.
    "row 0 for none": replace(CONTRACT_RULES, none_is_first=True),
    "stored in 32 bytes": replace(CONTRACT_RULES, storage="rtxdi"),
}


def answer(case):
    """What the built-in backend gives, wrong in each seventh row."""
    outputs = getattr(BACKEND, case.pass_name)(**case.inputs, **case.settings)
    spoiled = next(n for n, a in outputs.items() if a.dtype.kind == "f")
    return outputs | {spoiled: outputs[spoiled] * np.float32(1.5)}


@pytest.mark.parametrize("rules", RULES.values(), ids=RULES)
def test_blocks_find_what_is_found_at_once(rules, monkeypatch):
    for case in (CASES[name] for name in CASES if name in blocks.BY_ROW):
        judge = judge_of(case.pass_name)
        outputs = answer(case)
        whole = judge(case, outputs, rules, "float32")
        chances = case.pass_name in STREAMS and candidates_of(
            case, outputs, rules, "float32"
        )
        with monkeypatch.context() as patch:
            patch.setattr(blocks, "BLOCK", case.rows // 3)
            assert len(list(blocks.blocks(case))) >= 3
            found = judge(case, outputs, rules, "float32")
            if chances:
                again = candidates_of(case, outputs, rules, "float32")
                for name in ("w", "error", "same", "held", "shown"):
                    np.testing.assert_array_equal(
                        getattr(again, name), getattr(chances, name)
                    )
        assert whole.wrong.any()
        for one, other in zip(whole.compared, found.compared, strict=True):
            assert one.name == other.name
            for part in ("found", "expected", "allowed"):
                np.testing.assert_array_equal(getattr(one, part), getattr(other, part))
        assert whole.terms.keys() == found.terms.keys()
        for name, term in whole.terms.items():
            np.testing.assert_array_equal(term, found.terms[name])
        if whole.decisions is not None:
            np.testing.assert_array_equal(
                whole.decisions.illegal, found.decisions.illegal
            )
            assert whole.decisions.differing == found.decisions.differing
            assert whole.decisions.expected == pytest.approx(found.decisions.expected)
