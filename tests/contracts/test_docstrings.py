"""Docstrings say something, or are one line.

Where there are arrays they tell shapes and units; everywhere the errors, and the source
of what papers say.  Filler is refused: what names and types say already.  That there is
a docstring at all is a rule of `test_house.py`.
"""

import ast
import re
from pkgutil import resolve_name
from textwrap import dedent

import pytest

from tests.contracts.test_house import (
    Function,
    every_module,
    public_definitions,
    section,
)
from tests.contracts.traceability import entries

ARRAY = re.compile(
    r"\b(Scalars|Vec3s|Masks|Indices|UInts|Floats|Colors|Bytes|Codes|Singles|Integers|"
    r"Draw|NDArray)\b"
)
SHAPE = re.compile(r"\([^)]*\)|array|strategy|scalar")
UNITS = {
    "depth": "m", "distance": "m", "position": "m", "radiance": "W", "pdf": "1/sr",
    "depth_a": "m", "depth_b": "m", "x_from": "m", "x_to": "m", "x_sample": "m",
    "jacobian": "sr/sr",
}  # fmt: skip
"""Of arrays whose name says what they are, in the packages' passes and kernels."""

# ---------------------------------------------------------------- what is told


def definitions(path):
    """Public functions and classes of a module that have a docstring."""
    tree = ast.parse(path.read_text("utf-8"))
    for name, node, in_protocol in public_definitions(tree.body):
        if text := ast.get_docstring(node):
            yield name, node, text, in_protocol


def head(text):
    """All that comes before the sections."""
    return re.split(r"^\w[\w ]*\n-{3,}$", text, maxsplit=1, flags=re.MULTILINE)[0]


def told(text, title):
    """Of each name in a section: its type, and what is said of it."""
    found = {}
    for line in (section(text, title) or "").splitlines():
        if line[:1].strip():
            names, _, rest = line.partition(" : ")
            kind, _, said = rest.partition("; ")
            entry = [kind, said]
            found |= {name.strip(" *"): entry for name in names.split(",")}
        elif found:
            entry[1] = f"{entry[1]} {line.strip()}".strip()
    return found


def hints(node):
    """Annotations of the arguments of a function, or of the fields of a class."""
    if isinstance(node, ast.ClassDef):
        fields = [s for s in node.body if isinstance(s, ast.AnnAssign)]
        return {ast.unparse(f.target): ast.unparse(f.annotation) for f in fields}
    arguments = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return {a.arg: ast.unparse(a.annotation) for a in arguments if a.annotation}


def is_array(hint):
    """Whether a type is an array, or several; no function and no mapping of them."""
    other = re.match(r"(dict|Mapping)\[", hint) or "Callable" in hint
    return ARRAY.search(hint) is not None and not other


def missing_shapes(node, text, in_protocol):
    """Arrays that are taken, kept or returned without their shape or unit."""
    if in_protocol:
        return
    entries_of = told(text, "Parameters") | told(text, "Attributes")
    for name, hint in hints(node).items():
        kind, said = entries_of.get(name, ("", head(text)))
        if is_array(hint) and not name.startswith("_"):
            if not SHAPE.search(f"{kind} {said}"):
                yield f"{name} has no shape"
            unit = UNITS.get(name, "")
            if unit not in kind and isinstance(node, Function):
                yield f"{name} has no unit, {unit}"
    result = getattr(node, "returns", None)
    if result and is_array(ast.unparse(result)):
        results = section(text, "Returns") or section(text, "Yields") or head(text)
        if not SHAPE.search(results):
            yield "what it returns has no shape"


def leaving(body):
    """What is raised in statements, outside of inner functions and of `try`."""
    for statement in body:
        if isinstance(statement, ast.Raise) and statement.exc is not None:
            yield statement.exc
        elif isinstance(statement, ast.Try):
            for handler in statement.handlers:
                yield from leaving(handler.body)
        elif not isinstance(statement, ast.FunctionDef | ast.ClassDef):
            for part in ("body", "orelse", "finalbody"):
                yield from leaving(getattr(statement, part, []))


def missing_errors(node, text):
    """Errors that leave a function by its own `raise`, but for broken promises."""
    if not isinstance(node, Function) or not hints(node):
        return
    for error in leaving(node.body):
        raised = ast.unparse(error.func if isinstance(error, ast.Call) else error)
        name = raised.split(".")[-1]
        promised = name in ("AssertionError", "StopIteration") or name[:1].islower()
        if not promised and name not in text:
            yield f"raises {name} and does not say so"


# ---------------------------------------------------------------- filler

FILLER = re.compile(
    r"((of|by|for|in|on|to|with|from|as in|as of) )?((the|this|its|a|an|each|that) )?"
    r"[a-z]+|name of the \w+|any \w+|which \w+|how many|what is [a-z]+|who \w+",
    re.IGNORECASE,
)
TERSE = re.compile(
    r"positive|not negative|finite|inclusive|linear|sorted|validated|unbiased|"
    r"independent|seconds|bytes|grows|in the world|\w",
    re.IGNORECASE,
)
"""What says something in a word or two."""

UNIT = re.compile(r", \(?(m|s|sr|W|1/|pixels|bytes|degrees|radians|half|frames)")


def words(text):
    """Words of a text, without their plural."""
    apart = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", text)
    small = {word.lower().rstrip("s") for word in re.findall(r"[^\W\d_]+", apart)}
    return small - {"the", "a", "an", "of", "it", "to", "and", "in", "i"}


def says_nothing(name, kind, said):
    """Whether an entry of what is no array says what its name and type say."""
    if UNIT.search(kind) or re.search(r"\d", said):
        return False
    said = said.rstrip(".")
    filler = FILLER.fullmatch(said) and not TERSE.fullmatch(said)
    return bool(filler) or words(said) <= words(f"{name} {kind}")


def filler(node, text):
    """Entries that say nothing; of arrays every entry says the shape."""
    types = hints(node)
    for title in ("Parameters", "Attributes"):
        for name, (kind, said) in told(text, title).items():
            array = SHAPE.search(kind) or is_array(types.get(name, ""))
            if not array and says_nothing(name, kind, said):
                yield f"{title}: {name} says nothing"
    for title in ("Returns", "Yields"):
        body = (section(text, title) or "").strip()
        kind, _, said = body.replace("\n", "; ", 1).partition("; ")
        bare = isinstance(node, Function) and not SHAPE.search(kind) and body
        if bare and says_nothing("", kind, said.strip()):
            yield f"{title} says nothing"


# ---------------------------------------------------------------- sources


def cites(text):
    """Whether a docstring names a source, [Key] or [Key, Eq. 1]."""
    return re.search(r"\[[A-Z][a-z]+(\d\d|ND)[,;\]]", text) is not None


def without_a_key(text):
    """Numbers of equations and algorithms that no key stands before."""
    outside = re.sub(r"\[[^\[\]]*\]", "", text)
    numbers = re.findall(r"\b(?:Eqs?|Alg)\. \d+", outside)
    return [f"{number} has no key" for number in numbers]


# ---------------------------------------------------------------- tests


def faults(path):
    """What is wrong with the docstrings of a module, a line each."""
    for name, node, text, in_protocol in definitions(path):
        for fault in (
            *missing_shapes(node, text, in_protocol),
            *missing_errors(node, text),
            *filler(node, text),
            *without_a_key(text),
        ):
            yield f"{name}: {fault}"


@every_module
def test_docstrings_say_something_or_are_one_line(path):
    assert list(faults(path)) == []


def test_control_what_is_left_out_is_told(tmp_path):
    path = tmp_path / "planted.py"
    path.write_text(
        dedent('''
        def f(position: Vec3s, n: Scalars, k: int) -> Scalars:
            """Do it, by Eq. 3 and [Key00, Eq. 4].

            Parameters
            ----------
            position : (N, 3); points
            n : float
            """
            if k:
                raise ValueError("k")

        def one_line(a: Masks) -> list[Masks]:
            """Masks turned over."""

        class Record:
            """Points.

            Attributes
            ----------
            x : (N, 3) float
            """

            x: Vec3s
            pdf: Scalars | None
        ''')
    )
    assert list(faults(path)) == [
        "f: position has no unit, m",
        "f: n has no shape",
        "f: what it returns has no shape",
        "f: raises ValueError and does not say so",
        "f: Eq. 3 has no key",
        "one_line: a has no shape",
        "one_line: what it returns has no shape",
        "Record: pdf has no shape",
    ]


def test_control_filler_is_told(tmp_path):
    path = tmp_path / "planted.py"
    path.write_text(
        dedent('''
        def f(world: World, job: Job, job_name: str, k: int) -> Image:
            """Do it.

            Parameters
            ----------
            world : World
                The scene.
            job : Job; of the run
            job_name : str
                Name of the job.
            k : int

            Returns
            -------
            Image
                The image.
            """

        class Settings:
            """How.

            Attributes
            ----------
            mode : str; which mode
            """

            mode: str
        ''')
    )
    assert list(faults(path)) == [
        "f: Parameters: world says nothing",
        "f: Parameters: job says nothing",
        "f: Parameters: job_name says nothing",
        "f: Parameters: k says nothing",
        "f: Returns says nothing",
        "Settings: Attributes: mode says nothing",
    ]


@pytest.mark.parametrize(
    "docstring",
    [
        "Ratio, (N,) float; 0 where a is 0.",
        """Ratio.

        Parameters
        ----------
        k : int; from 0
        limit : float, m
        path : Path, optional
            By default beside the picture.

        Returns
        -------
        (N,) float
        """,
    ],
)
def test_control_what_says_something_passes(tmp_path, docstring):
    path = tmp_path / "planted.py"
    arguments = "k: int, limit: float, path: Path"
    path.write_text(f'def f({arguments}) -> Scalars:\n    """{docstring}"""\n')
    assert list(faults(path)) == []


def test_what_the_papers_say_is_cited_where_it_is_done():
    """In the very docstring: of the function, or of what makes a class callable."""
    _, rows = entries()
    for paper in rows.values():
        for number, row in paper.items():
            found = resolve_name(row["code"])
            call = found.__call__.__doc__ if isinstance(found, type) else ""
            text = (found.__doc__ or "") + (call or "")
            assert cites(text), (number, row["code"])


def test_control_an_interval_is_no_citation():
    assert cites("As in [Lin22, Eq. 22].")
    assert not cites("A number in [0, 1), (N, 3) of [N]; see Lin22.")
