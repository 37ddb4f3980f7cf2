"""A declaration from a file, or from a mapping of a program."""

import tomllib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from restir_gi.reference.oracle.backends.selected import Selection
from restir_gi.reference.oracle.contract.fields import Passes, Setting
from restir_gi.reference.oracle.declaration.choices import (
    EXCLUSIVE,
    KEYS,
    OF_PASSES,
    Key,
    catalogue,
    number,
)
from restir_gi.reference.oracle.declaration.declared import Declaration
from restir_gi.reference.oracle.declaration.form import as_json, faults, shown
from restir_gi.reference.oracle.declaration.schema import declaration_schema
from restir_gi.reference.oracle.declaration.words import words_of
from restir_gi.reference.oracle.diagnosis.hypothesis import (
    Hypothesis,
    as_declared,
    changes,
    combined,
    compatible,
)
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.replay.mis import OWN
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.suggestions import unknown

Table = Mapping[str, Any]


def read_declaration(given: Path | str | Table) -> Declaration:
    """What a backend says of itself.

    Raises UsageError: there is no such file, or it says what cannot be: all that is
    wrong with it, with the key, what stands there and what would be right.

    Parameters
    ----------
    given : path of a TOML file, or mapping; the same keys
    """
    if isinstance(given, Mapping):
        name, table = "the declaration", as_json(given)
    else:
        name, table = str(given), _loaded(Path(given))
    found = faults(declaration_schema(), table) or [*_misplaced(table)]
    if found:
        raise UsageError(f"{name}: {'; '.join(found)}")
    return _read(table)


def with_names(
    declared: Declaration, names: Collection[str], accept: Collection[str]
) -> Declaration:
    """A declaration with choices by their names, and with more that is accepted.

    Raises UsageError: no choice is called so, or it cannot hold beside the others, or
    what is accepted is not declared.
    """
    known = catalogue()
    for name in sorted(names):
        if name not in known:
            told = "those of the known mistakes"
            raise UsageError(f"--declare: {unknown('choice', name, known, told)}")
    more = tuple(as_declared(known[name]) for name in sorted(names))
    found = {h.name: h for h in (*declared.hypotheses, *more)}
    whole = replace(
        declared,
        hypotheses=tuple(found.values()),
        accept=declared.accept | frozenset(accept),
    )
    wrong = [*_clashes(whole.hypotheses), *_not_declared(whole)]
    if wrong:
        raise UsageError("; ".join(wrong))
    return whole


def _loaded(path: Path) -> Table:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        reason = error.strerror or str(error)
        raise UsageError(
            f"cannot read {path}: {reason}; name a TOML file with a declaration"
        ) from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise UsageError(
            f"{path} is not TOML: {error}; quote words, and write tables as [choices]"
        ) from error


def _misplaced(table: Table) -> Iterator[str]:
    """What has the form of a declaration, and cannot be."""
    passes = whole_contract()
    yield from _unknown_in_has(table.get("has", {}), passes)
    choices = table.get("choices", {})
    wrong = [*_wrong_values(choices)]
    yield from wrong
    if not wrong:
        yield from _wrong_together(table)


def _unknown_in_has(has: Table, passes: Passes) -> Iterator[str]:
    for name in has.get("passes", ()):
        if name not in passes:
            yield f"has.passes: {unknown('pass', name, passes)}"
    for key, value in _settings_in(has):
        of_pass, _, name = key.rpartition(".")
        if of_pass and of_pass not in passes:
            yield f"has.{of_pass}: {unknown('pass', of_pass, passes)}"
            continue
        among = [passes[of_pass]] if of_pass else list(passes.values())
        settings = [s for p in among for s in p.settings if words_of(s)]
        mine = [s for s in settings if s.name == name]
        if not mine:
            kind = f"setting of {of_pass}" if of_pass else "key, and no setting"
            names = sorted({s.name for s in settings})
            yield f"has.{key}: {unknown(kind, name, names, ', '.join(names) or 'none')}"
            continue
        words = list(dict.fromkeys(word for s in mine for word in words_of(s)))
        for word in value:
            if word not in words:
                yield f"has.{key}: {unknown('value', word, words)}"


RESERVED = ("passes", "neighbors", "history")


def _settings_in(has: Table) -> Iterator[tuple[str, Any]]:
    """Settings with their values, after the pass and a dot where it is named."""
    for name, value in has.items():
        if isinstance(value, Mapping):
            yield from ((f"{name}.{setting}", some) for setting, some in value.items())
        elif name not in RESERVED:
            yield name, value


def _flat(table: Table) -> dict[str, Any]:
    """Choices by their keys, with a dot where they stand in a table of their own."""
    found: dict[str, Any] = {}
    for name, value in table.items():
        if name in OF_PASSES:
            continue
        if isinstance(value, Mapping):
            found |= {f"{name}.{inner}": one for inner, one in value.items()}
        else:
            found[name] = value
    return found


BY_NAME: Mapping[str, Key] = {key.name: key for key in KEYS}


JACOBIANS = ("refused", "refused_both_ways", "clamped")
PAIRS = (*(f"jacobian.{key}" for key in JACOBIANS), "max_age")
"""Keys that have two numbers, or may have."""


def _wrong_values(choices: Table) -> Iterator[str]:
    """Values that no form can refuse, and those that cannot go together."""
    for where, table in [("", choices), *((p, choices.get(p, {})) for p in OF_PASSES)]:
        place = f"choices.{where}." if where else "choices."
        flat = _flat(table)
        for key in PAIRS:
            limits = flat.get(key)
            if isinstance(limits, list) and not number(limits[0]) < number(limits[1]):
                told = "and should be the least and then the most"
                yield f"{place}{key} is {shown(limits)}, {told}"
        known = catalogue()
        for name in flat.get("names", ()):
            if name not in known:
                close = unknown("name", name, known, "those of the known mistakes")
                yield f"{place}names: {close}"
        whole = _flat(choices) | flat
        for one, other, right in EXCLUSIVE:
            mine = one in flat or other in flat
            if mine and _differs(whole, one) and _differs(whole, other):
                yield f"{place}{one} beside {other}: {right}"


def _differs(flat: Table, key: str) -> bool:
    """Whether a choice is another than the contract's."""
    return key in flat and flat[key] != BY_NAME[key].contract


def _wrong_together(table: Table) -> Iterator[str]:
    """Choices that cannot all hold, and names that are accepted and not declared."""
    has, choices = table.get("has", {}), table.get("choices", {})
    found = _followed(choices, has)
    yield from _clashes(found)
    accept = frozenset(table.get("accept", ()))
    yield from _not_declared(Declaration(hypotheses=found, accept=accept))


def _not_declared(whole: Declaration) -> Iterator[str]:
    names = [h.name for h in whole.hypotheses]
    for word in sorted(whole.accept):
        one = Declaration(accept=frozenset([word]))
        if not any(map(one.accepts, names)):
            known = ", ".join(names) or "none"
            yield f"accept: {unknown('declared choice', word, names, known)}"


def _clashes(found: tuple[Hypothesis, ...]) -> Iterator[str]:
    everywhere = [p for p in whole_contract() if any(p in h.passes for h in found)]
    for name in everywhere:
        here = [h for h in found if name in h.passes and changes(h.rules)]
        names = " and ".join(h.name for h in here)
        if not compatible(here):
            yield f"choices: {names} cannot hold together in {name}; leave one out"
        biased = [h.name for h in here if h.departure == "bias"]
        if biased and any(h.rules.normalization == OWN for h in here):
            yield (
                f"choices: in {name} mis is own, beside {', '.join(biased)}: weights"
                " that nobody knows are judged by their mean, which is biased then;"
                " leave one out"
            )


def _read(table: Table) -> Declaration:
    has, choices = table.get("has", {}), table.get("choices", {})
    flat = _flat(choices)
    generator = flat.get("generator", "contract")
    found = _followed(choices, has)
    return Declaration(
        _selection(has, generator),
        found,
        frozenset(table.get("accept", ())),
        generator,
        dict(has),
        flat.get("pixel", "center"),
        frozenset(p for p in OF_PASSES if _has_its_own_choices(choices, p)),
    )


def _has_its_own_choices(choices: Table, name: str) -> bool:
    """Whether a pass makes other choices than are made elsewhere."""
    if name not in choices:
        return False
    general = _flat(choices)
    own = general | _flat(choices[name])
    found = ([h for h in _hypotheses(of) if name in h.passes] for of in (general, own))
    return combined(next(found)) != combined(next(found))


def _followed(choices: Table, has: Table) -> tuple[Hypothesis, ...]:
    """Choices other than the contract's, each once, with the passes that make them."""
    general = _flat(choices)
    whole = _hypotheses(general)
    everywhere = [p for p in whole_contract() if any(p in h.passes for h in whole)]
    of_pass = {name: [h for h in whole if name in h.passes] for name in everywhere}
    for name in OF_PASSES:
        if name in choices:
            own = _hypotheses(general | _flat(choices[name]))
            of_pass[name] = [h for h in own if name in h.passes]
    for name, lacked in _what_it_has_not(has):
        here = of_pass.setdefault(name, [])
        if compatible([*here, lacked]):
            here.append(lacked)
    found: dict[str, Hypothesis] = {}
    for name, chosen in of_pass.items():
        for h in chosen:
            before = found[h.name].passes if h.name in found else ()
            found[h.name] = replace(h, passes=(*before, name))
    return tuple(found.values())


def _what_it_has_not(has: Table) -> Iterator[tuple[str, Hypothesis]]:
    """Choices that a backend makes by what it has: no history, or 1/M alone."""
    if not has.get("history", True):
        yield "spatial", as_declared(catalogue()["history-not-merged"])
    words = {key: set(some) for key, some in _settings_in(has)}
    one_over_m = as_declared(catalogue()["one-over-m"])
    for name in one_over_m.passes:
        if words.get(f"{name}.mis", words.get("mis")) == {"1/M"}:
            yield name, one_over_m


def _hypotheses(flat: Table) -> list[Hypothesis]:
    found = [h for key, value in flat.items() for h in _of_key(key, value)]
    return [as_declared(h) for h in dict.fromkeys(found)]


def _of_key(key: str, value: Any) -> tuple[Hypothesis, ...]:
    one = BY_NAME[key]
    return () if value == one.contract else one.follows(value)


def _selection(has: Table, generator: str) -> Selection:
    passes = whole_contract()
    had: dict[tuple[str, str], list[str]] = {}
    for key, words in _settings_in(has):
        of_pass, _, name = key.rpartition(".")
        for one in [passes[of_pass]] if of_pass else passes.values():
            if of_pass or not _has_its_own(has, one.name, name):
                had[one.name, name] = words
    settings = {(p.name, s.name): s for p in passes.values() for s in p.settings}
    had = {at: _as_known(settings[at], w) for at, w in had.items() if at in settings}
    every = {
        (*at, word): word in words
        for at, words in had.items()
        for word in words_of(settings[at])
    }
    return Selection(
        only=frozenset(has.get("passes", ())),
        skip=frozenset(["random"] if generator == "own" else ()),
        more=frozenset(one for one, is_had in every.items() if is_had),
        declined=frozenset(one for one, is_had in every.items() if not is_had),
        neighbors=frozenset(map(int, has.get("neighbors", ()))),
        history=bool(has.get("history", True)),
    )


def _as_known(setting: Setting, words: list[str]) -> list[str]:
    """Words of a setting as a pass has it.

    For one that it does not know, as where nothing moves balance is 1/Z, that stands
    which it is where nothing is said.
    """
    known = words_of(setting)
    found = [word if word in known else setting.default for word in words]
    return list(dict.fromkeys(filter(None, found)))


def _has_its_own(has: Table, pass_name: str, setting: str) -> bool:
    """Whether a pass has values of its own for a setting."""
    table = has.get(pass_name)
    return isinstance(table, Mapping) and setting in table
