"""Innocent departures, one at a time, in pairs and in triples, of one renderer.

Each is a value of one of its options, so that two of different options go together,
whatever they are.  Nothing is taken from the project's own list of departures.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from tests.foreign.renderer import ORDERS, ForeignRenderer
from tests.foreign.storage import STORAGES

VALUES = {
    "order": [order for order in ORDERS if order != "contract"],
    "draws": ["reservoir"],
    "u": ["1 - u"],
    "accept": ["<="],
    "cap": ["arrival", "past", "both", "never"],
    "target": ["outgoing", "no albedo", "no pi", "doubled", "root"],
    "luminance": ["601", "mean", "sum", "largest"],
    "floor": [0.01],
    "mis": [
        "balance",
        "balance first",
        "uneven",
        "pairwise",
        "defensive",
        "share",
        "chained",
    ],
    "null_weight": [True],
    "back_test": [False],
    "limit": [3.0, 10.0],
    "bytes": [True],
    "storage": [name for name in STORAGES if name != "float32"],
}

DEPARTURES = tuple((name, value) for name, of in VALUES.items() for value in of)
"""Option and value of each, 40 of them."""

TARGETS = ("target", "luminance", "floor", "back_test")
PASSES = ("temporal", "moved", "spatial")


def compatible(chosen: tuple[tuple[str, object], ...]) -> bool:
    """Whether departures go together: each is of another option, and shows.

    Which reservoir a number belongs to does not show in the contract's own order.
    """
    names = [name for name, _ in chosen]
    shows = "draws" not in names or "order" in names or len(names) == 1
    return len(set(names)) == len(names) and shows


def sets_of(count: int) -> Iterator[dict[str, object]]:
    """All sets of so many departures that go together, as options of a renderer."""
    for chosen in combinations(DEPARTURES, count):
        if compatible(chosen):
            yield dict(chosen)


def sample(count: int, how_many: int, seed: int) -> list[dict[str, object]]:
    """Some of all sets of so many departures, the same at every run."""
    sets = list(sets_of(count))
    chosen = np.random.default_rng(seed).choice(len(sets), how_many, replace=False)
    return [sets[row] for row in chosen]


ONCE_ACCUSED = (
    {"cap": "arrival", "mis": "balance", "storage": "octahedral"},
    {"order": "own first", "mis": "balance", "storage": "32 bytes"},
    {"luminance": "largest", "mis": "uneven", "storage": "RGBE"},
    {"order": "reversed", "target": "no albedo", "floor": 0.01},
    {"order": "reversed", "target": "outgoing", "mis": "chained"},
)
"""Triples that a verdict was once not true of."""


def called(options: dict[str, object]) -> str:
    """Name of a set."""
    return ", ".join(f"{name}: {value}" for name, value in options.items())


def passes_of(options: dict[str, object]) -> tuple[str, ...]:
    """Passes in which a renderer with these options may differ from the contract."""
    found = PASSES
    if set(options) & set(TARGETS):
        found = ("target", "initial", *found)
    elif "null_weight" in options:
        found = ("initial", *found)
    if "back_test" in options:
        found = ("jacobian", *found, "shade")
    return ("merge", *found) if {"u", "accept"} & set(options) else found


def composed(*departures: dict[str, object]) -> ForeignRenderer:
    """A renderer with all of these at once."""
    options: dict[str, object] = {}
    for one in departures:
        options |= one
    return ForeignRenderer(**options)
