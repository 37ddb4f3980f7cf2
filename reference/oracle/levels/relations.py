"""L2: relations between two calls that hold to the last bit, in any arithmetic.

A power of two as a factor changes no digit of a product, a quotient or a sum, in
whatever order they are taken, as long as nothing overflows.  So absolute epsilons,
clamps and caps, which have a scale of their own, cannot hide.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.levels.probe import Finding
from restir_gi.reference.oracle.loop import Ask

Change = Callable[[dict[str, NDArray[Any]]], dict[str, NDArray[Any]]]

SCALE, LENGTH = 2.0**9, 2.0**5
MIRROR = (-1.0, 1.0, 1.0)


@dataclass(frozen=True, slots=True)
class Relation:
    """What a change of the inputs does to the outputs.

    Attributes
    ----------
    passes : tuple of str; where it holds
    change : callable; from inputs to inputs
    factors : mapping of str to float or tuple of float
        By which outputs change, or their components; 1 where they are not named.
    settings : mapping of str to float; by which settings change
    """

    name: str
    passes: tuple[str, ...]
    change: Change
    factors: Mapping[str, float | tuple[float, ...]]
    settings: Mapping[str, float] = field(default_factory=dict)


def _scaled(
    names: tuple[str, ...], factor: float | tuple[float, ...], over: str = ""
) -> Change:
    """Inputs times a factor; those that end in `over` are divided by it."""

    def change(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        found = dict(inputs)
        for name, array in inputs.items():
            if name.endswith(names):
                found[name] = array * np.array(factor, array.dtype)
            elif over and name.endswith(over):
                found[name] = array / np.array(factor, array.dtype)
        return found

    return change


def _grey(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {
        name: np.repeat(array[:, :1], 3, axis=1)
        if name.endswith(("radiance", "albedo"))
        else array
        for name, array in inputs.items()
    }


def _turned_colors(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {
        name: array[:, [1, 2, 0]] if name.endswith(("radiance", "albedo")) else array
        for name, array in inputs.items()
    }


def _dark(inputs: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {
        name: array * 0 if name.endswith(("radiance", "p_hat_given")) else array
        for name, array in inputs.items()
    }


REUSE = ("temporal", "moved", "spatial", "fused")

RELATIONS = (
    Relation(
        "light times 2^9: the image too, and the same choices and W",
        ("initial", *REUSE, "shade"),
        _scaled(("radiance", "p_hat_given"), SCALE),
        {"radiance": SCALE, "color": SCALE, "p_hat": SCALE},
    ),
    Relation(
        "lengths times 2^5: nothing changes",
        ("target", "jacobian", "initial", *REUSE, "shade"),
        _scaled(("position", "x_from", "x_to"), LENGTH),
        {"position": LENGTH},
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
        _scaled(("albedo",), 2.0**-3),
        {"color": 2.0**-3},
    ),
    Relation(
        "in a mirror: the same choices and W",
        ("target", "jacobian", "initial", *REUSE, "shade"),
        _scaled(("position", "normal", "x_from", "x_to"), MIRROR),
        {"position": MIRROR, "normal": MIRROR},
    ),
    Relation(
        "W times 2^5 and densities over 2^5: the same choices, W times 2^5",
        REUSE,
        _scaled(("W",), LENGTH, over="pdf"),
        {"W": LENGTH},
    ),
    Relation(
        "confidences times 2: the same choices and W",
        ("spatial", "fused"),
        _scaled(("M",), 2.0),
        {"M": 2.0},
        {"cap": 2.0},
    ),
)


Test = Callable[[Ask], Finding]


def relations_of(case: Case) -> list[Test]:
    """What can be asked of a case and its changes.

    Each asks a backend, and cannot fail a right one: no tolerance is wanted.
    """
    tests: list[Test] = [
        partial(_holds, relation, case)
        for relation in RELATIONS
        if case.pass_name in relation.passes
    ]
    if case.pass_name == "shade":
        tests += [partial(_grey_stays_grey, case), partial(_dark_is_black, case)]
        tests.append(partial(_channels_change_places, case))
    if case.pass_name in ("initial", *REUSE):
        tests.append(partial(_nulls_count, case))
    return tests


def _holds(relation: Relation, case: Case, ask: Ask) -> Finding:
    changed = _changed(case, relation.change)
    settings = {
        name: float(value) * relation.settings[name]
        if name in relation.settings
        else value
        for name, value in case.settings.items()
    }
    before, after = ask(case), ask(replace(changed, settings=settings))
    return _compared(case, relation, before, after)


def _changed(case: Case, change: Change) -> Case:
    return replace(case, inputs=change(dict(case.inputs)))


def _compared(
    case: Case, relation: Relation, before: Buffers, after: Buffers
) -> Finding:
    for name, old in before.items():
        ends = [f for end, f in relation.factors.items() if name.endswith(end)]
        wanted = old * np.array(ends[0], old.dtype) if ends else old
        differs = (after[name] != wanted).reshape(len(old), -1).any(axis=1)
        differs &= case.within
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
    differs = np.flatnonzero(~same & case.within)
    if not differs.size:
        return Finding(True)
    row = int(differs[0])
    text = f"{case.name}: grey light on grey walls is coloured in row {row}"
    return Finding(False, text)


def _channels_change_places(case: Case, ask: Ask) -> Finding:
    before, after = ask(case)["color"], ask(_changed(case, _turned_colors))["color"]
    differs = (after != before[:, [1, 2, 0]]).any(axis=1) & case.within
    if not differs.any():
        return Finding(True)
    row = int(np.flatnonzero(differs)[0])
    text = f"{case.name}: what happens to a channel hangs on the others in row {row}"
    return Finding(False, text)


def _nulls_count(case: Case, ask: Ask) -> Finding:
    """Without light M is what it was: it looks at no sample, and nobody at W."""
    before, after = ask(case), ask(_changed(case, _dark))
    differs = np.flatnonzero((before["M"] != after["M"]) & case.within)
    if not differs.size:
        return Finding(True)
    row = int(differs[0])
    found, wanted = after["M"][row], before["M"][row]
    text = f"{case.name}: without light M is {found:g} instead of {wanted:g}"
    return Finding(False, f"{text} in {len(differs)} rows, the first is {row}")


def _dark_is_black(case: Case, ask: Ask) -> Finding:
    color = ask(_changed(case, _dark))["color"]
    if not color[case.within].any():
        return Finding(True)
    return Finding(False, f"{case.name}: without light the image is not black")
