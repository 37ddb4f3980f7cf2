"""Captures of engines that reuse time and space in one pass."""

import pytest

from tests.captures.fused import MISTAKES, FusedEngine
from tests.captures.test_engine import said, verdict_on


def test_a_right_engine_passes(tmp_path):
    verdict = verdict_on(FusedEngine(48), tmp_path)
    assert verdict.status == "PASS", said(verdict)
    assert verdict.judged == {"fused", "shade"}
    assert verdict.at_extremes == []


QUICK = ("JacobianLeftOut", "NotSwapped")


@pytest.mark.parametrize(
    "mistake",
    [
        pytest.param(one, marks=() if one.__name__ in QUICK else pytest.mark.slow)
        for one in MISTAKES
    ],
    ids=lambda one: one.__name__,
)
def test_a_mistake_fails_and_is_named(tmp_path, mistake):
    verdict = verdict_on(mistake(mistake.size), tmp_path)
    assert verdict.status == "FAIL"
    text = said(verdict)
    assert all(words in text for words in mistake.named), text
