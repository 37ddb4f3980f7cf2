"""L2: relations between two calls that hold to the last bit, in any arithmetic.

A power of two as a factor changes no digit of a product, a quotient or a sum, in
whatever order they are taken, as long as nothing overflows.  So absolute epsilons,
clamps and caps, which have a scale of their own, cannot hide.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.oracle.cases import Buffers, Case
from reference.oracle.loop import Ask
from reference.oracle.rungs.probe import Finding

Change = Callable[[dict[str, NDArray[Any]]], dict[str, NDArray[Any]]]

SCALE = np.float32(2.0**9)
LENGTH = np.float32(2.0**5)


@dataclass(frozen=True, slots=True)
class Relation:
    """What a change of the inputs does to the outputs.

    Attributes
    ----------
    name : str
        In one line.
    passes : tuple of str
        Where it holds.
    change : callable
        From inputs to inputs.
    factors : mapping of str to float
        By which outputs change; 1 where they are not named.
    """

    name: str
    passes: tuple[str, ...]
    change: Change
    factors: Mapping[str, float]


def _scaled(names: tuple[str, ...], factor: np.float32) -> Change:
    def change(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        return {
            name: array * array.dtype.type(factor) if name.endswith(names) else array
            for name, array in inputs.items()
        }

    return change


def _grey(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {
        name: np.repeat(array[:, :1], 3, axis=1)
        if name.endswith(("radiance", "albedo"))
        else array
        for name, array in inputs.items()
    }


def _dark(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {
        name: array * 0 if name.endswith("radiance") else array
        for name, array in inputs.items()
    }


REUSE = ("temporal", "moved", "spatial")

RELATIONS = (
    Relation(
        "light times 2^9: the image too, and the same choices and W",
        ("initial", *REUSE, "shade"),
        _scaled(("radiance",), SCALE),
        {"radiance": float(SCALE), "color": float(SCALE), "p_hat": float(SCALE)},
    ),
    Relation(
        "lengths times 2^5: nothing changes",
        ("target", "jacobian", "initial", *REUSE, "shade"),
        _scaled(("position", "x_from", "x_to"), LENGTH),
        {"position": float(LENGTH)},
    ),
    Relation(
        "depths times 2^5: the same neighbours",
        ("neighbors",),
        _scaled(("depth",), LENGTH),
        {},
    ),
    Relation(
        "albedo times 2^-3: the image too",
        ("shade",),
        _scaled(("albedo",), np.float32(2.0**-3)),
        {"color": 2.0**-3},
    ),
)


Test = Callable[[Ask], Finding]


def relations_of(case: Case) -> list[Test]:
    """What can be asked of a case and its changes.

    Parameters
    ----------
    case : Case
        Of a scene.

    Returns
    -------
    list of callable
        Each asks a backend, and cannot fail a right one: no tolerance is wanted.
    """
    tests: list[Test] = [
        partial(_holds, relation, case)
        for relation in RELATIONS
        if case.pass_name in relation.passes
    ]
    if case.pass_name == "shade":
        tests += [partial(_grey_stays_grey, case), partial(_dark_is_black, case)]
    return tests


def _holds(relation: Relation, case: Case, ask: Ask) -> Finding:
    before, after = ask(case), ask(_changed(case, relation.change))
    return _compared(case, relation, before, after)


def _changed(case: Case, change: Change) -> Case:
    return replace(case, inputs=change(dict(case.inputs)))


def _compared(
    case: Case, relation: Relation, before: Buffers, after: Buffers
) -> Finding:
    for name, old in before.items():
        wanted = old
        factor = next(
            (f for end, f in relation.factors.items() if name.endswith(end)), 1.0
        )
        if factor != 1.0:
            wanted = old * old.dtype.type(factor)
        differs = (after[name] != wanted).reshape(len(old), -1).any(axis=1)
        if differs.any():
            row = int(np.flatnonzero(differs)[0])
            return Finding(
                False,
                f"{case.name}: {relation.name}; but {name} differs in"
                f" {int(differs.sum())} rows, the first is {row}",
            )
    return Finding(True)


def _grey_stays_grey(case: Case, ask: Ask) -> Finding:
    color = ask(_changed(case, _grey))["color"]
    same = (color[:, 0] == color[:, 1]) & (color[:, 0] == color[:, 2])
    if same.all():
        return Finding(True)
    row = int(np.flatnonzero(~same)[0])
    text = f"{case.name}: grey light on grey walls is coloured in row {row}"
    return Finding(False, text)


def _dark_is_black(case: Case, ask: Ask) -> Finding:
    color = ask(_changed(case, _dark))["color"]
    if not color.any():
        return Finding(True)
    return Finding(False, f"{case.name}: without light the image is not black")
