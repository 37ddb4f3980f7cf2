"""The figure of exactness: within its bound in every type, which can be broken."""

import numpy as np
import pytest

from restir_gi.figures import extremes
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work

PLAN = Work(16, 4, Schedule())


def rows():
    return {row["type"]: row for row in extremes.extremes(PLAN).rows}


def test_the_kernel_keeps_its_bound_in_every_type():
    found = rows()
    assert list(found) == ["float16", "float32", "float64"]
    for row in found.values():
        assert row["largest error, eps"] > 0
        assert 0.01 < row["largest share of the bound"] <= 1


@pytest.mark.parametrize("slightly", [True, False])
def test_control_a_kernel_that_is_wrong_breaks_the_bound(monkeypatch, slightly):
    """J with a relative error of 100 eps; or another measure altogether."""
    right = extremes.reconnection_jacobian

    def wrong(x_from, x_to, position, normal):
        J = right(x_from, x_to, position, normal)
        return J * (1 + 100 * np.finfo(J.dtype).eps) if slightly else np.sqrt(J)

    monkeypatch.setattr(extremes, "reconnection_jacobian", wrong)
    assert all(row["largest share of the bound"] > 1 for row in rows().values())


def test_places_are_rounded_far_from_the_origin():
    """Points a metre apart, rounded by eps 2^k / 2 in each component.

    The logarithm of J takes up some ten times as much: three for each distance, one for
    each cosine of 0.3 or more, in three components.
    """
    for row in rows().values():
        if row["type"] == "float16":
            continue
        eps = float(np.finfo(row["type"]).eps)
        near, far = row["relative error by places at 2^10 m"], row["at 2^20 m"]
        for power, error in ((10, near), (20, far)):
            assert 0.1 * eps * 2.0**power < error < 10 * eps * 2.0**power
    assert rows()["float16"]["at 2^20 m"] == 1.0
