"""Captures of an engine with a boiling filter."""

import re
import tomllib

import numpy as np
import pytest

from restir_gi.reference.oracle.declaration.read import read_declaration
from tests.captures.dump import DECLARATION
from tests.captures.engine import Engine
from tests.captures.mistakes import JacobianLeftOut
from tests.captures.packed import F
from tests.captures.test_engine import said, verdict_on

TILE, STRENGTH = 16, F(0.5)


class Boiling(Engine):
    """Temporal reservoirs that outshine their tile are emptied."""

    def temporal(self, frame, x, x_before, new, past, row):
        """Filtered."""
        found = super().temporal(frame, x, x_before, new, past, row)
        light = (found["radiance"] @ np.array([0.2126, 0.7152, 0.0722], F)) * found["W"]
        y, column = np.divmod(self.rows, self.size)
        tile = y // TILE * self.size + column // TILE
        lit = light > 0
        total = np.bincount(tile, light, tile.max() + 1)
        count = np.bincount(tile[lit], minlength=tile.max() + 1)
        mean = (total / np.maximum(count, 1))[tile]
        boils = light * STRENGTH > mean * (10 - 9 * STRENGTH)
        empty = {n: np.where(boils, F(0), found[n]).astype(F) for n in ("W", "M")}
        return found | empty


def verdict(engine, folder, **more):
    """What is said of four frames, with more in the declaration."""
    form = tomllib.loads(DECLARATION)
    choices = form["choices"] | more.pop("choices", {})
    return verdict_on(
        engine, folder, declaration=read_declaration(form | more | {"choices": choices})
    )


def test_what_is_declared_and_accepted_passes_and_is_told(tmp_path):
    found = verdict(
        Boiling(48), tmp_path, choices={"boiling": True}, accept=["boiling-filter"]
    )
    assert found.status == "PASS", said(found)
    (bias,) = found.biases
    assert bias.names == ("boiling-filter",)
    (count,) = re.findall(r"; emptied are ([0-9,]+) of [0-9,]+ reservoirs", bias.text)
    assert int(count.replace(",", "")) > 0
    # Nothing is left to ask for.
    assert not any(timed.step.more for timed in found.steps)


@pytest.mark.slow
def test_what_is_not_accepted_fails_for_that_alone(tmp_path):
    found = verdict(Boiling(32), tmp_path, choices={"boiling": True})
    assert found.status == "FAIL"
    assert not found.wrong
    assert found.unaccepted == ["boiling-filter"]


@pytest.mark.parametrize(
    "engine", [Boiling, type("Both", (JacobianLeftOut, Boiling), {})]
)
def test_control_what_is_not_declared_or_wrong_besides_fails(tmp_path, engine):
    more = {} if engine is Boiling else {"choices": {"boiling": True}}
    found = verdict(engine(32), tmp_path, **more, accept=[])
    assert found.status == "FAIL"
    assert found.wrong
