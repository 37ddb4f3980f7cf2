"""Declarations of valid choices are one set of rules in each pass."""

from math import inf

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from restir_gi.reference.oracle.declaration.choices import (
    EXCLUSIVE,
    KEYS,
    OF_ALL,
    OF_PASSES,
    number,
)
from restir_gi.reference.oracle.declaration.form import faults
from restir_gi.reference.oracle.declaration.read import read_declaration
from restir_gi.reference.oracle.declaration.schema import declaration_schema
from restir_gi.reference.oracle.diagnosis.hypothesis import changes, compatible
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES
from restir_gi.reference.system.errors import UsageError

PASSES = tuple(whole_contract())

FRACTIONS = st.builds("{}/{}".format, st.integers(1, 99), st.integers(1, 99))
AMOUNTS = st.one_of(
    st.floats(2.0**-20, 2.0**20), st.integers(1, 2**20), FRACTIONS, st.just(inf)
)


@st.composite
def limits(draw):
    """The least and the most of J."""
    least = draw(st.one_of(st.just(0), st.floats(0, 1), FRACTIONS))
    low = number(least)
    most = draw(st.one_of(st.floats(1, 2.0**20), st.just(inf)).map(lambda x: low + x))
    return [least, most]


def values_of(key):
    """Values that a key may have."""
    if key.name == "names":
        return st.just(["keeps-the-other-side"])
    if "enum" in key.form:
        return st.sampled_from(key.form["enum"])
    kinds = {"boolean": st.booleans(), "array": limits()}
    return kinds.get(key.form.get("type"), AMOUNTS)


def tables(keys):
    """Choices of some keys, as a flat table."""
    optional = {key.name: values_of(key) for key in keys}
    return st.fixed_dictionaries({}, optional=optional)


def nested(flat):
    """With the tables that names have before their dots."""
    found = {}
    for name, value in flat.items():
        table, _, inner = name.rpartition(".")
        (found.setdefault(table, {}) if table else found)[inner] = value
    return found


INNER = [key for key in KEYS if key.name not in OF_ALL]


def mixed(flat, own):
    """A whole declaration."""
    choices = nested(flat) | {name: nested(one) for name, one in own.items()}
    return {"schema": "restir-declaration 1", "choices": choices}


DECLARATIONS = st.builds(
    mixed,
    tables(KEYS),
    st.dictionaries(st.sampled_from(OF_PASSES), tables(INNER), max_size=2),
)


def read(table):
    """The declaration, or what is told of it."""
    try:
        return read_declaration(table), ""
    except UsageError as error:
        return None, str(error)


@given(DECLARATIONS)
def test_valid_choices_are_rules_or_are_refused(table):
    assert faults(declaration_schema(), table) == []
    said, refusal = read(table)
    if said is None:
        # What two keys exclude is told by what would be right.
        known = [right for _, _, right in EXCLUSIVE]
        assert any(right in refusal for right in (*known, "mis is own"))
        return
    for name in PASSES:
        chosen = [h for h in said.of_pass(name) if h.rules != CONTRACT_RULES]
        assert compatible(chosen)
        whole = {}
        for h in chosen:
            whole |= changes(h.rules)
        assert changes(said.rules_of(name)) == whole


@given(tables(KEYS))
def test_choices_that_exclude_none_are_never_refused(flat):
    for one, other, _ in EXCLUSIVE:
        assume(not (one in flat and other in flat))
    assume(flat.get("mis") != "own")
    said = read_declaration(mixed(flat, {}))
    names = [h.name for h in said.hypotheses]
    assert len(set(names)) == len(names)
    rules = said.rules
    if "W_most" in flat:
        assert rules.W_most == number(flat["W_most"])
    if "jacobian.clamped" in flat:
        assert rules.clamped == tuple(map(number, flat["jacobian.clamped"]))
    if "target.least" in flat:
        assert rules.target.least in (number(flat["target.least"]), 0.0)


@given(
    DECLARATIONS,
    st.sampled_from([key.name for key in KEYS]),
    st.one_of(
        st.text(max_size=3), st.lists(st.text(max_size=3), min_size=3), st.none()
    ),
)
def test_control_spoiled_values_are_told(table, name, value):
    key = next(key for key in KEYS if key.name == name)
    assume(value not in key.form.get("enum", ()))
    assume(not (name == "names" and isinstance(value, list)))
    place, _, inner = name.rpartition(".")
    choices = table["choices"]
    (choices.setdefault(place, {}) if place else choices)[inner] = value
    with pytest.raises(UsageError, match=f"choices.{name}"):
        read_declaration(table)
