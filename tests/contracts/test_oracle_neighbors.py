"""Neighbours as renderers choose them: tables of offsets, and borders that give way."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.levels.declared import declared_row_probes
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import whole_contract

CONTRACT = whole_contract()
FORM = {"schema": "restir-declaration 1"}
TABLES = {
    "passes": ["neighbors"],
    "search": ["table"],
    "border": ["refused", "mirrored"],
}


def clamped(c, n):
    return np.minimum(np.maximum(c, 0), n - 1)


def mirrored(c, n):
    """As RTXDI reflects a position into the view."""
    c = np.where(c < 0, -c, c)
    return np.where(c >= n, 2 * n - c - 1, c)


def alike(given, row, to):
    """Whether pixels are similar."""
    n, z = given["visible_normal"], given["depth"]
    cosine = (n[row] * n[to]).sum(axis=-1)
    near = np.abs(z[row] - z[to]) <= given["max_depth"] * np.maximum(z[row], z[to])
    angle = cosine >= np.cos(np.radians(given["max_angle"]))
    return angle & near & (z[row] > 0) & (z[to] > 0)


@dataclass
class Table:
    """A renderer that looks its offsets up, (N, K) at once.

    Attributes
    ----------
    border : callable; what stands for places along an axis
    turn : callable; what it makes of offsets
    """

    border: object = mirrored
    turn: object = staticmethod(lambda offsets: offsets)
    words: dict = field(default_factory=dict)
    precision: str = "float32"

    def __post_init__(self):
        """Declare the table, and one border."""
        has = TABLES | self.words
        self.declaration = FORM | {"has": has}
        self.asked = set()

    def neighbors(self, width, **given):
        """The pass."""
        asked = given.get("search", "disk"), given.get("border", "refused")
        self.asked.add(asked)
        row = np.arange(len(given["depth"]))[:, None]
        offsets = self.turn(given["offsets"])
        x, y = row % width + offsets[..., 0], row // width + offsets[..., 1]
        height = len(row) // width
        if asked[1] != "refused":
            x, y = self.border(x, width), self.border(y, height)
        inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
        to = np.where(inside, y * width + x, 0)
        found = inside & (to != row) & alike(given, row, to)
        return {"neighbors": np.where(found, to, -1).astype(np.int32)}


def verdict_on(backend):
    return judge(backend, 600, statistics=False)


def named(verdict):
    return {h.name for d in verdict.diagnoses for h in d.matches}


@cache
def probes(precision):
    return declared_row_probes(precision)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_project_itself_is_right(precision):
    for probe in probes(precision):
        case = probe.case
        out = BuiltIn(precision).neighbors(**case.inputs, **case.settings)
        assert examined(CONTRACT, precision, probe, out).finding.passed, case.name


def test_a_renderer_with_a_table_that_mirrors_passes():
    backend = Table()
    verdict = verdict_on(backend)
    assert verdict.status == "PASS", [f for t in verdict.steps for f in t.step.faults]
    assert backend.asked == {("table", "refused"), ("table", "mirrored")}


def test_a_renderer_with_a_table_that_clamps_passes():
    words = {"border": ["clamped"]}
    backend = Table(clamped, words=words)
    assert verdict_on(backend).status == "PASS"
    assert backend.asked == {("table", "clamped")}


@pytest.mark.parametrize(
    ("backend", "name"),
    [
        (Table(clamped), "border-clamped"),
        (Table(lambda c, n: c), "border-refused"),
        (Table(lambda c, n: c % n), "border-wrapped"),
        (Table(turn=lambda o: o[..., ::-1]), "table-columns-and-rows-exchanged"),
        (Table(turn=lambda o: -o), "table-offsets-subtracted"),
        (Table(turn=lambda o: o * [1, -1]), "table-rows-upwards"),
        (
            Table(lambda c, n: mirrored(np.where(c < 0, c + 1, c), n)),
            "border-mirrored-about-edges",
        ),
        (
            Table(
                lambda c, n: np.where(np.abs(c) >= n, 2 * n - 2 - np.abs(c), np.abs(c))
            ),
            "border-mirrored-about-centers",
        ),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_a_mistake_fails_by_its_name(backend, name):
    verdict = verdict_on(backend)
    assert verdict.status == "FAIL"
    assert name in named(verdict)


def test_what_mirrors_where_it_should_clamp_is_named():
    words = {"border": ["clamped"]}
    verdict = verdict_on(Table(mirrored, words=words))
    assert verdict.status == "FAIL"
    assert "border-mirrored" in named(verdict)


def test_who_declares_nothing_is_asked_for_a_disk_that_ends_at_the_border():
    asked = set()

    class Disk:
        precision = "float32"

        def neighbors(self, **given):
            asked.add((given.get("search"), given.get("border"), "offsets" in given))
            return BuiltIn("float32").neighbors(**given)

    assert verdict_on(Disk()).status == "PASS"
    assert asked == {(None, None, False)}


@dataclass
class RootsRoundUp:
    """√u₀ of the largest u₀ is 1, as PyTorch has it; or of all from ``least`` on."""

    least: float = 1 - 2**-24
    precision: str = "float32"

    def neighbors(self, u, **given):
        """The pass."""
        u = u.copy()
        u[..., 0][u[..., 0] >= self.least] = 1
        return BuiltIn("float32").neighbors(u=u, **given)


def test_a_root_may_round_up_to_one():
    """Ends of u are asked on purpose: their decisions are no sign of a wrong rule."""
    assert verdict_on(RootsRoundUp()).status == "PASS"


def test_control_a_root_that_rounds_up_from_further_away_fails():
    assert verdict_on(RootsRoundUp(0.9)).status == "FAIL"


def test_offsets_lead_beyond_every_side_and_to_the_pixel_itself():
    for probe in probes("float32"):
        i, width = probe.case.inputs, probe.case.settings["width"]
        if "offsets" in i:
            x = np.arange(probe.case.rows)[:, None] % width + i["offsets"][..., 0]
            assert (x < 0).sum() > 20
            assert (x >= width).sum() > 20
            assert not i["offsets"].all(axis=-1).all()
