"""Passes of the hash grid: who is right passes, in whatever order; others do not."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from restir_gi.hashgrid.grid import (
    BUCKET,
    Keys,
    Lattice,
    build_grid,
    jittered,
    keys_of,
    lattice_of,
)
from restir_gi.hashgrid.oracle.part import PART
from restir_gi.hashgrid.oracle.rules import CONTRACT_GRID
from restir_gi.reference.numerics.records import take
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import judge_of, parts
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.scene.camera import Camera
from tests.mutants.hash_grid_by_hand import HashGridByHand

PASSES = {p.name: p for p in PART.passes}
both_precisions = pytest.mark.parametrize("precision", ["float32", "float64"])
every_pass = pytest.mark.parametrize("name", PASSES)


@cache
def probes(precision, seed=1):
    return PART.probes(precision, seed)


def found_in(precision, backend, name, seed=1):
    """What is wrong with each answer; empty where nothing is."""
    texts = []
    for probe in probes(precision, seed):
        case = probe.case
        if case.pass_name == name:
            out = backend(name, **case.inputs, **case.settings)
            texts.append(examined(PASSES, precision, probe, out).finding.text)
    assert texts
    return texts


def built_in(precision):
    return lambda name, **given: getattr(BuiltIn(precision), name)(**given)


def case_of(name):
    """A case by the end of its name, in single precision."""
    return next(p.case for p in probes("float32") if p.case.name == f"grid-{name}")


def judged(case, outputs, rules=CONTRACT_RULES):
    return judge_of(case.pass_name)(case, outputs, rules, "float32")


def test_the_part_is_registered():
    assert PART in parts()


@both_precisions
@every_pass
@pytest.mark.parametrize("seed", [1, 2])
def test_the_project_itself_passes(precision, name, seed):
    assert not any(found_in(precision, built_in(precision), name, seed))


@both_precisions
@every_pass
@pytest.mark.parametrize("seed", [1, 3])
def test_another_backend_passes(precision, name, seed):
    """Another order of atomics, another frame: written from the contract."""
    assert not any(found_in(precision, HashGridByHand(precision), name, seed))


def test_every_known_mistake_changes_the_rules():
    """Each is another rule of its pass, and no two are alike."""
    rules = [(h.passes, repr(h.rules.part)) for h in PART.hypotheses]
    assert all(h.rules.part != CONTRACT_GRID for h in PART.hypotheses)
    assert len(set(rules)) == len(rules)


# ------------------------------------------------ equivalents: right, and not ours


def in_turn(case, turn):
    """A backend whose threads come in another order: rows of vertices are permuted."""
    inputs = {n: a[turn] for n, a in case.inputs.items()}
    slot = np.empty(case.rows, np.int32)
    slot[turn] = BuiltIn("float32").cell_insert(**inputs, **case.settings)["slot"]
    return {"slot": slot}


@pytest.mark.parametrize("order", range(6))
def test_any_order_of_insertion_is_right(order):
    """Where buckets are too full, who is lost is a matter of luck."""
    turn = np.random.default_rng(order)
    slots = set()
    for probe in probes("float32"):
        if probe.case.pass_name == "cell_insert":
            out = in_turn(probe.case, turn.permutation(probe.case.rows))
            assert judged(probe.case, out).passed
            slots.add(out["slot"].tobytes())
    assert len(slots) > 1


@pytest.mark.parametrize("order", range(3))
def test_any_order_of_counting_is_right(order):
    turn = np.random.default_rng(order)
    case = case_of("count")
    out = BuiltIn("float32").cell_count(**case.inputs)
    slot, place = case.inputs["slot"], out["place"].copy()
    for cell in np.unique(slot[slot >= 0]):
        place[slot == cell] = turn.permutation(place[slot == cell])
    assert (place != out["place"]).any()
    assert judged(case, out | {"place": place}).passed


def hashed_walk(case, seed):
    """A walk whose beginning is a hash of u: random, and on no grid."""
    i, most, rng = case.inputs, case.settings["most"], np.random.default_rng(seed)
    found = np.full((case.rows, 8), -1, np.int32)
    for q in np.flatnonzero(i["slot"] >= 0):
        n, first = i["counter"][i["slot"][q]], i["start"][i["slot"][q]]
        some = rng.permutation(n)[:most]
        found[q, : len(some)] = i["storage"][first + some]
    return {"vertex": found}


@pytest.mark.parametrize("most", [1, 3, 4, 8])
def test_any_even_walk_is_right(most):
    for seed in range(20):
        case = case_of(f"visit-{most}")
        assert judged(case, hashed_walk(case, seed)).passed


def test_the_beginning_may_be_rounded_otherwise():
    """Of a walk that begins at n u rounded down in half precision."""
    case = case_of("visit-4")
    u = case.inputs["u"].astype(np.float16).astype(np.float32)
    inputs = {**case.inputs, "u": np.minimum(u, np.float32(1 - 2.0**-11))}
    out = BuiltIn("float32").cell_visit(**inputs, **case.settings)
    assert judged(case, out).passed


def test_either_level_is_right_at_a_power_of_two_and_no_third():
    case = case_of("level-equal")
    level = BuiltIn("float32").cell_level(**case.inputs, **case.settings)["level"]
    # The first of five rows stands at the border itself.
    border = (np.arange(case.rows) % 5 == 0) & (np.arange(case.rows) < 120)
    other = np.where(border & (level > 0), level - 1, level).astype(np.int32)
    below = judged(case, {"level": other})
    above = judged(case, {"level": np.where(border, level + 1, level)})
    assert not (below.wrong & above.wrong).any()
    third = np.where(border, level + 2, level)
    assert judged(case, {"level": third}).wrong[border].all()


def test_another_frame_about_each_normal_is_right():
    """Turned by any angle that hangs on the normal alone; of either hand."""
    case = case_of("jitter")
    moved = BuiltIn("float64").cell_jitter(
        **{
            n: a.astype(float) if a.dtype.kind == "f" else a
            for n, a in case.inputs.items()
        }
    )["moved"]
    position, n = (case.inputs[k].astype(float) for k in ("position", "normal"))
    angle = 40 * n[:, :1] + n[:, 1:2]
    d = moved - position
    turned = np.cos(angle) * d + np.sin(angle) * np.cross(n, d)
    e = np.cross(n, np.where(abs(n[:, :1]) < 0.9, [1, 0, 0], [0, 1, 0]))
    e /= np.linalg.norm(e, axis=1)[:, None]
    mirrored = 2 * (d * e).sum(axis=1)[:, None] * e - d
    for aside in (turned, mirrored):
        out = {"moved": (position + aside).astype(np.float32)}
        assert judged(case, out).passed
    # Another angle in every row is not: it is no frame of the normal.
    each = np.arange(case.rows)[:, None] * 1.0
    loose = np.cos(each) * d + np.sin(each) * np.cross(n, d)
    out = {"moved": (position + loose).astype(np.float32)}
    assert not judged(case, out).passed


def test_a_search_may_go_on_behind_a_free_slot():
    """Whether it ends there or not: nothing stands behind one."""
    case = case_of("find-40")
    table = case.inputs["table"][:640].reshape(40, 16).astype(np.int64)
    bucket = case.inputs["bucket_hash"].astype(np.int64) % 40
    alike = table[bucket] == case.inputs["checksum"][:, None]
    slot = np.where(alike.any(axis=1), bucket * 16 + alike.argmax(axis=1), -1)
    assert judged(case, {"slot": slot.astype(np.int32)}).passed


def test_what_lies_beyond_the_list_is_not_looked_at():
    case = case_of("scatter")
    out = BuiltIn("float32").cell_scatter(**case.inputs)["storage"].copy()
    stored = (case.inputs["slot"] >= 0).sum()
    out[stored:] = np.arange(case.rows - stored) * 7 - 3
    assert judged(case, {"storage": out}).passed
    out[stored - 1] += 1
    assert not judged(case, {"storage": out}).passed


# ------------------------------------------------ controls: small faults are seen


def one_row(values, change, where=True):
    """The same, but for the first row in which it may be another."""
    out = np.array(values)
    row = np.flatnonzero(np.broadcast_to(where, len(out)))[0]
    out[row] = change(out[row])
    return out


def some(name):
    """First case of a pass that is random, and what is right."""
    case = next(p.case for p in probes("float32") if p.case.pass_name == name)
    return case, getattr(BuiltIn("float32"), name)(**case.inputs, **case.settings)


FAULTS = {
    "cell_base": [("base", lambda v: v * 1.0001, None)],
    "cell_level": [("level", lambda v: v + 1, None)],
    "cell_jitter": [("moved", lambda v: v * 1.01, None)],
    "cell_key": [(n, lambda v: v + 1, None) for n in ("x", "y", "z", "facing")],
    "cell_hash": [(n, lambda v: v ^ 1, None) for n in ("bucket_hash", "checksum")],
    "cell_insert": [
        ("slot", lambda v: v + 1, lambda out: out["slot"] >= 0),
        ("slot", lambda v: v + 16, lambda out: out["slot"] >= 0),
        ("slot", lambda v: -1, lambda out: out["slot"] >= 0),
        ("slot", lambda v: 0, lambda out: out["slot"] < 0),
        ("slot", lambda v: 10**9, lambda out: out["slot"] >= 0),
    ],
    "cell_count": [
        ("counter", lambda v: v + 1, None),
        ("place", lambda v: v + 1, lambda out: out["place"] >= 0),
        ("place", lambda v: 0, lambda out: out["place"] > 0),
        ("place", lambda v: 0, lambda out: out["place"] < 0),
    ],
    "cell_scan": [("start", lambda v: v + 1, None)],
    "cell_scatter": [("storage", lambda v: v + 1, None)],
    "cell_find": [
        ("slot", lambda v: v + 1, lambda out: out["slot"] >= 0),
        ("slot", lambda v: -1, lambda out: out["slot"] >= 0),
        ("slot", lambda v: 0, lambda out: out["slot"] < 0),
    ],
    "cell_visit": [
        ("vertex", lambda v: v[::-1], lambda out: out["vertex"][:, 0] >= 0),
        ("vertex", lambda v: v * 0 + 10**9, lambda out: out["vertex"][:, 0] >= 0),
        ("vertex", lambda v: v * 0 - 7, lambda out: out["vertex"][:, 0] >= 0),
    ],
    "cell_similar": [("similar", lambda v: 1 - v, None)],
    "light_target": [
        ("value", lambda v: v * 1.0001, lambda out: out["value"].any(axis=1)),
        ("value", lambda v: v + 1e-3, lambda out: ~out["value"].any(axis=1)),
    ],
    "light_candidates": [
        ("slot", lambda v: -7, lambda out: out["W"] > 0),
        ("W", lambda v: v * 1.001, lambda out: out["W"] > 0),
        ("W", lambda v: 1.0, lambda out: out["W"] == 0),
        ("M", lambda v: v + 1, None),
    ],
    "light_reuse": [
        ("slot", lambda v: -7, lambda out: out["W"] > 0),
        ("W", lambda v: v * 1.001, lambda out: out["W"] > 0),
        ("M", lambda v: v + 1, None),
    ],
    "bounce_reservoir": [
        ("longer", lambda v: 7, lambda out: out["W"] > 0),
        ("value", lambda v: v * 1.001, lambda out: out["W"] > 0),
        ("W", lambda v: v * 1.001, lambda out: out["W"] > 0),
        ("M", lambda v: 0, None),
    ],
    "path_cache": [
        ("stored", lambda v: 1 - v, None),
        ("W", lambda v: v + 1, lambda out: out["stored"] == 1),
        ("M", lambda v: v + 1, lambda out: out["stored"] == 1),
    ],
    "suffix_reach": [
        ("value", lambda v: v * 1.001, lambda out: out["jacobian"] > 0),
        ("jacobian", lambda v: v * 1.001, lambda out: out["jacobian"] > 0),
        ("jacobian", lambda v: 1.0, lambda out: out["jacobian"] == 0),
    ],
}
EACH_FAULT = [
    pytest.param(name, *fault, id=f"{name} {fault[0]} {k}")
    for name, faults in FAULTS.items()
    for k, fault in enumerate(faults)
]


def test_every_output_has_a_fault():
    for name, one in PASSES.items():
        assert {f.name for f in one.outputs} == {fault[0] for fault in FAULTS[name]} | (
            {"p_hat"} if name == "light_reuse" else set()
        )


@pytest.mark.parametrize(("name", "output", "change", "where"), EACH_FAULT)
def test_control_a_fault_in_one_row_is_seen(name, output, change, where):
    case, out = some(name)
    if where is not None and not np.any(where(out)):  # no bucket of that case is full
        case = case_of("insert-7")
        out = BuiltIn("float32").cell_insert(**case.inputs, **case.settings)
    changed = one_row(out[output], change, True if where is None else where(out))
    assert judged(case, out).passed
    assert not judged(case, out | {output: changed}).passed


def garbage(array, rng):
    """Numbers of the same type that no pass gives, in every row."""
    if array.dtype.kind == "f":
        return rng.choice(np.float32([-1e30, -1, 0, 1e-38, 1e30]), array.shape)
    ends = np.iinfo(array.dtype)
    some = rng.choice([ends.min, ends.max, ends.max - 1, 1, 17], array.shape)
    return some.astype(array.dtype)


@every_pass
def test_control_garbage_is_wrong_and_no_error(name):
    """Under every rule: a diagnosis asks them all of whatever a backend gives."""
    rng = np.random.default_rng(3)
    for probe in probes("float32"):
        case = probe.case
        if case.pass_name != name:
            continue
        right = getattr(BuiltIn("float32"), name)(**case.inputs, **case.settings)
        out = {n: garbage(array, rng) for n, array in right.items()}
        for h in PART.hypotheses:
            if name in h.passes:
                with np.errstate(all="ignore"):
                    judged(case, out, h.rules)
        assert not judged(case, out).passed


# ------------------------------------------------ the passes are those of the renderer


def test_a_chain_of_passes_is_the_grid_that_renders():
    """Vertices of a scene through the passes, one after the other: the same cells."""
    rng = np.random.default_rng(5)
    size = 1500
    camera = Camera((0.0, 1.0, 4.0), (0.0, 1.0, 0.0), (0.0, 1.0, 0.0), 60.0)
    lattice = replace(lattice_of(camera, 3), base=0.25)
    position = rng.uniform(-2, 2, (size, 3))
    normal = rng.normal(size=(size, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    u, active, buckets = rng.random((size, 2)), rng.random(size) < 0.9, 16
    backend = BuiltIn("float64")
    eye = dict(zip(("eye_x", "eye_y", "eye_z"), camera.position, strict=True))
    other = {"eye_before_x": 9.0, "eye_before_y": 9.0, "eye_before_z": 9.0}

    def level(points):
        settings = {"when": "insertion", **eye, **other, "base": lattice.base}
        return backend.cell_level(position=points, **settings, base_before=1.0)["level"]

    moved = backend.cell_jitter(
        position=position, normal=normal, level=level(position), u=u
    )["moved"]
    key = backend.cell_key(
        position=moved, normal=normal, level=level(moved), facings=lattice.facings
    )
    words = backend.cell_hash(level=level(moved), **key)
    slot = backend.cell_insert(
        **words, active=active.astype(np.uint32), buckets=buckets
    )["slot"]
    counted = backend.cell_count(slot=slot, left=np.full(size, 3, np.int32))
    start = backend.cell_scan(counter=counted["counter"])["start"]
    storage = backend.cell_scatter(slot=slot, place=counted["place"], start=start)
    lanes = (u[:, 0], u[:, 1], u[:, 0], u[:, 1])
    keys = keys_of(lattice, jittered(lattice, position, normal, lanes), normal)
    grid = build_grid(keys, active, buckets)
    assert grid.lost > 0
    assert len(grid) > 3 * BUCKET
    stored = storage["storage"][: len(grid.cell_storage)]
    np.testing.assert_array_equal(stored, grid.cell_storage)
    np.testing.assert_array_equal(counted["counter"][grid.slot], grid.counters)
    np.testing.assert_array_equal(start[grid.slot], grid.index_buffer[:-1])
    table = np.zeros(size, np.uint32)
    table[grid.slot] = take(
        words["checksum"], grid.cell_storage[grid.index_buffer[:-1]]
    )
    found = backend.cell_find(table=table, **words, buckets=buckets)["slot"]
    np.testing.assert_array_equal(found[active], slot[active])


def test_a_key_is_that_of_the_lattice():
    """No other level, and no other facing, than the renderer's."""
    lattice = Lattice((0.0, 0.0, 0.0), 0.25, 16)
    case = case_of("key-16")
    inputs = {n: a.astype(float) for n, a in case.inputs.items() if n != "level"}
    whole = keys_of(lattice, **inputs)
    given = {**inputs, "level": whole.level.astype(np.int32)}
    found = BuiltIn("float64").cell_key(**given, facings=16)
    assert whole.same(Keys(whole.level, **found)).all()
