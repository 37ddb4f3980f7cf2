"""The enumeration itself: it integrates what it is given, and nothing else."""

from fractions import Fraction as F

import numpy as np
import pytest

from tests.exact.explore import Law, draw, explore

NOWHERE = Law.certain(None)


def law_of(program):
    return {key: p for (key,), p in explore(program, NOWHERE).as_dict().items()}


def full(rows, value):
    return np.full(len(rows), value, object)


@pytest.mark.parametrize(
    "compare",
    [
        lambda u, w, b: u * w < b,
        lambda u, w, b: w * u < b,
        lambda u, w, b: b > u * w,
        lambda u, w, b: u < b / w,
        lambda u, w, b: u * w <= b,
        lambda u, w, b: ~(u * w >= b),
        lambda u, w, b: ~(b <= u * w),
    ],
)
def test_every_spelling_of_a_decision_has_its_probability(compare):
    def program(rows, uniform):
        return compare(uniform(), full(rows, F(7)), full(rows, F(2))).astype(object)

    assert law_of(program) == {True: F(2, 7), False: F(5, 7)}


def test_a_number_that_is_asked_twice_gives_answers_that_fit():
    """P(u < 1/2 and u < 1/3) = 1/3, not 1/6."""

    def program(rows, uniform):
        u = uniform()
        first, second = u < full(rows, F(1, 2)), u < full(rows, F(1, 3))
        return first.astype(object) * 10 + second

    assert law_of(program) == {11: F(1, 3), 10: F(1, 6), 0: F(1, 2)}


def test_two_numbers_are_independent():
    def program(rows, uniform):
        first = uniform() < full(rows, F(1, 2))
        second = uniform() < full(rows, F(1, 3))
        return first.astype(object) * 10 + second

    expected = {11: F(1, 6), 10: F(1, 3), 1: F(1, 6), 0: F(1, 3)}
    assert law_of(program) == expected


def test_what_is_certain_does_not_split():
    def program(rows, uniform):
        never, always = uniform() * full(rows, F(3)) < 0, uniform() < 1
        tie = uniform() * full(rows, F(0)) < full(rows, F(0))
        weak_tie = uniform() * full(rows, F(0)) <= full(rows, F(0))
        return np.array(
            [f"{a}{b}{c}{d}" for a, b, c, d in zip(never, always, tie, weak_tie, strict=True)],
            object,
        )  # fmt: skip

    assert law_of(program) == {"FalseTrueFalseTrue": F(1)}


def test_draw_has_the_probabilities_of_its_table():
    table = [F(1, 3), F(0), F(1, 4)]
    law = law_of(lambda rows, uniform: draw(uniform(), table).astype(object))
    assert law == {0: F(1, 3), 2: F(1, 4), 3: F(5, 12)}


def test_rows_of_the_start_keep_their_probabilities():
    start = Law(np.array([F(1, 3), F(1, 2)], object), np.array([F(1, 4), F(3, 4)]))
    law = explore(lambda rows, uniform: uniform() < rows, start).as_dict()
    yes = F(1, 4) * F(1, 3) + F(3, 4) * F(1, 2)
    assert law == {(True,): yes, (False,): 1 - yes}


def test_control_a_program_that_loses_rows_is_noticed():
    start = Law(np.array([F(1), F(2)], object), np.array([F(1, 2), F(1, 2)]))
    with pytest.raises(AssertionError):
        explore(lambda rows, uniform: rows[:1], start)
