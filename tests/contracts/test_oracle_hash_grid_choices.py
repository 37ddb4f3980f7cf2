"""Choices of a hash grid that are not the contract's: who makes them right passes."""

from dataclasses import replace

import numpy as np
import pytest

from restir_gi.hashgrid.oracle.part import PART
from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.checking import judge
from restir_gi.reference.oracle.levels.probe import examined
from restir_gi.reference.oracle.parts import judge_of, whole_contract
from restir_gi.reference.oracle.replay.bounded import exact, rounding_of
from restir_gi.reference.oracle.replay.halves import (
    RELATIVE,
    beside_halves,
    counted_in_half,
    held_in_half,
)
from tests.mutants.hash_grid_by_hand import WORD, HashGridByHand

BY_NAME = {h.name: h for h in PART.hypotheses}

OF_ONE_KIND = "cell-hash-of-another-kind"
OF_ONE_RULE = "cell-level-of-another-rule"
INNOCENT = (
    "cell-insert-goes-on-in-the-next-bucket",
    "cell-find-goes-on-in-the-next-bucket",
    "cell-insert-by-upper-bits",
    "cell-find-by-upper-bits",
    *(
        f"{name}-in-{halves}"
        for name in ("light-candidates", "light-reuse", "path-cache")
        for halves in ("halves", "halves-cut")
    ),
)
DECLARED = (OF_ONE_KIND, OF_ONE_RULE)


class GridOf:
    """A backend of single passes, by functions from what is given to what is given."""

    precision = "float32"

    def __init__(self, **passes):
        self._passes = passes

    def __getattr__(self, name):
        """A pass."""
        if name.startswith("_") or name not in self._passes:
            raise AttributeError(name)
        return self._passes[name]


def by_hand(pass_name, name):
    """A backend that makes a choice, and has one pass."""
    made = HashGridByHand("float32", name)
    return GridOf(**{pass_name: lambda **given: made(pass_name, **given)})


def verdict_on(backend, pass_name, *names, **has):
    """A verdict on one pass, with choices that are declared by their names."""
    declaration = {"schema": "restir-declaration 1"}
    if names:
        declaration["choices"] = {"names": list(names)}
    if has:
        declaration["has"] = has
    only = Selection(only=frozenset([pass_name]))
    return judge(
        backend, 120, statistics=False, declaration=declaration, selection=only
    )


def named(verdict):
    """What the rows are said to be those of."""
    return {h.name for d in verdict.diagnoses for h in d.matches}


def changed(pass_name, name, change):
    """A backend that makes a choice, with a change on top."""
    made = HashGridByHand("float32", name)

    def answer(**given):
        return change(made(pass_name, **given), given)

    return GridOf(**{pass_name: answer})


# ------------------------------------------------ who is right


@pytest.mark.parametrize("name", INNOCENT)
def test_an_innocent_choice_passes_declared_or_not_and_is_told(name):
    (pass_name,) = BY_NAME[name].passes
    for names in ((), (name,)):
        verdict = verdict_on(by_hand(pass_name, name), pass_name, *names)
        assert verdict.status == "PASS"
        assert name in named(verdict)


@pytest.mark.parametrize("name", DECLARED)
def test_what_another_rule_gives_passes_where_it_is_declared_and_else_has_a_name(name):
    (pass_name,) = BY_NAME[name].passes
    backend = by_hand(pass_name, name)
    assert verdict_on(backend, pass_name, name).status == "PASS"
    undeclared = verdict_on(backend, pass_name)
    assert undeclared.status == "FAIL"
    assert named(undeclared) == {name}


RULES = {
    "of one size": lambda far: np.full(len(far), 5),
    "of half a level": lambda far: np.floor(2 * np.log2(np.maximum(far, 1))),
    "at most 9": lambda far: np.clip(np.floor(np.log2(far + 1e-30)), 0, 9),
    "below 0": lambda far: np.floor(np.log2(far + 1e-30)),
}


@pytest.mark.parametrize("rule", RULES)
def test_any_rule_that_grows_from_the_eye_is_right(rule):
    def answer(position, when, **s):
        end = "_before" if when == "look-up" else ""
        eye = np.float32([s[f"eye{end}_{axis}"] for axis in "xyz"])
        far = np.linalg.norm(position - eye, axis=1) * 1000 * s[f"base{end}"]
        return {"level": RULES[rule](far).astype(np.int32)}

    backend = GridOf(cell_level=answer)
    assert verdict_on(backend, "cell_level", OF_ONE_RULE).status == "PASS"


def test_a_hash_with_a_short_checksum_is_right():
    def short(out, given):
        return {**out, "checksum": np.maximum(out["checksum"] & 0xFFFF, 1)}

    backend = changed("cell_hash", OF_ONE_KIND, short)
    assert verdict_on(backend, "cell_hash", OF_ONE_KIND).status == "PASS"


@pytest.mark.parametrize("most", [2, 3, 100])
def test_any_limit_of_probing_is_right(most):
    """Who tries but a few buckets more loses cells where these are full."""

    def answer(bucket_hash, checksum, active, buckets):
        table, slots = [0] * (buckets * 16), np.full(len(active), -1, np.int32)
        for v in np.flatnonzero(active):
            first = int(bucket_hash[v]) % buckets * 16
            for k in range(16 * min(most, buckets)):
                at = (first + k) % len(table)
                if table[at] in (0, checksum[v]):
                    table[at], slots[v] = checksum[v], at
                    break
        return {"slot": slots}

    name = "cell-insert-goes-on-in-the-next-bucket"
    verdict = verdict_on(GridOf(cell_insert=answer), "cell_insert", name)
    assert verdict.status == "PASS"


@pytest.mark.parametrize("pass_name", ["cell_jitter", "cell_key"])
def test_edges_of_cells_may_be_given(pass_name):
    for backend in (FLOAT32, HashGridByHand("float32")):
        for probe in PART.more("float32"):
            case = probe.case
            if case.pass_name == pass_name:
                given = {**case.inputs, **case.settings}
                if backend is FLOAT32:
                    out = getattr(FLOAT32, pass_name)(**given)
                else:
                    out = backend(pass_name, **given)
                contract = whole_contract()
                assert not examined(contract, "float32", probe, out).finding.text
    verdict = verdict_on(by_hand(pass_name, ""), pass_name, size=["edge"])
    assert verdict.status == "PASS"


# ------------------------------------------------ who is wrong


def zero(out, given):
    checksum = np.where(given["x"] % 7 == 0, 0, out["checksum"])
    return {**out, "checksum": checksum.astype(np.uint32)}


def mixed(out, given):
    """Combined by exclusive or of products: (1, 2, 2) is (1, 3, 3)."""
    word = 0 * given["x"].astype(np.int64)
    for name in ("level", "x", "y", "z", "facing"):
        word ^= given[name].astype(np.int64) * 73856093 % WORD
    check = np.maximum(word * 668265263 % WORD, 1)
    return {"bucket_hash": word.astype(np.uint32), "checksum": check.astype(np.uint32)}


def of_rows(out, given):
    """Words that hang on the row, as where memory was not written."""
    return {
        **out,
        "bucket_hash": out["bucket_hash"]
        + np.arange(len(out["checksum"]), dtype=np.uint32),
    }


def twice(out, given):
    return {**out, "checksum": np.maximum(out["bucket_hash"], 1)}


def without(*names):
    def change(out, given):
        fields = {n: given[n] * (n not in names) for n in given}
        return HashGridByHand("float32", OF_ONE_KIND)("cell_hash", **fields)

    return change


def of_negatives_as_0(out, given):
    fields = {n: np.maximum(given[n], 0) for n in given}
    return HashGridByHand("float32", OF_ONE_KIND)("cell_hash", **fields)


@pytest.mark.parametrize(
    "change",
    [
        zero,
        mixed,
        of_rows,
        twice,
        of_negatives_as_0,
        *(without(n) for n in ("level", "x", "y", "z", "facing")),
    ],
)
def test_control_a_hash_of_its_own_may_be_wrong(change):
    backend = changed("cell_hash", OF_ONE_KIND, change)
    assert verdict_on(backend, "cell_hash", OF_ONE_KIND).status == "FAIL"


@pytest.mark.parametrize(
    "name", ["cell-hash-of-negatives-as-0", "cell-hash-without-level"]
)
def test_control_the_contracts_hash_with_a_mistake_is_no_other_hash(name):
    backend = by_hand("cell_hash", name)
    assert verdict_on(backend, "cell_hash", OF_ONE_KIND).status == "FAIL"


@pytest.mark.parametrize(
    "name", ["cell-level-by-this-eye", "cell-level-from-the-origin"]
)
def test_control_a_rule_of_its_own_has_the_eye_of_the_grid(name):
    backend = by_hand("cell_level", name)
    assert verdict_on(backend, "cell_level", OF_ONE_RULE).status == "FAIL"


def test_control_levels_that_hang_on_the_row_are_no_rule():
    def loose(out, given):
        return {
            "level": out["level"] + np.arange(len(out["level"]), dtype=np.int32) % 2
        }

    backend = changed("cell_level", OF_ONE_RULE, loose)
    assert verdict_on(backend, "cell_level", OF_ONE_RULE).status == "FAIL"


NEXT = "goes-on-in-the-next-bucket"


def shifted(out, given):
    """It goes on in the bucket after the next one."""
    buckets = given["buckets"]
    slot, own = out["slot"], given["bucket_hash"].astype(np.int64) % buckets
    moved = (slot >= 0) & (slot // 16 != own)
    return {
        "slot": np.where(moved, (slot + 16) % (16 * buckets), slot).astype(np.int32)
    }


def from_the_next(out, given):
    """It begins in the next bucket, whether its own one is full or not."""
    hash_ = ((given["bucket_hash"].astype(np.int64) + 1) % WORD).astype(np.uint32)
    made = HashGridByHand("float32", f"cell-insert-{NEXT}")
    return made("cell_insert", **{**given, "bucket_hash": hash_})


def of_16_bits(pass_name, name):
    """The upper bits of the lower half."""

    def change(out, given):
        hash_ = (given["bucket_hash"].astype(np.int64) << 16) % WORD
        made = HashGridByHand("float32", name)
        return made(pass_name, **{**given, "bucket_hash": hash_.astype(np.uint32)})

    return change


@pytest.mark.parametrize(
    ("name", "change"),
    [
        (f"cell-insert-{NEXT}", shifted),
        (f"cell-insert-{NEXT}", from_the_next),
        (f"cell-find-{NEXT}", shifted),
        *(
            (
                f"{n}-by-upper-bits",
                of_16_bits(n.replace("-", "_"), f"{n}-by-upper-bits"),
            )
            for n in ("cell-insert", "cell-find")
        ),
    ],
)
def test_control_another_bucket_may_be_wrong(name, change):
    (pass_name,) = BY_NAME[name].passes
    backend = changed(pass_name, name, change)
    for names in ((), (name,)):
        assert verdict_on(backend, pass_name, *names).status == "FAIL"


def test_control_what_is_declared_is_done():
    """The contract's rows are not those of a backend that goes on."""
    name = f"cell-find-{NEXT}"
    (one,) = verdict_on(by_hand("cell_find", ""), "cell_find", name).followed
    assert one.state == "otherwise"
    (one,) = verdict_on(by_hand("cell_find", name), "cell_find", name).followed
    assert one.state == "followed"


@pytest.mark.parametrize("of", ["light-candidates", "light-reuse", "path-cache"])
def test_control_halves_that_overflow_fail_under_their_name(of):
    name = f"{of}-in-halves"
    (pass_name,) = BY_NAME[name].passes
    for names in ((), (name,)):
        verdict = verdict_on(by_hand(pass_name, f"{name}-infinite"), pass_name, *names)
        assert verdict.status == "FAIL"
        assert f"{name}-infinite" in named(verdict)


def coarse(out, given):
    """Eight bits of a number, as of bfloat16: its halves, too, are too far away."""
    with np.errstate(all="ignore"):
        bits = out["W"].astype("f4").view(np.uint32) & np.uint32(0xFFFF0000)
    return {**out, "W": bits.view(np.float32)}


def doubled(out, given):
    return {**out, "M": out["M"] * np.float32(2)}


@pytest.mark.parametrize("of", ["light-candidates", "light-reuse", "path-cache"])
@pytest.mark.parametrize("change", [coarse, doubled])
def test_control_other_numbers_are_no_halves(of, change):
    name = f"{of}-in-halves"
    (pass_name,) = BY_NAME[name].passes
    backend = changed(pass_name, name, change)
    assert verdict_on(backend, pass_name, name).status == "FAIL"


@pytest.mark.parametrize("pass_name", ["cell_jitter", "cell_key"])
def test_control_given_edges_are_taken_as_they_are(pass_name):
    """Who rounds them down to a power of two has other cells."""

    def answer(**given):
        if "edge" in given:
            level = np.floor(np.log2(np.maximum(given["edge"] * 1000, 1)))
            given["edge"] = np.float32(1e-3 * 2.0**level)
        return HashGridByHand("float32")(pass_name, **given)

    backend = GridOf(**{pass_name: answer})
    assert verdict_on(backend, pass_name, size=["edge"]).status == "FAIL"


# ------------------------------------------------ the bound of halves


def test_the_bound_of_a_half_is_kept_and_is_reached():
    rng = np.random.default_rng(7)
    wide = np.concatenate(
        [10.0 ** rng.uniform(-4, 4.8, 20000), [1 + 2.0**-11, 65504.0]]
    )
    x = exact(wide.astype(np.float32), rounding_of("float32"))
    half = wide.astype(np.float32).astype(np.float16)
    cut = np.where(half > x.value, np.nextafter(half, np.float16(0)), half)
    for how, held in (("half", half), ("half, cut", cut)):
        bound = held_in_half(x, how)
        assert (abs(held - bound.value) <= bound.error).all()
    assert np.max(abs(half / x.value - 1)) > 0.99 * RELATIVE
    off = abs(half.astype(float) - x.value)
    assert (off <= RELATIVE * x.value).all()


def test_halves_have_ends():
    x = exact(np.array([0.0, 1e-9, 65519.0, 65520.0, 1e9]), rounding_of("float32"))
    held = held_in_half(x, "half")
    assert np.isfinite(held.value + held.error).all()
    assert held.value[0] == held.error[0] == 0
    assert held.error[1] >= held.value[1] > 0
    assert (held.value[2:] == 65504).all()
    infinite = held_in_half(x, "half, infinite").value
    most = np.finfo(np.float32).max
    assert (infinite == most).tolist() == [False, False, False, True, True]
    M = exact(np.array([20.0, 2048.0, 4097.0, 3.5]), rounding_of("float32"))
    assert (counted_in_half(M, "half").error > 0).tolist() == [False, False, True, True]


def test_what_is_given_is_a_half():
    found = np.float32([1.0, 1.0 + 2.0**-12, 65504.0])
    (one,) = beside_halves("W", found, "half")
    assert (one.excess > 0).tolist() == [False, True, False]
    assert beside_halves("W", found, "exact") == []


def test_control_a_weight_that_is_off_by_more_is_wrong():
    """By two steps of a half, on either side; and not each is cut off."""
    case = next(p.case for p in PART.probes("float32") if p.case.name == "grid-cache")
    rules = BY_NAME["path-cache-in-halves"].rules
    out = HashGridByHand("float32", "path-cache-in-halves")(
        "path_cache", **case.inputs, **case.settings
    )
    there = (out["stored"] == 1) & (out["W"] > 1) & (out["W"] < 6e4)
    for end in (0, np.inf):
        W = np.where(there, out["W"], 1).astype(np.float16)
        for _ in range(2):
            W = np.nextafter(W, np.float16(end))
        W = np.where(there, W, out["W"])
        W = W.astype(np.float32)
        judged = judge_of("path_cache")(case, {**out, "W": W}, rules, "float32")
        assert judged.wrong[there].all()
    part = replace(rules.part, suffix=replace(rules.part.suffix, held="half, cut"))
    cut = judge_of("path_cache")(case, out, replace(rules, part=part), "float32")
    assert not cut.passed
