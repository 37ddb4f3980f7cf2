"""Hostile command lines and hostile files: made of a seed, run, and judged.

Each mutant is a whole command line of the real program, run in this process, in a
folder of its own.  Commands and options are those that the parser has, so that a new
one is covered by itself.  By hand::

    python -m tests.extremes.mutants --count 10000 --seed 1
"""

import argparse
import contextlib
import io
import json
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FrameType

import numpy as np

from restir_gi.reference.cli.main import COMMANDS, build_parser, main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.methods import method_named, method_names
from tests.extremes.corpus import CorpusFile, spoiled, write_corpus

LONGEST = 20.0  # s, of one mutant
ROOM = 256 << 20  # bytes that one may take, beside what its file has
TIMES = 64  # bytes in memory for one of a file; EXR may hold more, and says how much
ADDRESSES = 6 << 30  # bytes of address space beyond which a run is cut off

SLOW = {"check", "demo", "figures", "golden", "tradeoff"}
"""Commands that take seconds even where they are given next to nothing to do."""

USUAL = {
    "X.exr": "x.exr", "A.exr": "../good/ours.exr", "B.exr": "../good/ours.exr",
    "RUN.exr": "../good/restir.exr", "PAGE.html": "p.html", "DIR": "out",
    "SCENE": "../good/scene.json", "M": "path", "BACKEND": "float32",
    "NAME": "bias", "scenes": "cornell-box",
}  # fmt: skip
"""Good values, by what program or help call them; else the parser is asked."""

SMALL = {
    "--size": ("4x4", "8", "16", "8x8"), "--spp": ("1", "2"),
    "--frames": ("1", "2"), "--runs": ("2", "3"), "--budget": ("0.1",),
    "--limit": ("2",), "--design": ("0",), "--processes": ("1",), "--threads": ("1",),
    "--sweep": ("radius=0.1,0.2",),
}  # fmt: skip
"""Options that keep a run small, given wherever a command has them."""

VALUES = (
    "", "-1", "0", "-0", "nan", "inf", "-inf", "1e308", "1e-320", "9" * 400, "1_000",
    "\N{ARABIC-INDIC DIGIT FOUR}", "0x10", "1.5", str(2**27), str(2**63), " 7", "\0",
    "a\0b", "a\nb", "\x1b[2Jred\x07", "é" * 200, "x" * 300, "y" * 70_000, "/", ".",
    "..", "/dev/null", "/dev/full", "/dev/zero", "/dev/null/x", "/dev/null/x.exr",
    "/proc/x.exr", "/proc/x", "no/such", "no.glb", "no.exr", "\udcff.exr",
    "x" * 300 + ".exr", "x" * 300 + ".json", "-", "--", "=", "key=", "=value",
    "pixel=", "pixel=Box",
    "radius=nan", "temporal_cap=1e400", "target=\x1b[31m", "a,b,,c", "depth,", ",",
    "[red]", "[/red]", "{}", "{directory}", "'{seed} {out}", '"', "%s%n",
    "module:thing", "no.py", "os:getcwd", "sh -c 'exit 3' {directory}",
    "false {seed} {out}",
    "cornel-box", "restir-gi", "1x99999999", "0x4", "-4x4", "16385x1", "4x4x4",
    "no-such-program {seed} {out}", "x" * 300 + " {seed} {out}",
)  # fmt: skip
"""Values of options and arguments that nobody means."""

DOCUMENTED = {0, 1, 2, 3}
VERDICTS = {1: {"check", "compare"}, 3: {"check"}}
PYTHON = re.compile(
    r"Traceback|\b[A-Z]\w*(?:Error|Exception|Warning)\b|NoneType|object at 0x|"
    r"has no attribute|index out of range|positional argument|dtype|ndarray|"
    r"invalid literal|must be str|not subscriptable|unhashable|not iterable|"
    r"codec can't|No module named|_io\."
)
LIGHT_MAY_BE_NEGATIVE = re.compile(r"gradient")  # reconstructed from differences


class TooLong(BaseException):
    """A mutant took more than `LONGEST`."""


@dataclass(frozen=True)
class SpoiledCommand:
    """A command line, and the files that it is given."""

    number: int
    argv: tuple[str, ...]
    files: tuple[tuple[str, bytes], ...] = ()

    def __str__(self) -> str:
        words = " ".join(
            repr(w) if len(w) < 60 else f"{w[:40]!r}..." for w in self.argv
        )
        spoiled_files = ", ".join(name for name, _ in self.files)
        return f"{self.number}: {words}" + (
            f" (spoiled: {spoiled_files})" if self.files else ""
        )


@dataclass(frozen=True)
class MutantOutcome:
    """What became of a mutant."""

    mutant: SpoiledCommand
    code: int
    out: str
    err: str
    seconds: float
    growth: int
    violations: tuple[str, ...] = field(default=())


# ---------------------------------------------------------------- making them


def mutants(
    seed: int, numbers: Sequence[int], good: Path, entries: list[CorpusFile], slow: bool
) -> Iterator[SpoiledCommand]:
    """Mutants of these numbers: each depends on the seed and its number alone."""
    parsers = commands()
    for number in numbers:
        yield _mutant(random.Random(f"{seed} {number}"), number, parsers, good, entries,
                      slow)  # fmt: skip


def commands() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command."""
    (chosen,) = (
        action
        for action in build_parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    return dict(chosen.choices)


def _mutant(
    rng: random.Random,
    number: int,
    parsers: dict[str, argparse.ArgumentParser],
    good: Path,
    entries: list[CorpusFile],
    slow: bool,
) -> SpoiledCommand:
    weights = [1 if name in SLOW or name == "scenes" else 6 for name in parsers]
    command = rng.choices(list(parsers), weights)[0]
    parser = parsers[command]
    given = {action: usual(action) for action in _needed(parser)}
    _choose_method(rng, given)
    files: tuple[tuple[str, bytes], ...] = ()
    if rng.random() < 0.6:
        files = _spoil(rng, given, good, entries)
    hostile = _hostile(rng, parser, (0, 0, 0, 1) if files else (1, 1, 2, 3))
    golden = any(name.startswith("golden/") for name, _ in files)  # read at once
    is_long = command in SLOW and not (slow or golden)
    if is_long and not any(_is_refused(*pair) for pair in hostile.items()):
        # These would run for long: what is asked is refused at once.
        refused = [(a, v) for a in parser._actions for v in VALUES if _is_refused(a, v)]
        hostile |= dict([rng.choice(refused)])
    words = [command]
    for action, value in (given | hostile).items():
        flag = [action.option_strings[-1]] if action.option_strings else []
        words += flag if action.nargs == 0 else [*flag, value]
    for flag, share in (("--json", 0.3), ("--lenient", 0.7), ("--png", 0.3)):
        if rng.random() < share and flag in parser._option_string_actions:
            words.append(flag)
    if rng.random() < 0.05:
        words.insert(rng.randrange(len(words) + 1), rng.choice(VALUES))
    return SpoiledCommand(number, tuple(words), files)


def _choose_method(rng: random.Random, given: dict[argparse.Action, str]) -> None:
    """Any method in turn, without the counts that it does not take."""
    place = next((action for action in given if action.metavar == "M"), None)
    if place is None or not place.required:
        return
    given[place], counts = rng.choice(_methods())
    for action in [a for a in given if a.dest in ("frames", "spp")]:
        if action.dest not in counts:
            del given[action]


@cache
def _methods() -> list[tuple[str, set[str]]]:
    """All methods, and which counts each takes."""
    return [(name, set(method_named(name).counts)) for name in method_names()]


def _needed(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    """What must be given, and what keeps the run small."""
    return [
        action
        for action in parser._actions
        if action.required
        or not action.option_strings
        or SMALL.keys() & set(action.option_strings)
    ]


def usual(action: argparse.Action) -> str:
    """A good value of an argument, and a small one."""
    flag = action.option_strings[-1] if action.option_strings else ""
    candidates = (*SMALL.get(flag, ()), _named(action))
    candidates += tuple(map(str, action.choices or ()))
    return next((v for v in candidates if not _is_refused(action, v)), candidates[0])


def _named(action: argparse.Action) -> str:
    return USUAL.get(action.dest) or USUAL.get(str(action.metavar), "x")


@cache
def _is_refused(action: argparse.Action, value: str) -> bool:
    if action.choices is not None and value not in map(str, action.choices):
        return True
    if action.type is None or action.type is Path:
        return False
    try:
        action.type(value)
    except Exception:  # of any converter
        return True
    return False


def _hostile(
    rng: random.Random, parser: argparse.ArgumentParser, counts: tuple[int, ...]
) -> dict[argparse.Action, str]:
    actions = [a for a in parser._actions if a.dest != "help"]
    chosen = rng.sample(actions, min(len(actions), rng.choice(counts)))
    return {action: rng.choice(VALUES) for action in chosen}


def _spoil(
    rng: random.Random,
    given: dict[argparse.Action, str],
    good: Path,
    entries: list[CorpusFile],
) -> tuple[tuple[str, bytes], ...]:
    """Give a spoiled file in the place of a good one."""
    kinds = {"SCENE": ("scene",), "A.exr": ("picture",), "B.exr": ("picture",),
             "RUN.exr": ("picture",), "BACKEND": ("python", "golden")}  # fmt: skip
    places = [action for action in given if action.metavar in kinds]
    if not places or not entries:
        return ()
    place = rng.choice(places)
    entry = rng.choice([e for e in entries if e.kind in kinds[str(place.metavar)]])
    given[place] = entry.name
    names = [entry.name, *entry.beside]
    if entry.kind == "golden":
        inside = [p for p in (good / entry.name).rglob("*") if p.is_file()]
        names = [str(p.relative_to(good)) for p in inside]
        bad = rng.choice(["golden/manifest.json"] * 2 + names)
    else:
        bad = rng.choice([entry.name] * 2 + names)
    contents = {name: (good / name).read_bytes() for name in names}
    contents[bad] = spoiled(contents[bad], rng)
    return tuple(contents.items())


# ---------------------------------------------------------------- running them


def run(
    mutant: SpoiledCommand,
    box: Path,
    command: Callable[[Sequence[str]], int] = main,
    longest: float = LONGEST,
) -> MutantOutcome:
    """Run a mutant in a new folder, and judge it."""
    box.mkdir()
    for name, contents in mutant.files:
        path = box / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(contents)
    before, home = _resident("VmRSS"), Path.cwd()
    _forget_the_peak()
    late = False

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal late
        late = True
        raise TooLong

    # Through descriptors, so that libraries of others are heard as well.
    with _heard(1) as out, _heard(2) as err, _limited_addresses():
        os.chdir(box)
        previous = signal.signal(signal.SIGALRM, stop)
        start = time.perf_counter()
        try:
            signal.setitimer(signal.ITIMER_REAL, longest)
            code = command(list(mutant.argv))
        except BaseException as error:
            code = 70
            sys.stderr.write(f"Traceback: escaped: {error!r}\n")
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, previous)
            os.chdir(home)
        seconds = time.perf_counter() - start
    growth = max(_resident("VmHWM") - before, 0)
    outcome = MutantOutcome(mutant, code, out.text, err.text, seconds, growth)
    late = late or seconds > longest
    return MutantOutcome(
        mutant, code, out.text, err.text, seconds, growth,
        tuple(violations(outcome, box, late)),
    )  # fmt: skip


def violations(outcome: MutantOutcome, box: Path, late: bool) -> Iterator[str]:
    """All that must not be, of one mutant."""
    name = next((w for w in outcome.mutant.argv if not w.startswith("-")), "")
    code, lines = outcome.code, outcome.err.splitlines()
    if late:
        yield f"it took {outcome.seconds:.1f} s"
    if code not in DOCUMENTED or name not in VERDICTS.get(code, {name}):
        yield f"exit code {code}: {outcome.err[-300:]}"
    if code == 2:
        if outcome.out:
            yield f"an error, and {outcome.out[:80]!r} on stdout"
        if not lines:
            yield "an error without a word"
    if bad := [line for line in lines if not line.startswith("restir: ")]:
        yield f"on stderr: {bad[0][:200]!r}"
    if PYTHON.search(outcome.err):
        yield f"words of Python: {outcome.err[-300:]}"
    for text in (outcome.out, outcome.err):
        if not text.replace("\n", "").isprintable():
            yield f"control characters: {text[-200:]!r}"
    if code == 0 and "--json" in outcome.mutant.argv and "--help" not in outcome.out:
        try:
            json.loads(outcome.out)
        except ValueError:
            yield f"no JSON: {outcome.out[:80]!r}"
    size = sum(len(contents) for _, contents in outcome.mutant.files)
    if outcome.growth > ROOM + TIMES * size:
        yield f"{outcome.growth / 2**20:.0f} MiB taken, of files of {size} bytes"
    yield from _left(box, {name for name, _ in outcome.mutant.files})


def _left(box: Path, given: set[str]) -> Iterator[str]:
    for path in box.rglob("*"):
        name = str(path.relative_to(box))
        if ".part" in path.name or path.name.startswith(".golden"):
            yield f"left behind: {name}"
        if path.suffix == ".exr" and name not in given and path.is_file():
            yield from _light(path, name)


def _light(path: Path, name: str) -> Iterator[str]:
    if "frame" in path.name:  # buffers of a golden folder, not a picture
        return
    image = read_exr(path)
    if np.isnan(image.color).any():
        yield f"NaN in {name}"
    negative = (image.color < 0).any()
    if negative and not LIGHT_MAY_BE_NEGATIVE.search(image.metadata.get("method", "")):
        yield f"negative light in {name}"


class _Heard:
    text = ""


@contextlib.contextmanager
def _heard(number: int) -> Iterator[_Heard]:
    """What is written to a descriptor, and to Python's stream of it."""
    names = {1: "stdout", 2: "stderr"}
    heard, stream = _Heard(), getattr(sys, names[number])
    saved = os.dup(number)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), number)
        ours = io.TextIOWrapper(
            os.fdopen(os.dup(number), "wb"), encoding="utf-8", write_through=True
        )
        setattr(sys, names[number], ours)
        try:
            yield heard
        finally:
            with contextlib.suppress(ValueError, OSError):
                ours.close()
            setattr(sys, names[number], stream)
            os.dup2(saved, number)
            os.close(saved)
            file.seek(0)
            heard.text = file.read().decode("utf-8", "surrogateescape")


@contextlib.contextmanager
def _limited_addresses() -> Iterator[None]:
    """Keep a mutant that takes memory without end from taking the machine's."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    limit = _resident("VmSize") + ADDRESSES
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _resident(word: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(word + ":"):
            return int(line.split()[1]) * 1024
    raise RuntimeError(word)


def _forget_the_peak() -> None:
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


# ---------------------------------------------------------------- by hand


def run_all(
    seed: int,
    numbers: Sequence[int],
    folder: Path,
    slow: bool,
    tell: Callable[[MutantOutcome], None] = lambda outcome: None,
) -> list[MutantOutcome]:
    """Make, run and judge mutants; first once what is good, so that all is imported."""
    good = folder / "good"
    entries = write_corpus(good, find_spec("mitsuba") is not None)
    outcomes = []
    _warm_up(entries, folder)
    for mutant in mutants(seed, numbers, good, entries, slow):
        box = folder / f"box-{mutant.number}"
        outcomes.append(run(mutant, box))
        shutil.rmtree(box, ignore_errors=True)
        tell(outcomes[-1])
    return outcomes


def _warm_up(entries: list[CorpusFile], folder: Path) -> None:
    """Run what is good: modules that come with it are nobody's growth."""
    small = ("--size", "4x4", "--out", "x.exr")
    lines = [("compare", "../good/ours.exr", "../good/restir.exr")]
    lines += [
        ("render", f"../good/{e.name}", "--method", "path", "--spp", "1", "--lenient",
         "--light", "full", *small)
        for e in entries if e.kind == "scene"
    ]  # fmt: skip
    for number, line in enumerate(lines):
        outcome = run(
            SpoiledCommand(-number, line), folder / f"warm-{number}", longest=120
        )
        assert outcome.code == 0, f"{line}: {outcome.err}"


def summary(outcomes: list[MutantOutcome]) -> str:
    """Counts, the slowest, the largest, and every violation."""
    codes = Counter(outcome.code for outcome in outcomes)
    slowest = sorted(outcomes, key=lambda o: -o.seconds)[:5]
    largest = sorted(outcomes, key=lambda o: -o.growth)[:5]
    kinds = Counter(next(iter(o.mutant.argv), "") for o in outcomes)
    lines = [f"{len(outcomes)} mutants; exit codes "
             + ", ".join(f"{code}: {codes[code]}" for code in sorted(codes)),
             "commands: " + ", ".join(f"{name[:12]!r} {kinds[name]}" for name in kinds
                                      if name in COMMANDS),
             *(f"{o.seconds:6.2f} s    {o.mutant}" for o in slowest),
             *(f"{o.growth / 2**20:6.0f} MiB  {o.mutant}" for o in largest),
             *(f"VIOLATION {violation}\n    of {o.mutant}" for o in outcomes
               for violation in o.violations)]  # fmt: skip
    return "\n".join(lines)


def by_hand() -> int:
    """Run a range of mutants, and print what became of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="number of the first one")
    parser.add_argument("--slow", action="store_true", help="run slow commands in full")
    given = parser.parse_args()
    warnings.simplefilter("error")

    def tell(outcome: MutantOutcome) -> None:
        for violation in outcome.violations:
            print(f"VIOLATION {violation}\n    of {outcome.mutant}", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        numbers = range(given.first, given.first + given.count)
        outcomes = run_all(given.seed, numbers, Path(folder), given.slow, tell)
    print(summary(outcomes))
    return int(any(outcome.violations for outcome in outcomes))


if __name__ == "__main__":
    sys.exit(by_hand())
