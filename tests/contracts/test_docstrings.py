"""What docstrings of public functions tell: shapes, units, errors, and the source.

That there is a docstring, with its sections, is a rule of `test_house.py`.
"""

import ast
import re
from pkgutil import resolve_name

from tests.contracts.test_house import argument_names, public_definitions, section
from tests.contracts.traceability import ROOT, entries

FOLDERS = ("reference", "extensions", "hashgrid", "gradient_domain")
MODULES = sorted(p for folder in FOLDERS for p in (ROOT / folder).rglob("*.py"))

ARRAYS = re.compile(
    r"^(Scalars|Vec3s|Masks|Indices|UInts|Floats|Colors|Bytes|Numbers|Keys4|"
    r"NDArray\[.*\])( \| None)?$"
)
SHAPE = re.compile(r"\([^)]*\)|array|scalar|number")
UNITS = {
    "depth": "m", "distance": "m", "position": "m", "radiance": "W", "pdf": "1/sr",
    "depth_a": "m", "depth_b": "m", "x_from": "m", "x_to": "m", "x_sample": "m",
    "jacobian": "sr/sr",
}  # fmt: skip
"""Of arrays whose name says what they are, in the packages' passes and kernels."""


def functions(path):
    """Public functions and methods of a module with their docstrings."""
    tree = ast.parse(path.read_text("utf-8"))
    for name, node, in_protocol in public_definitions(tree.body):
        docstring = ast.get_docstring(node)
        if isinstance(node, ast.FunctionDef) and docstring and not in_protocol:
            yield name, node, docstring


def headings(text):
    """Name of each parameter: its type line."""
    found = {}
    for names, _, kind in re.findall(r"^(\S.*?)( : (.*))?$", text or "", re.MULTILINE):
        for name in names.split(","):
            found[name.strip(" *")] = kind
    return found


def annotated(node):
    """Arguments that are arrays."""
    args = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
    return [
        a.arg
        for a in args
        if a.arg in argument_names(node)
        and a.annotation is not None
        and ARRAYS.match(ast.unparse(a.annotation))
    ]


def raised(node):
    """Errors that leave a function by its own `raise`, but for broken promises."""
    names = {
        ast.unparse(e.func if isinstance(e, ast.Call) else e).split(".")[-1]
        for e in leaving(node.body)
    }
    return {n for n in names if n[:1].isupper()} - {"AssertionError", "StopIteration"}


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


def faults(path):
    """What docstrings of a module leave out, a line each."""
    for name, node, text in functions(path):
        kinds = headings(section(text, "Parameters"))
        for argument in annotated(node):
            if not SHAPE.search(kinds.get(argument, "")):
                yield f"{name}: {argument} has no shape"
            unit = UNITS.get(argument)
            if unit and unit not in kinds.get(argument, ""):
                yield f"{name}: {argument} has no unit, {unit}"
        result = ast.unparse(node.returns) if node.returns else ""
        told = section(text, "Returns")
        if ARRAYS.match(result) and told is not None and not SHAPE.search(told):
            yield f"{name}: what it returns has no shape"
        missing = raised(node) - set(headings(section(text, "Raises")))
        if argument_names(node) and missing:
            yield f"{name}: raises {', '.join(sorted(missing))} and does not say so"


def test_docstrings_tell_shapes_units_and_errors():
    told = [f"{p.relative_to(ROOT)}: {f}" for p in MODULES for f in faults(p)]
    assert told == []


def test_control_what_is_left_out_is_told(tmp_path):
    path = tmp_path / "planted.py"
    path.write_text('''
def f(position: Vec3s, n: Scalars, k: int) -> Scalars:
    """Do it.

    Parameters
    ----------
    position : (N, 3)
        Points.
    n : float
        Number.
    k : int
        Other.

    Returns
    -------
    float
        It.
    """
    if k:
        raise ValueError("k")
''')
    assert list(faults(path)) == [
        "f: position has no unit, m",
        "f: n has no shape",
        "f: what it returns has no shape",
        "f: raises ValueError and does not say so",
    ]


def cites(text):
    """Whether a docstring names a source, [Key] or [Key, Eq. 1]."""
    return re.search(r"\[[A-Z][a-z]+\d\d[,;\]]", text) is not None


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
