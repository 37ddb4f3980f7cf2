"""The enumeration itself: it integrates what it is given, and nothing else."""

from fractions import Fraction

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
        return compare(
            uniform(), full(rows, Fraction(7)), full(rows, Fraction(2))
        ).astype(object)

    assert law_of(program) == {True: Fraction(2, 7), False: Fraction(5, 7)}


def test_a_number_that_is_asked_twice_gives_answers_that_fit():
    """P(u < 1/2 and u < 1/3) = 1/3, not 1/6."""

    def program(rows, uniform):
        u = uniform()
        first, second = u < full(rows, Fraction(1, 2)), u < full(rows, Fraction(1, 3))
        return first.astype(object) * 10 + second

    assert law_of(program) == {
        11: Fraction(1, 3),
        10: Fraction(1, 6),
        0: Fraction(1, 2),
    }


def test_two_numbers_are_independent():
    def program(rows, uniform):
        first = uniform() < full(rows, Fraction(1, 2))
        second = uniform() < full(rows, Fraction(1, 3))
        return first.astype(object) * 10 + second

    expected = {
        11: Fraction(1, 6),
        10: Fraction(1, 3),
        1: Fraction(1, 6),
        0: Fraction(1, 3),
    }
    assert law_of(program) == expected


def test_what_is_certain_does_not_split():
    def program(rows, uniform):
        never, always = uniform() * full(rows, Fraction(3)) < 0, uniform() < 1
        tie = uniform() * full(rows, Fraction(0)) < full(rows, Fraction(0))
        weak_tie = uniform() * full(rows, Fraction(0)) <= full(rows, Fraction(0))
        return never * 1000 + always * 100 + tie * 10 + weak_tie.astype(object)

    assert law_of(program) == {101: Fraction(1)}


def test_draw_has_the_probabilities_of_its_table():
    table = [Fraction(1, 3), Fraction(0), Fraction(1, 4)]
    law = law_of(lambda rows, uniform: draw(uniform(), table).astype(object))
    assert law == {0: Fraction(1, 3), 2: Fraction(1, 4), 3: Fraction(5, 12)}


def test_rows_of_the_start_keep_their_probabilities():
    start = Law(
        np.array([Fraction(1, 3), Fraction(1, 2)], object),
        np.array([Fraction(1, 4), Fraction(3, 4)]),
    )
    law = explore(lambda rows, uniform: uniform() < rows, start).as_dict()
    yes = Fraction(1, 4) * Fraction(1, 3) + Fraction(3, 4) * Fraction(1, 2)
    assert law == {(True,): yes, (False,): 1 - yes}


def test_control_a_program_that_loses_rows_is_noticed():
    start = Law(
        np.array([Fraction(1), Fraction(2)], object),
        np.array([Fraction(1, 2), Fraction(1, 2)]),
    )
    with pytest.raises(AssertionError):
        explore(lambda rows, uniform: rows[:1], start)
