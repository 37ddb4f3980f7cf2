"""Captures of an engine that forgets old samples."""

import numpy as np
import pytest

from restir_gi.reference.oracle.declaration.read import read_declaration
from tests.captures import packed
from tests.captures.engine import Engine
from tests.captures.test_engine import said, verdict_on

OLDEST = 2


class Forgetful(Engine):
    """The past is not reused once its sample has survived two frames."""

    def stored(self, r, frame=0):
        """With the age of the sample."""
        return packed.pack(r, r.get("age", np.uint32(0)))

    def loaded(self, bits):
        """With the age of the sample."""
        return packed.unpack(bits) | {"age": (bits["counts"] >> 8) & 255}

    def arrived(self, r):
        """A frame older."""
        return super().arrived(r) | {"age": r["age"] + 1}

    def limit(self, frame):
        """The age from which on nothing is reused."""
        return OLDEST

    def temporal(self, frame, x, x_before, new, past, row):
        """Without a past that is too old."""
        old = past["age"][np.maximum(row, 0)] >= self.limit(frame)
        return super().temporal(frame, x, x_before, new, past, np.where(old, -1, row))

    def resample(self, x, candidates, decide):
        """The age is that of the sample that was kept."""
        found = super().resample(x, candidates, decide)
        age = candidates[0][1]["age"].copy()
        for _, r, there in candidates[1:]:
            same = there & (r["position"] == found["position"]).all(axis=1)
            age = np.where(same, r["age"], age)
        return found | {"age": age.astype(np.uint32)}


class Drawn(Forgetful):
    """Each pixel draws the age, 1 to 3, in each frame."""

    def limit(self, frame):
        """The ages of all pixels."""
        return np.random.default_rng(frame).integers(1, 4, self.size**2)


def declared(age, accept=()):
    choices = {
        "generator": "own",
        "order": "own-first",
        "cap": "on arrival",
        "mis": "balance",
        "mis_jacobian": False,
        "visibility": "shading",
    }
    if age is not None:
        choices["max_age"] = age
    form = {"schema": "restir-declaration 1", "accept": list(accept)}
    return read_declaration(form | {"choices": choices})


def verdict(folder, declaration, engine=Forgetful):
    return verdict_on(engine(32), folder, 5, declaration)


def test_what_is_accepted_passes_and_is_called_biased(tmp_path):
    found = verdict(tmp_path, declared(OLDEST, ["forgotten-at-age"]))
    assert found.status == "PASS", said(found)
    (bias,) = found.biases
    assert bias.names == (f"forgotten-at-age-{OLDEST}",)
    assert bias.size is None


def test_what_is_not_accepted_is_told(tmp_path):
    found = verdict(tmp_path, declared(OLDEST))
    assert found.unaccepted == [f"forgotten-at-age-{OLDEST}"]


@pytest.mark.parametrize("age", [None, OLDEST + 1])
def test_control_another_age_fails(tmp_path, age):
    found = verdict(
        tmp_path, declared(age, [] if age is None else ["forgotten-at-age"])
    )
    assert found.status == "FAIL"


def test_a_limit_may_be_drawn_at_random(tmp_path):
    found = verdict(tmp_path, declared([1, 3], ["forgotten-at-age"]), Drawn)
    assert found.status == "PASS", said(found)
    assert [bias.names for bias in found.biases] == [("forgotten-at-age-1-3",)]


@pytest.mark.slow
@pytest.mark.parametrize("ages", [[2, 3], [1, 2], 2])
def test_control_limits_that_are_not_drawn_fail(tmp_path, ages):
    found = verdict(tmp_path, declared(ages, ["forgotten-at-age"]), Drawn)
    assert found.status == "FAIL"
