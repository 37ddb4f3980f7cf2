"""The contract as a page of the documentation."""

from collections.abc import Iterable, Iterator, Mapping

from restir_gi.reference.oracle.contract.fields import (
    Field,
    Pass,
    Passes,
    Setting,
)
from restir_gi.reference.oracle.contract.surfaces import MATERIAL, PAGE
from restir_gi.reference.oracle.contract.targets import PAGE as TARGETS
from restir_gi.reference.oracle.contract.weights import PAGE as WEIGHTS
from restir_gi.reference.oracle.exact.registry import limits_of

INTRODUCTION = """\
# The contract of a backend

<!-- Written by restir_gi.reference.oracle.contract.describe; a test compares. -->

A backend is anything that calculates the passes below: shaders, CUDA, C++, Python. It
may have any subset; what is missing is not judged. Each pass is a function of the
buffers that it is given: nothing is kept between calls, and random numbers and
visibility are data, so that neither a ray tracer nor a generator of the same kind is
needed.
"""

RULES = """\
**Buffers.** N rows each; a row is an element of a storage buffer. A frame's rows are
its pixels, row = y · width + x, from the top left. Numbers are little-endian and
tightly packed in C order: a vector is three reals, without padding.

| kind | type | |
|---|---|---|
| real | float32, or float64 throughout | finite; radiance in Rec. 709, lengths in m |
| index | int32 | a row, or −1 for none |
| bits | uint32 | words, flags that are 0 or 1, or masks: bit 0 is the lowest |

**Rounding.** Any order of operations is right, fused or not, with subnormal numbers
or without. What is compared is not an image: each output is held against exact
arithmetic on the very numbers that the backend was given, and may differ by what its
own operations can round. A decision may fall either way where rounding leaves it
open; how often that happens is counted against what chance allows.

**Rows that are not there.** A reservoir with W = 0 and M = 0 is empty; a sample with
radiance 0 is a null, and one with pdf 0 has w = 0. Where all weights of a stream are 0
nothing is kept: M counts, W = 0, and which sample stands in the row is not looked at. W
of a row whose sample is a null is not looked at either, as long as it is no less than
0: p̂ of a null is 0 wherever it is reused, so that nothing shows it. Where p̂ is 0
although there is light, as on a black surface, W must be 0: another receiver may
reflect that light. A quotient by 0 is 0, whether the denominator is exactly 0 or has
rounded to it. Outputs are finite.

**Inputs** are those that a loop of frames can make: confidences are at most the caps of
the passes that they come from, samples are valid where they were stored, and a null has
a place and a normal like any other. Random rows depend on a seed.

**Two grades.** A row is beyond the working range where one of its numbers is such that
no scene has it: points less than 1e-6 m apart, or less than 1e-6 of their own size;
more than 1e6 m; one point 1e4 times as far from a sample as another; a cosine between 0
and 1e-4; a row without a normal; radiances, densities and W that are not 0 and outside
of 1e-7 to 1e7, targets and weights outside of 1e-16 to 1e16, confidences outside of
1e-3 to 1e5, depths outside of 1e-6 to 1e6 m, widths of lobes outside of 0.02 to 1.
Products of numbers within stay inside float32, in any order. What is wrong beyond
alone, NaN too, is told, and fails only where extremes are asked for.

**Limits.** What a kernel gives at the ends of its numbers stands beneath its pass: no
finite input may give NaN or infinity. How exact the project's own kernels are there, in
half, single and double precision, stands in [Extremes](../explanation/extremes.md).

**Terms.** What is marked "may" nobody has to give. It is not judged; where a pass is
wrong, the report shows it beside what it should be.

**Declared settings.** Values that stand behind "declared" are asked only of a backend
that [declares](declaration.md) them; all others it has, unless it declares which it
has, or raises `NotImplementedError`. A buffer that is "given where" a setting has a
value is no argument of other calls.

**Choices** that differ from what stands here may be [declared](declaration.md) as well:
each pass is then held against the formula that the backend says it has.

**Random numbers** are given as `u`. Whoever wants to make them: u of dimension d of
stream s of a pixel is the four lanes of `random` with the key (pixel, frame, seed, 64
s + d). Streams: 0 pixel, 1 initial, 2 temporal, 3 spatial, 4 direct, 5 specular, 6
path, 7 roulette. `direction` takes lanes 1 and 2 of stream 1, dimension 0; `temporal`
and `moved` lane 0 of stream 2, dimension 0; `neighbors` lanes 0 and 1 of stream 3,
dimension k; `spatial` lane 2 of the same for neighbour k, and lane 0 of dimension 63
for the pixel's own reservoir; `fused` lane 2 of the same for source k.

How to connect a backend, and the form of the files, stands in
[How-to](../howto/index.md).
"""

HEAD = "| | name | shape | kind | meaning |\n|---|---|---|---|---|\n"
PREFIXES = ("", "past_")
"""Of buffers of visible points."""


def describe(passes: Passes) -> str:
    """Page of the contract, in Markdown."""
    sections = map(_section, passes.values())
    about = INTRODUCTION, _table(passes), RULES, _surfaces(), TARGETS, WEIGHTS
    return "".join((*about, *sections))


def _table(passes: Passes) -> str:
    """All passes, each with a link to its section."""
    rows = "".join(
        f"| [`{name}`](#{name}) | {_cell(one.summary)} | {_declared(one)} |\n"
        for name, one in passes.items()
    )
    return (
        f"\n| pass | what it calculates | declared settings |\n|---|---|---|\n{rows}\n"
    )


def _declared(one: Pass) -> str:
    """Values that are asked only of backends that declare them."""
    return ", ".join(
        f"`{s.name}`: {_cell(' | '.join(s.more))}" for s in one.settings if s.more
    )


def _surfaces() -> str:
    return f"{PAGE}\n{HEAD}" + "".join(_row("in", field) for field in MATERIAL)


def _section(one: Pass) -> str:
    lines = [f"\n## `{one.name}`\n\n{one.summary}. {one.source}\n\n"]
    lines.append("```text\n" + one.formula + "\n```\n\n")
    lines.append(HEAD)
    lines += _inputs(one.inputs)
    lines += [
        f"| setting | `{s.name}` | | {_cell(_values(s))} | {_cell(s.meaning)} |\n"
        for s in one.settings
    ]
    lines += [_row("out", field) for field in one.outputs]
    lines += [_row("may", field) for field in one.terms]
    if one.clauses:
        lines.append("\nWhat the cases look at, one thing at a time:\n\n")
        lines += [f"- {clause}\n" for clause in one.clauses]
    lines += [_limits(name, defined) for name, defined in limits_of(one.name).items()]
    return "".join(lines)


def _inputs(fields: Iterable[Field]) -> Iterator[str]:
    """A row for each buffer, and one for all that a declared surface adds."""
    materials = {f"{prefix}{field.name}" for field in MATERIAL for prefix in PREFIXES}
    told: set[str] = set()
    for field in fields:
        # Pass shift has widths of lobes of its own, which are always given.
        if field.name not in materials or field.only is None:
            yield _row("in", field)
            continue
        prefix = next(p for p in reversed(PREFIXES) if field.name.startswith(p))
        if prefix not in told:
            told.add(prefix)
            name = f"`{prefix}{MATERIAL[0].name}` …"
            where = "of a declared surface, see [Surfaces](#surfaces)"
            yield f"| in | {name} | | | {where} |\n"


def _limits(kernel: str, defined: Mapping[str, str]) -> str:
    rows = "".join(
        f"| {extreme} | {_cell(what)} |\n" for extreme, what in defined.items()
    )
    return f"\n| at its limits: {kernel} | it gives |\n|---|---|\n{rows}"


def _row(word: str, field: Field) -> str:
    shape = _shape(("N", *field.columns))
    meaning = _cell(field.meaning)
    if field.only is not None:
        setting, values = field.only
        meaning += f"; given where `{setting}` is {' or '.join(values)}"
    return f"| {word} | `{field.name}` | {shape} | {field.kind} | {meaning} |\n"


def _values(setting: Setting) -> str:
    """What a setting may be, and what it may be for backends that declare it."""
    if not setting.more:
        return setting.values
    words = f"{setting.values}; declared: {' | '.join(setting.more)}"
    return f"{words}; left out where {setting.default}" if setting.default else words


def _shape(sizes: Iterable[int | str]) -> str:
    return " × ".join(str(size) for size in sizes)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
