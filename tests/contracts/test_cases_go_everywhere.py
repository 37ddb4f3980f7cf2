"""The cases go everywhere: each clause and each setting of the contract matters."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from restir_gi.extensions.oracle.shifts.cases import PLACES, shift_case
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.contract.surfaces import MATERIAL
from restir_gi.reference.oracle.ladder import scene_probes
from restir_gi.reference.oracle.levels.declared import (
    declared_kernel_probes,
    declared_row_probes,
)
from restir_gi.reference.oracle.levels.given_targets import given_target_probes
from restir_gi.reference.oracle.levels.kernels import kernel_probes
from restir_gi.reference.oracle.levels.rows import row_probes
from restir_gi.reference.oracle.levels.surfaces import (
    surface_kernel_probes,
    surface_row_probes,
    surface_scene_probes,
)
from restir_gi.reference.oracle.levels.weights import weight_row_probes
from restir_gi.reference.oracle.parts import parts, whole_contract
from restir_gi.reference.oracle.prepared_frame import CAPS, SCENES
from tests.contracts.ignored_clauses import (
    PRECISION,
    WAYS,
    AskedCase,
    given,
    right_answers,
    set_to,
)

LEAST = 20
"""Rows that each clause decides."""

AT_EXTREMES = {("jacobian", "0 where points touch")}
"""Clauses about rows that no scene has."""

JUDGED_OTHERWISE = {"kernel-jacobian-extremes"}
"""Of which only what is finite, and what is 0, is asked."""

CONTRACT = whole_contract()
every_pass = pytest.mark.parametrize("name", CONTRACT)
CLAUSES = [
    pytest.param(name, clause, id=f"{name}: {clause}")
    for name, one in CONTRACT.items()
    for clause in one.clauses
]


@cache
def asked_of(name):
    """All cases of the ladder of a pass that are judged row by row."""
    probes = [*kernel_probes(PRECISION), *row_probes(PRECISION)]
    probes += declared_kernel_probes(PRECISION)
    probes += declared_row_probes(PRECISION)
    probes += surface_kernel_probes(PRECISION)
    probes += surface_row_probes(PRECISION)
    probes += surface_scene_probes(PRECISION)
    probes += weight_row_probes(PRECISION)
    probes += given_target_probes(PRECISION)
    for scene in SCENES:
        probes += scene_probes(scene, PRECISION)
    for part in parts():
        probes += [*part.probes(PRECISION), *part.more(PRECISION)]
        if name in {p.name for p in part.passes}:
            probes += part.frames(PRECISION, frozenset({name}))
    chosen = [
        p.case
        for p in probes
        if p.case.pass_name == name
        and p.level != "L1"
        and p.case.name not in JUDGED_OTHERWISE
    ]
    return [AskedCase(case, right_answers(case)) for case in chosen]


def decided(name, clause, asked):
    """Rows within the working range that a backend has wrong that ignores a clause.

    Of several ways to ignore it the one that fewest rows show.
    """
    extreme = (name, clause) in AT_EXTREMES
    return min(
        sum(int((way(one) & (one.case.within | extreme)).sum()) for one in asked)
        for way in WAYS[name][clause]
    )


@every_pass
def test_each_pass_has_clauses_and_each_clause_a_way_to_ignore_it(name):
    assert CONTRACT[name].clauses
    assert set(CONTRACT[name].clauses) == set(WAYS[name])


@every_pass
def test_right_answers_are_right(name):
    """Else ways to ignore a clause would show something else."""
    for one in asked_of(name):
        assert not one.wrong().any()


@pytest.mark.parametrize(("name", "clause"), CLAUSES)
def test_each_clause_decides_rows(name, clause):
    assert decided(name, clause, asked_of(name)) >= LEAST


# Of the designed rows: without them nobody would look.
UNSEEN = [
    ("initial", "W has the density of its row"),
    ("initial", "W = 0 where pdf is 0"),
    ("temporal", "the new sample has the density of its row"),
    ("moved", "an empty past does not count"),
    ("moved", "J is not limited"),
    ("spatial", "J is not limited"),
    ("fused", "J is not limited"),
    ("moved", "the domain asks the albedo of the source"),
]


@pytest.mark.parametrize(("name", "clause"), UNSEEN)
def test_frames_of_scenes_alone_do_not_go_there(name, clause):
    frames = [one for one in asked_of(name) if "rows-" not in one.case.name]
    assert frames
    assert decided(name, clause, frames) < LEAST


# ------------------------------------------------ settings

NOT_NEEDED = {
    # Which buffers there are: who overlooks it is not even called.
    "pack": {"layout"},
    "unpack": {"layout"},
    "shift": {
        # Where tables come from.
        *("scene", "size", "seed", "frame", "bounces"),
        # Of the room that all tables come from; its product with the least distance is
        # what is asked, and that has several values.
        "extent",
    },
    # How far off a solver may stay: one that is exact need not know.
    "poisson_l2": {"residual"},
    "poisson_l1": {"ratio"},
}
TOGETHER = {"reproject": (("width", "height"),)}
"""Settings that are the form of a buffer only together."""


def groups(name):
    """Settings of a pass, alone or with those that go with them."""
    # What may be declared says which buffers there are: nobody takes it for constant.
    left = [s.name for s in CONTRACT[name].settings if not s.default]
    left = [s for s in left if s not in NOT_NEEDED.get(name, ())]
    for group in TOGETHER.get(name, ()):
        yield group
        left = [s for s in left if s not in group]
    yield from ((s,) for s in left)


SETTINGS = [
    pytest.param(name, group, id=f"{name}: {' and '.join(group)}")
    for name in CONTRACT
    for group in groups(name)
]


def overlooked(name, group, value):
    """Rows that a backend has wrong for which settings are the same in every case."""
    fixed, rows = dict(zip(group, value, strict=True)), 0
    for one in asked_of(name):
        if not set(group) <= set(one.case.settings):  # as a table has no radius
            continue
        settings = {**one.case.settings, **fixed}
        if settings == one.case.settings:
            continue
        try:
            wrong = one.wrong(case=replace(one.case, settings=settings))
        except IndexError:  # it reads rows that there are not
            wrong = np.ones(one.case.rows, bool)
        rows += int((wrong & one.case.within).sum())
    return rows


@pytest.mark.parametrize(("name", "group"), SETTINGS)
def test_no_setting_can_be_a_constant(name, group):
    """Whichever of its values it is: some cases have another, and there it matters."""
    values = {
        tuple(one.case.settings[s] for s in group)
        for one in asked_of(name)
        if set(group) <= set(one.case.settings)
    }
    assert len(values) >= 2
    for value in values:
        assert overlooked(name, group, value) >= LEAST, value


def test_control_a_setting_with_one_value_is_seen(monkeypatch):
    """Without the other frames and rows nobody would look at the width."""
    few = [a for a in asked_of("neighbors") if a.case.settings["width"] == 48]
    monkeypatch.setitem(globals(), "asked_of", lambda name: few)
    assert overlooked("neighbors", ("width",), (48,)) == 0


SIZES = {
    "neighbors": lambda case: (case.settings["width"], case.rows),
    **dict.fromkeys(
        ("gbuffer", "reproject"),
        lambda case: (
            case.settings["width"],
            case.settings["width"] * case.settings["height"],
        ),
    ),
    "boiling": lambda case: (case.settings["width"], case.rows),
}


@pytest.mark.parametrize("name", SIZES)
def test_images_are_wide_odd_and_of_one_line(name):
    found = {SIZES[name](one.case) for one in asked_of(name)}
    assert any(width > rows // width for width, rows in found)
    assert any(width % 2 for width, _ in found)
    assert any(width == rows for width, rows in found)


def test_neighbours_are_few_and_as_many_as_masks_have_bits():
    for name, rows in (("spatial", "neighbors"), ("fused", "sources")):
        counts = {one.case.inputs[rows].shape[1] for one in asked_of(name)}
        assert {3, 30} <= counts
    drawn = (one.case.inputs.get("u") for one in asked_of("neighbors"))
    assert max(u.shape[1] for u in drawn if u is not None) > 8


def shown(name, way):
    """Rows within the working range that a way to ignore something has wrong."""
    return sum(int((way(one) & one.case.within).sum()) for one in asked_of(name))


@pytest.mark.parametrize(
    ("name", "bits"),
    [("spatial", 8), ("spatial", 16), ("spatial", 31), ("fused", 8), ("fused", 30)],
)
def test_bits_of_masks_are_looked_at(name, bits):
    """As if there were only the lowest."""
    (way,) = given(visible=lambda i: i["visible"] & np.uint32(2**bits - 1))
    assert shown(name, way) >= LEAST


WHOLE = {"rounded down": np.floor, "to the nearest": np.rint}


# Not in `spatial`: of who stores whole M, and departs in three more choices there, the
# search for sets would not find all four.
@pytest.mark.parametrize("rounding", WHOLE)
@pytest.mark.parametrize("name", ["temporal", "moved"])
def test_confidences_and_caps_are_not_all_whole(name, rounding):
    whole = WHOLE[rounding]
    (way,) = given(past_M=lambda i: whole(i["past_M"]))
    assert shown(name, way) >= LEAST
    (way,) = set_to(cap=lambda case: float(whole(case.settings["cap"])))
    assert shown(name, way) >= LEAST


@pytest.mark.parametrize("share", [0.1, 0.25])
def test_changes_are_shares_of_the_tolerance(share):
    """So that a stricter tolerance would clear other rows."""
    (way,) = set_to(tolerance=lambda case: share * case.settings["tolerance"])
    assert shown("validation", way) >= LEAST


def test_changes_lie_between_two_tolerances():
    """Those that 0.25 allows, and 0.1 does not."""
    one = next(a for a in asked_of("validation") if a.case.name.endswith("-edge"))
    strict = one.wrong(case=replace(one.case, settings={"tolerance": 0.1}))
    assert (strict & one.case.within).sum() >= LEAST


# ------------------------------------------------ what a loop can make


def test_confidences_are_within_the_caps():
    """Those of neighbours within the cap of the pass that they come from."""
    for name in ("temporal", "moved", "spatial", "fused"):
        for one in asked_of(name):
            inputs, cap = one.case.inputs, one.case.settings["cap"]
            assert inputs["past_M"].max() <= cap
            if name in ("spatial", "fused"):
                designed = one.case.name.startswith("rows-")
                assert inputs["M"].max() <= (20 if designed else CAPS["temporal"])


@pytest.mark.parametrize("name", ["temporal", "moved", "spatial", "fused"])
def test_confidences_reach_the_caps_and_fall_to_0(name):
    rows = [one.case for one in asked_of(name) if one.case.name.startswith("rows-")]
    assert rows
    for case in rows:
        M, cap = case.inputs["past_M"], case.settings["cap"]
        for value in (0, 1, cap - 1, cap):
            assert (value == M).sum() >= LEAST * len(M) / 1024


def target_where_stored(name, case):
    """Targets of the past's samples where they were kept, (N,)."""
    inputs = case.inputs
    if case.settings["target"] == "data":
        given = inputs["p_hat_given"]
        if name == "fused":
            found = np.ones(case.rows)
            for k, row in enumerate(inputs["sources"].T):
                there = row >= 0
                found[row[there]] = given[there, 1 + k, 1 + k]
            return found
        return given[:, 1, 1] if name == "moved" else given[:, 0, -1]
    viewer = "" if name == "spatial" else "past_"
    stored = {
        "visible_position": inputs[viewer + "visible_position"],
        "visible_normal": inputs[viewer + "visible_normal"],
        "albedo": inputs[viewer + "albedo"],
        **{n: inputs["past_" + n] for n in ("position", "normal", "radiance")},
        **{f.name: inputs[viewer + f.name] for f in MATERIAL if f.name in inputs},
    }
    words = {n: w for n, w in case.settings.items() if n in ("target", "surface")}
    return BuiltIn(PRECISION).target(**stored, **words)["p_hat"]


@pytest.mark.parametrize("name", ["moved", "spatial", "fused"])
def test_samples_are_valid_where_they_were_stored(name):
    """What has weight had a target there; nulls have a place, most of them."""
    for one in asked_of(name):
        inputs = one.case.inputs
        p_hat = target_where_stored(name, one.case)
        light, within = inputs["past_radiance"].any(axis=1), one.case.within
        if name == "fused":  # rows of the past that such rows read
            read = inputs["sources"][within]
            within = np.isin(np.arange(one.case.rows), read)
        has_weight = (inputs["past_W"] > 0) & light & within
        assert (p_hat[has_weight] > 0).all()
        placed = inputs["past_normal"].any(axis=1)
        assert placed[~light & within].all()


def test_jacobians_go_over_four_decades():
    J = np.concatenate(
        [
            BuiltIn(PRECISION).jacobian(
                x_from=i["past_visible_position"],
                x_to=i["visible_position"],
                position=i["past_position"],
                normal=i["past_normal"],
            )["jacobian"]
            for i in (
                one.case.inputs
                for one in asked_of("moved")
                if one.case.name.startswith("rows-")
            )
        ]
    )
    for below, above in ((0.0, 0.01), (0.01, 0.1), (0.1, 1), (1, 10), (10, 100)):
        assert ((below < J) & (above >= J)).sum() >= LEAST
    assert (J > 100).sum() >= LEAST


# ------------------------------------------------ seeds


def _rows(probes):
    return {p.case.name: p.case for p in probes}


MAKERS = {
    "kernels": kernel_probes,
    "rows": row_probes,
    "kernels of declared settings": declared_kernel_probes,
    "rows of declared settings": declared_row_probes,
    "kernels of surfaces": surface_kernel_probes,
    "rows of surfaces": surface_row_probes,
    **{part.title: part.probes for part in parts()},
    **{f"{part.title}, if declared": part.more for part in parts()},
}
NO_SEED = {"extremes", "worst", "lattice", "null", "even", "alone", "equal"}
"""Words in the names of cases that are designed to the last row."""


@pytest.mark.parametrize("made", MAKERS)
def test_random_rows_depend_on_the_seed(made):
    one, same, other = (_rows(MAKERS[made](PRECISION, seed)) for seed in (1, 1, 2))
    assert set(one) == set(other)
    for name, case in one.items():
        equal = all(
            np.array_equal(array, other[name].inputs[field], equal_nan=True)
            for field, array in case.inputs.items()
        )
        designed = bool(NO_SEED & set(name.split("-")))
        assert equal <= designed, name
        for field, array in case.inputs.items():
            assert array.tobytes() == same[name].inputs[field].tobytes()


def test_frames_depend_on_the_seed():
    one, two = (scene_probes(SCENES[0], PRECISION, seed)[2].case for seed in (1, 2))
    assert one.name == two.name
    assert not np.array_equal(one.inputs["radiance"], two.inputs["radiance"])
    one, two = (shift_case(PLACES[0], PRECISION, seed) for seed in (1, 2))
    assert one.name == two.name
    assert (one.settings["seed"], two.settings["seed"]) == (1, 2)
    assert not np.array_equal(one.inputs["incoming"][:50], two.inputs["incoming"][:50])
