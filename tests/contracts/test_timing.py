"""Timings by a clock that stands still between the calls."""

from types import SimpleNamespace

import pytest

from restir_gi.reference.numerics.intervals import Interval
from restir_gi.reference.reports import timing
from restir_gi.reference.reports.timing import (
    Lap,
    in_turns,
    seconds_in_turns,
    time_ratio,
    timed,
)


@pytest.fixture
def clock(monkeypatch):
    """Calls move it on by themselves."""
    now = SimpleNamespace(seconds=0.0)
    perf_counter = SimpleNamespace(perf_counter=lambda: now.seconds)
    monkeypatch.setattr(timing, "time", perf_counter)
    return now


def takes(clock, seconds, asked, name):
    """A call that takes ever longer: once, twice, three times so many seconds."""

    def call():
        asked.append(name)
        count = asked.count(name)
        clock.seconds += count * seconds
        return name, count

    return call


def test_a_call_has_its_result_and_its_seconds(clock):
    assert timed(takes(clock, 2.5, [], "a")) == Lap(("a", 1), 2.5)


def test_calls_take_turns(clock):
    asked = []
    calls = {name: takes(clock, s, asked, name) for name, s in (("a", 1.0), ("b", 5.0))}
    turns = []
    for turn in in_turns(calls, 3):
        turns.append(turn)
        clock.seconds += 1000.0  # what is done between turns is nobody's time
    assert asked == ["a", "b"] * 3
    assert turns == [
        {"a": Lap(("a", k), 1.0 * k), "b": Lap(("b", k), 5.0 * k)} for k in (1, 2, 3)
    ]


def test_seconds_are_those_of_the_turns(clock):
    calls = {name: takes(clock, 1.0, [], name) for name in "ab"}
    assert seconds_in_turns(calls, 2) == {"a": [1.0, 2.0], "b": [1.0, 2.0]}


def test_what_slows_a_turn_leaves_its_ratio():
    """The median of the ratios is not the ratio of the medians."""
    below = [1.0, 100.0, 1.0, 1.0, 3.0, 1.0]
    above = [2.0 * s for s in below]
    assert time_ratio(above, below) == Interval(2.0, 2.0, 2.0)
    # Control: seconds of other turns say less.
    assert time_ratio(above, below[::-1]) != Interval(2.0, 2.0, 2.0)


def test_turns_that_are_not_the_same_have_no_ratio():
    with pytest.raises(ValueError, match="zip"):
        time_ratio([1.0, 2.0], [1.0])
