"""Visibility that is traced in the scene of a capture."""

import numpy as np
import pytest

from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.capture.visibility import PlacedPoints, traced
from restir_gi.reference.oracle.frames import frame_cases
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.system.errors import UsageError

SIZE = 32


@pytest.fixture(scope="module")
def frame():
    """A frame of a room, and what its spatial pass is given."""
    at = prepare_frame(find_scene("many-lights"), SIZE, 3)
    case = next(c for c in frame_cases(at, "float64") if c.pass_name == "spatial")
    return at, case.inputs


def placed(inputs, prefix, rows=slice(None)):
    """Points among buffers."""
    position, normal = (inputs[f"{prefix}{n}"][rows] for n in ("position", "normal"))
    return PlacedPoints(position, normal)


def test_bits_are_those_of_the_path_tracer_where_they_are_sure(frame):
    at, inputs = frame
    near = np.maximum(inputs["neighbors"][:, 0], 0)
    there = (inputs["neighbors"][:, 0] >= 0) & inputs["visible_normal"].any(axis=1)
    viewers = [placed(inputs, "visible_"), placed(inputs, "visible_", near)]
    samples = [placed(inputs, ""), placed(inputs, "", near)]
    words, sure = traced(at.world, viewers, samples)
    # The pixel and its first neighbour, its own sample and that neighbour's.
    lit = inputs["radiance"].any(axis=1) & inputs["radiance"][near].any(axis=1)
    asked = sure & there & lit
    known = inputs["visible"][:, :2] & 3
    # Of column 0 the bit of the own sample is not looked at.
    assert ((words[asked, 0] ^ known[asked, 0]) & 2 == 0).all()
    assert ((words[asked, 1] ^ known[asked, 1]) & 3 == 0).all()
    assert asked.sum() > 100
    assert sure.mean() > 0.8
    # Some see, and some do not: else nothing was compared.
    hidden = (known[asked, 0] & 2 == 0).sum()
    assert 3 < hidden < asked.sum() - 3


def test_another_scene_is_refused(frame):
    at, inputs = frame
    moved = PlacedPoints(inputs["visible_position"] + 0.3, inputs["visible_normal"])
    with pytest.raises(UsageError, match="lie on no surface of the scene"):
        traced(at.world, [moved], [placed(inputs, "")])


def test_an_edge_is_not_sure(frame):
    # A segment that ends on the rim of what hides it: moved ends say yes and no.
    at, inputs = frame
    x = placed(inputs, "visible_")
    seen = np.flatnonzero(inputs["visible_normal"].any(axis=1))
    one = PlacedPoints(
        *(np.repeat(a[seen[:1]], 2000, 0) for a in (x.position, x.normal))
    )
    rng = np.random.default_rng(2)
    everywhere = take(at.last.visible.surface, rng.choice(seen, 2000))
    y = PlacedPoints(everywhere.position, everywhere.normal)
    words, sure = traced(at.world, [one], [y])
    assert 0 < (~sure).sum() < 1000
    assert set(np.unique(words)) == {0, 1}
