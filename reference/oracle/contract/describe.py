"""The contract as a page of the documentation."""

from collections.abc import Iterable, Mapping

from restir_gi.reference.oracle.contract.fields import Field, Pass, Passes
from restir_gi.reference.oracle.exact.registry import limits_of

INTRODUCTION = """\
# The contract of a backend

<!-- Written by restir_gi.reference.oracle.contract.describe; a test compares. -->

A backend is anything that calculates the passes below: shaders, CUDA, C++, Python. It
may have any subset; what is missing is not judged. Each pass is a function of the
buffers that it is given: nothing is kept between calls, and random numbers and
visibility are data, so that neither a ray tracer nor a generator of the same kind is
needed.

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
nothing is kept: W = 0, M counts, and which sample stands in the row is not looked at. A
quotient by 0 is 0, whether the denominator is exactly 0 or has rounded to it. Outputs
are finite.

**Limits.** What a kernel gives at the ends of its numbers stands beneath its pass: no
finite input may give NaN or infinity. How exact the project's own kernels are there, in
half, single and double precision, stands in [Extremes](../explanation/extremes.md).

**Terms.** What is marked "may" nobody has to give. It is not judged; where a pass is
wrong, the report shows it beside what it should be.

**Random numbers** are given as `u`. Whoever wants to make them: u of dimension d of
stream s of a pixel is the four lanes of `random` with the key (pixel, frame, seed, 64
s + d). Streams: 0 pixel, 1 initial, 2 temporal, 3 spatial, 4 direct, 5 specular, 6
path, 7 roulette. `direction` takes lanes 1 and 2 of stream 1, dimension 0; `temporal`
and `moved` lane 0 of stream 2, dimension 0; `neighbors` lanes 0 and 1 of stream 3,
dimension k; `spatial` lane 2 of the same for neighbour k, and lane 0 of dimension 63
for the pixel's own reservoir.

How to connect a backend, and the form of the files, stands in
[How-to](../howto/index.md).
"""


def describe(passes: Passes) -> str:
    """Page of the contract, in Markdown."""
    return INTRODUCTION + "".join(_section(one) for one in passes.values())


def _section(one: Pass) -> str:
    lines = [f"\n## `{one.name}`\n\n{one.summary}. {one.source}\n\n"]
    lines.append("```text\n" + one.formula + "\n```\n\n")
    lines.append("| | name | shape | kind | meaning |\n|---|---|---|---|---|\n")
    lines += [_row("in", field) for field in one.inputs]
    lines += [
        f"| setting | `{s.name}` | | {_cell(s.values)} | {_cell(s.meaning)} |\n"
        for s in one.settings
    ]
    lines += [_row("out", field) for field in one.outputs]
    lines += [_row("may", field) for field in one.terms]
    lines += [_limits(name, defined) for name, defined in limits_of(one.name).items()]
    return "".join(lines)


def _limits(kernel: str, defined: Mapping[str, str]) -> str:
    rows = "".join(
        f"| {extreme} | {_cell(what)} |\n" for extreme, what in defined.items()
    )
    return f"\n| at its limits: {kernel} | it gives |\n|---|---|\n{rows}"


def _row(word: str, field: Field) -> str:
    shape = _shape(("N", *field.columns))
    meaning = _cell(field.meaning)
    return f"| {word} | `{field.name}` | {shape} | {field.kind} | {meaning} |\n"


def _shape(sizes: Iterable[int | str]) -> str:
    return " × ".join(str(size) for size in sizes)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
