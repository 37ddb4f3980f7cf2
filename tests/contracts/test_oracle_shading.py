"""Shading that asks what the visible point sees: a declared setting."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.capture.cases import RecordedFrames, captured_cases
from restir_gi.reference.oracle.capture.frames import CapturedBuffers, CapturedFrame
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.levels.declared import declared_kernel_probes
from restir_gi.reference.oracle.levels.surfaces import surface_kernel_probes
from restir_gi.reference.oracle.prepared_frame import prepare_frame
from restir_gi.reference.oracle.replay.judges import JUDGES
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.scene.catalogue.registry import find_scene

FORM = {"schema": "restir-declaration 1"}
HAS = {"passes": ["shade"], "shade": {"visibility": ["none", "asked"]}}


@dataclass
class Shading:
    """A renderer of one pass, and what it makes of the bits.

    Attributes
    ----------
    has : mapping; its declaration
    heeds : callable; from bits to those that it shades by
    """

    has: dict = field(default_factory=lambda: HAS)
    heeds: object = staticmethod(lambda visible: visible)
    precision: str = "float32"

    def __post_init__(self):
        """Declare what it has, and remember what it is asked."""
        self.declaration = FORM | {"has": self.has}
        self.asked = []

    def shade(self, **given):
        """Color of the built-in pass."""
        self.asked.append(given.get("visibility", "none"))
        if "visible" in given:
            given["visible"] = self.heeds(given["visible"])
        return BuiltIn(self.precision).shade(**given)


def verdict_on(backend):
    return judge(backend, 600, statistics=False)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_who_declares_it_is_asked_and_passes(precision):
    backend = Shading(precision=precision)
    verdict = verdict_on(backend)
    assert verdict.status == "PASS"
    assert {"none", "asked"} == set(backend.asked)
    assert "declared settings" in [t.step.title for t in verdict.steps]


def test_who_declares_nothing_is_not_asked():
    backend = Shading(has={"passes": ["shade"]})
    assert verdict_on(backend).status == "PASS"
    assert set(backend.asked) == {"none"}


def test_shading_that_always_asks_has_no_other_value():
    backend = Shading(has={"passes": ["shade"], "shade": {"visibility": ["asked"]}})
    assert verdict_on(backend).status == "PASS"
    assert set(backend.asked) == {"asked"}


@pytest.mark.parametrize(
    ("heeds", "name"),
    [
        (np.ones_like, "shade-visibility-ignored"),
        (lambda visible: 1 - visible, "shade-visibility-turned"),
    ],
)
def test_what_does_not_heed_it_fails_by_its_name(heeds, name):
    verdict = verdict_on(Shading(heeds=heeds))
    assert verdict.status == "FAIL"
    assert name in {h.name for d in verdict.diagnoses for h in d.matches}


def test_surfaces_are_asked_with_it():
    both = [
        p
        for p in surface_kernel_probes("float32")
        if p.case.settings.get("visibility") == "asked"
    ]
    assert {p.case.settings["surface"] for p in both} == {"ggx", "coated"}
    for probe in (*both, *declared_kernel_probes("float32")):
        hidden = probe.case.inputs["visible"] == 0
        color = BuiltIn("float32").shade(**probe.case.inputs, **probe.case.settings)
        assert not color["color"][hidden].any()
        assert color["color"][~hidden].any()


# ---------------------------------------------------------------- captures


@pytest.fixture(scope="module")
def room():
    """A frame of a room in which each pixel holds the sample of another, N rows."""
    at = prepare_frame(find_scene("many-lights"), 24, 3)
    surface, y = at.last.visible.surface, at.last.temporal.y
    other = np.roll(np.arange(len(y.position)), 7)
    inputs = {
        "visible_position": surface.position,
        "visible_normal": surface.normal,
        "albedo": surface.color,
        "position": y.position[other],
        "normal": y.normal[other],
        "radiance": y.radiance[other],
        "W": np.ones(len(other)),
    }
    return at.world, {n: a.astype(np.float32) for n, a in inputs.items()}


def recorded(room, visible=None, bits=None, **about):
    """A frame whose shading knew what was seen, and what a capture says of it."""
    _, inputs = room
    words = {"visibility": "asked"} if visible is not None else {}
    more = {"visible": visible} if visible is not None else {}
    color = BuiltIn("float32").shade(**inputs, **more, **words)
    roles = dict.fromkeys(("gbuffer", "initial"), CapturedBuffers(inputs))
    roles["shade"] = CapturedBuffers(color)
    if bits is not None:
        roles["visible_shade"] = CapturedBuffers({"visible": bits})
    frame = CapturedFrame(0, roles)
    (one,) = captured_cases(RecordedFrames(24, (frame,), {"shade": {}}, **about))
    judged = JUDGES["shade"](one.case, one.outputs, CONTRACT_RULES, "float32")
    return one.case, (judged.wrong & one.case.within).sum()


def traced(room):
    """What the pixels of the room see, as an engine finds it."""
    case, _ = recorded(room, world=room[0], shading_sees=True)
    return case.inputs["visible"]


def test_dumped_bits_are_what_the_shading_asks(room):
    bits = (np.arange(24 * 24) % 3 > 0).astype(np.uint32)
    case, wrong = recorded(room, bits, bits)
    assert case.settings == {"visibility": "asked"}
    assert wrong == 0
    _, wrong = recorded(room, np.ones_like(bits), bits)
    assert wrong > 20


def test_what_is_declared_is_traced_in_the_scene(room):
    seen = traced(room)
    assert 20 < (seen == 0).sum() < len(seen) - 20
    _, wrong = recorded(room, seen, world=room[0], shading_sees=True)
    assert wrong == 0
    _, wrong = recorded(room, world=room[0], shading_sees=True)
    assert wrong > 20


def test_what_is_not_declared_is_not_asked(room):
    """A sample that was seen when it was kept, and is hidden now, shines on."""
    case, wrong = recorded(room, world=room[0])
    assert "visible" not in case.inputs
    assert wrong == 0


@pytest.mark.parametrize(
    ("table", "sees"),
    [
        ({}, False),
        ({"choices": {"visibility": "shading"}}, True),
        ({"has": HAS}, True),
        ({"has": {"shade": {"visibility": ["none"]}}}, False),
    ],
)
def test_the_declaration_says_where_visibility_is_tested(table, sees):
    assert read_declaration(FORM | table).shading_sees == sees
