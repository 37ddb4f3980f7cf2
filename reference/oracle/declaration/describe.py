"""The page of the documentation about declarations."""

from collections.abc import Iterable, Mapping
from typing import Any

from restir_gi.reference.oracle.contract.fields import Passes
from restir_gi.reference.oracle.declaration.choices import KEYS, OF_PASSES, Key
from restir_gi.reference.oracle.declaration.form import shown
from restir_gi.reference.oracle.declaration.schema import VERSION
from restir_gi.reference.oracle.declaration.words import words_of
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis

EXAMPLES: Mapping[str, str] = {
    "a renderer that has one pass of reuse, with one neighbour": f"""\
schema = "{VERSION}"

[has]
passes = ["initial", "temporal", "spatial", "shade"]
neighbors = [1]
history = false
target = ["outgoing"]
mis = ["1/Z"]
""",
    "choices that bring no bias": f"""\
schema = "{VERSION}"

[choices]
order = "own-first"
cap = "past on arrival"
M.whole = true
M.most = 255
storage = "packed"
generator = "own"
target.luminance = "rec601"
jacobian.refused_both_ways = [0.1, 10]

[choices.spatial]
mis = "balance"
""",
    "choices that are biased on purpose": f"""\
schema = "{VERSION}"
accept = ["jacobian-refused-beyond-4", "jacobian-clamped", "weight-cut"]

[choices]
jacobian.refused = [0.25, 4]
jacobian.clamped = ["1/3", 3]
W_most = 12
""",
}
"""Declarations of the page, by what they are; each is read by a test."""

INTRODUCTION = """\
# What a backend declares

<!-- Written by restir_gi.reference.oracle.declaration.describe; a test compares. -->

A renderer seldom is the contract to the letter. It has some passes and not others, one
target and not both, and it makes choices: it caps M when a reservoir arrives, refuses
shifts with a large Jacobian, stores reservoirs in half precision. Without a word from
you the oracle finds most of that out, as far as it has a name for it. A declaration
says it, with your numbers, and the renderer is judged against the algorithm that it
says it implements.

A declaration is a TOML file, `restir check BACKEND --declaration FILE`, or the same
tables as the argument `declaration` of `restir_oracle.check`, or the attribute
`declaration` of a Python backend: a dict, or the path of a file.

- What it does not have is not asked: neither the case, nor a failure.
- A pass is tried with its declared choices first. If they reproduce every row, they are
  followed. If they do not, that is told, and what does reproduce the rows is looked for
  as it is without a declaration. A renderer passes whose rows are those of other
  choices that bring no bias; a mistake stays one, whatever is declared.
- A declared choice that is *biased* (a clamp of J, a limit of W, 1/M in place of 1/Z)
  is judged against its own formula. Rows that follow it are right, and the verdict says
  *biased by design*, with the size of it: calculated, by sums over all that can happen
  in small worlds, and measured, where whole runs were made. Steps that prove a mean are
  not held against it. It is FAIL, exit code 1, until `accept` names the choice: then it
  is PASS, and the report says it all the same.

Without a declaration a backend is judged as if this page did not exist. A pass of a
Python backend may also raise `NotImplementedError` for a case: then it does not have
what the words of that case ask for.

## The file
"""

SCHEMA = f"""
The first key says which form this is: `schema = "{VERSION}"`. Its JSON
schema is [shown below](#the-schema), installed with the package as
`restir_gi/reference/oracle/declaration/declaration.schema.json`, and
`restir check --declaration-schema` prints it; editors that know schemas of TOML
complete keys by it. Whatever is wrong with a declaration is told in one line, all at
once: which key, what stands there, and what would be right.

"""

TABLES = (
    ("`schema`", "the form of the file"),
    ("`name`", "of the renderer; for people"),
    (
        "`accept`",
        "names of declared choices whose bias does not fail; `jacobian-clamped` stands"
        " for `jacobian-clamped-to-3` as well",
    ),
    ("`[has]`", "what the backend has"),
    ("`[choices]`", "what it does otherwise than the contract"),
)

HAS = (
    ("`passes`", "a list of passes of the [contract](contract.md)", "all that answer"),
    (
        "`neighbors`",
        "a list of how many neighbours pass `spatial` may have, 1 to 30: all cases and"
        " whole runs have such a number",
        "any number",
    ),
    (
        "`history`",
        "whether pass `spatial` merges what it left in the last frame; if not, its past"
        " is empty in all cases and whole runs",
        "true",
    ),
    (
        "a setting",
        "a list of the words that it may be, in all passes that have the setting",
        "all words that need not be declared",
    ),
    (
        "a pass and a setting, as `spatial.mis`",
        "the same in one pass",
        "as for all passes",
    ),
)

CHOICES = """
## `[choices]`

A number may be a fraction in quotes, such as `"1/3"`, where the decimals would not do.
A key with a dot may stand in a table of its own: `jacobian.clamped = [0, 8]`, or
`[choices.jacobian]` and `clamped = [0, 8]`. {passes}
may have choices of their own, in tables such as `[choices.spatial]`, which count there
in place of the others.

"""

KINDS = """
The kind says what a choice leaves alone: *order* the distribution of every run;
*confidence*, *target*, *mis* and *domain* the mean; *visibility* the mean of what a
receiver sees; *storage* the mean, to the rounding of a format. A *biased* one leaves
nothing alone, and needs `accept`. That a mean is left alone is not only believed: of
each pass that reuses samples it is calculated for all its choices together, and choices
that are innocent apart may be biased together. The report then says so, and all of them
have to be accepted.

What a backend has may be a choice, too: without history its pass `spatial` makes the
choice `history-not-merged`, which is innocent and shows in golden folders and captures
alone, and a backend whose `mis` is 1/M alone is biased by design in `one-over-m`.

Weights of which a renderer says `mis = "own"` are judged by M, by which samples may be
kept, and by their expectation on level L1, which has to be asked: W itself is not
known. With `visibility = "shading"` the rows of hidden samples may be anything, as your
final shading tests visibility. `boiling` is a pass of the contract and is judged as
such; to declare it says that the light of the frames is biased by it.

Of a renderer that is judged by its pictures, a declaration says `pixel` and nothing
else.
"""

PUBLISHED = """
## The schema

```{literalinclude} ../../reference/oracle/declaration/declaration.schema.json
:language: json
```
"""


def describe(passes: Passes) -> str:
    """Page about declarations.

    Parameters
    ----------
    passes : mapping of str to Pass; the whole contract
    """
    examples = "".join(
        f"\n{title[0].upper()}{title[1:]}:\n\n```toml\n{text}```\n"
        for title, text in EXAMPLES.items()
    )
    own = ", ".join(f"`{name}`" for name in OF_PASSES)
    words = ("setting", "words", "of passes")
    choices = ("key", "what it says", "by the contract", "other values", "kind")
    return "".join(
        (
            INTRODUCTION,
            examples,
            SCHEMA,
            _table(("key", "value"), TABLES),
            "\n## `[has]`\n\n",
            _table(("key", "value", "where it is not said"), HAS),
            "\nThese settings have words:\n\n",
            _table(words, _settings(passes)),
            CHOICES.format(passes=f"Passes {own}"),
            _table(choices, map(_row, KEYS)),
            KINDS,
            PUBLISHED,
        )
    )


def _table(titles: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = (titles, ("---",) * len(titles), *rows)
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _settings(passes: Passes) -> list[tuple[str, ...]]:
    where: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for one in passes.values():
        for setting in one.settings:
            if words := words_of(setting):
                where.setdefault((setting.name, words), []).append(f"`{one.name}`")
    return [
        (f"`{name}`", ", ".join(f"`{word}`" for word in words), ", ".join(of))
        for (name, words), of in where.items()
    ]


def _row(key: Key) -> tuple[str, ...]:
    usual = f"`{shown(key.contract)}`"
    return f"`{key.name}`", key.meaning, usual, _values(key), _kind(key)


def _values(key: Key) -> str:
    if "enum" in key.form:
        rest = [value for value in key.form["enum"] if value != key.contract]
        return ", ".join(f"`{shown(value)}`" for value in rest)
    if key.form.get("type") == "boolean":
        return f"`{shown(not key.contract)}`"
    return str(key.form["description"])


def _kind(key: Key) -> str:
    kinds = {_kind_of(h) for value in _others(key) for h in key.follows(value)}
    return " or ".join(sorted(kinds)) or "–"


def _kind_of(hypothesis: Hypothesis) -> str:
    return hypothesis.departure or hypothesis.declared or "biased"


def _others(key: Key) -> list[Any]:
    if key.name == "names":
        return []
    if "enum" in key.form:
        return [value for value in key.form["enum"] if value != key.contract]
    return [key.example]
