"""What a reader has to open: files and functions that one default frame enters.

    python -m tests.benchmarks.trace_frame [--list] [NAME ...]
    python -m tests.benchmarks.trace_frame --statements [FOLDER]

A name is a method, or a function as ``method/module:name``, for which the same is
counted between its call and its return in a frame of that method.  By default all
methods, and `FUNCTIONS`.

The frame is the third of the Cornell box at 16 x 16 pixels, two bounces, the method's
own settings, one band.  Three numbers of files and of functions:

* ``all``: the packages of the project, whole;
* ``without kernels``: less what lies under every method (`KERNELS`): scenes, rays,
  materials, arrays, records, random numbers, and the shell that shows a frame;
* ``own``: of these the files outside of ``reference``.

Functions, methods and properties count, also inner ones; comprehensions, lambdas and
what dataclasses generate do not.

With ``--statements``: how many statements inside of the functions of a folder run up to
such a frame of ``restir-gi-unbiased``; of ``reference/passes`` by default.
"""

import ast
import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from restir_gi.reference.methods.discovery import method_named, method_names
from restir_gi.reference.methods.method import Job, Method
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.passes.gbuffer import visible_points
from restir_gi.reference.scene.catalogue.registry import find_scene
from restir_gi.reference.scene.validation import validate
from restir_gi.reference.transport.world import build_world

PREFIX = "restir_gi."
"""Of all modules; left out where they are named here."""

KERNELS = {
    "scene", "rays", "caster", "sampling", "frames", "tables", "images",
    "arrays", "records", "rng", "methods",
}  # fmt: skip
"""Names of folders and files, wherever they lie."""

FUNCTIONS = (
    "restir-gi-unbiased/reference.passes.initial:initial_samples",
    "restir-gi-unbiased/reference.passes.temporal:temporal_resampling",
    "restir-gi-unbiased/reference.passes.spatial:spatial_resampling",
    "world-reservoirs/hashgrid.grid:insert",
    "world-reservoirs/hashgrid.grid:look_up",
    "world-reservoirs/hashgrid.world_reservoirs:visit",
    "regir-gi/hashgrid.regir_gi:store",
    "regir-gi/hashgrid.regir_gi:resample_bounce",
    "regir-gi/hashgrid.regir_gi:reconnect",
    "regir-gi/extensions.shifting:Shift.__call__",
)
SIZE, BEFORE = 16, 2

Entered = set[tuple[str, str, int]]
"""Module, qualified name, and first line."""


@dataclass
class Tracer:
    """Follows calls, everywhere or within one function.

    Attributes
    ----------
    within : (str, str) or None
        Module and qualified name.
    entered : set
        What was entered.
    """

    within: tuple[str, str] | None = None
    entered: Entered = field(default_factory=set)
    _depth: int = 0

    def __call__(self, frame: FrameType, event: str, arg: Any) -> None:
        """Follow one event, for `sys.setprofile`."""
        if event not in ("call", "return"):
            return
        name, code = frame.f_globals.get("__name__", ""), frame.f_code
        module = name.removeprefix(PREFIX)
        here = (module, code.co_qualname) == self.within
        if event == "call":
            self._depth += here
            if (self.within is None or self._depth) and counts(name, code):
                self.entered.add((module, code.co_qualname, code.co_firstlineno))
        else:
            self._depth -= here


def counts(module: str, code: CodeType) -> bool:
    """Whether a function is one of ours, and has a name."""
    ours = module.startswith(PREFIX) and code.co_filename[:1] != "<"
    return ours and not code.co_name.startswith("<")


@contextmanager
def profiled(tracer: Tracer) -> Iterator[None]:
    """Trace while the block runs."""
    sys.setprofile(tracer)
    try:
        yield
    finally:
        sys.setprofile(None)


def frames_of(method: Method) -> Iterator[Any]:
    """Frames as they are shown, without end."""
    scene = find_scene("cornell-box")
    camera = replace(scene.camera, width=SIZE, height=SIZE)
    job = Job(
        world=build_world(validate(replace(scene, camera=camera))),
        light="indirect",
        bounces=2,
        seed=0,
        counts=dict(method.counts),
        settings=method.settings,
        aovs=(),
        schedule=Schedule(),
        animation=None,
    )
    assert method.frames is not None
    return iter(method.frames(job))


def entered(name: str) -> Entered:
    """What one default frame of a method enters, or one function of it."""
    method, _, function = name.partition("/")
    module, _, qualified = function.partition(":")
    frames = frames_of(method_named(method))
    list(islice(frames, BEFORE))
    tracer = Tracer((module, qualified) if function else None)
    with profiled(tracer):
        next(frames)
    return tracer.entered


def is_kernel(module: str) -> bool:
    """Whether a module lies under every method."""
    return not KERNELS.isdisjoint(module.split("."))


def views(found: Entered) -> dict[str, Entered]:
    """All, without kernels, and own."""
    above = {entry for entry in found if not is_kernel(entry[0])}
    own = {entry for entry in above if entry[0].split(".")[0] != "reference"}
    return {"all": found, "without kernels": above, "own": own}


def count(found: Entered) -> str:
    """Functions, and the files in which they are."""
    return f"{len(found)} in {len({module for module, _, _ in found})}"


def statements(path: Path) -> set[int]:
    """First lines of the statements inside of the functions of a file."""
    tree = ast.parse(path.read_text("utf-8"))
    found = set()
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for node in ast.walk(function):
                told = isinstance(node, ast.Expr) and isinstance(
                    node.value, ast.Constant
                )
                if isinstance(node, ast.stmt) and node is not function and not told:
                    found.add(node.lineno)
    return found


def lines_run(folder: Path) -> dict[Path, set[int]]:
    """Lines of a folder's files that run in the default frames up to the third."""
    frames = frames_of(method_named("restir-gi-unbiased"))
    run: dict[Path, set[int]] = {path: set() for path in sorted(folder.rglob("*.py"))}

    def follow(frame: FrameType, event: str, arg: Any) -> Any:
        lines = run.get(Path(frame.f_code.co_filename))
        if lines is None:
            return None
        lines.add(frame.f_lineno)
        return follow

    before = sys.gettrace()
    sys.settrace(follow)
    try:
        list(islice(frames, BEFORE + 1))
    finally:
        sys.settrace(before)
    return run


def print_statements(folder: Path) -> None:
    """Print a line a file, and the sum."""
    total = ran = 0
    for path, lines in lines_run(folder).items():
        there = statements(path)
        total, ran = total + len(there), ran + len(there & lines)
        print(f"{path.name:24}{len(there & lines):5} of {len(there)}")
    print(f"{'statements that run':24}{ran:5} of {total}: {ran / total:.0%}")


def main(words: list[str]) -> None:
    """Print a line a name."""
    parser = ArgumentParser(prog="trace_frame", description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--list", action="store_true", help="name the files")
    parser.add_argument("--statements", nargs="?", const="", metavar="FOLDER")
    given = parser.parse_args(words)
    if given.statements is not None:
        default = Path(visible_points.__code__.co_filename).parent
        print_statements(
            Path(given.statements).resolve() if given.statements else default
        )
        return
    names = given.names or [
        *(n for n in method_names() if method_named(n).frames is not None),
        *FUNCTIONS,
    ]
    print(f"{'functions in files':52}" + "".join(f"{v:>18}" for v in views(set())))
    for name in names:
        found = views(entered(name))
        columns = (f"{count(part):>18}" for part in found.values())
        print(f"{name:52}" + "".join(columns))
        if given.list:
            for module in sorted({module for module, _, _ in found["without kernels"]}):
                print("   ", module)


if __name__ == "__main__":
    main(sys.argv[1:])
