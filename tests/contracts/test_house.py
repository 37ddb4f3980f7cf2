"""The rules of the house that a machine can check, each beside a planted violation."""

import ast
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path
from textwrap import dedent

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("reference", "extensions", "hashgrid", "gradient_domain", "docs/figures")
MODULES = sorted(path for name in PACKAGES for path in (ROOT / name).rglob("*.py"))
BIBLIOGRAPHY = ROOT / "docs" / "reference" / "references.md"
EMBREE_FILE = ROOT / "reference" / "transport" / "rays.py"

Function = ast.FunctionDef | ast.AsyncFunctionDef

every_module = pytest.mark.parametrize(
    "path", MODULES, ids=lambda path: path.relative_to(ROOT).as_posix()
)


@pytest.fixture
def plant(tmp_path):
    """Write a small module and return its path."""

    def write(source):
        path = tmp_path / "planted.py"
        path.write_text(dedent(source).lstrip("\n"), encoding="utf-8")
        return path

    return write


# ---------------------------------------------------------------- citations

KEY = r"[A-Z][A-Za-z]+(?:\d\d[a-z]?|ND)"


def citations(path: Path) -> set[str]:
    """Keys cited in a module's strings and comments: [Key], [Key, Eq. 1; Other]."""
    with path.open("rb") as file:
        texts = [
            token.string
            for token in tokenize.tokenize(file.readline)
            if token.type in (tokenize.STRING, tokenize.COMMENT)
        ]
    brackets = re.findall(r"\[([^\[\]]+)\]", "\n".join(texts))
    parts = [part for bracket in brackets for part in bracket.split(";")]
    matches = [re.match(rf"\s*({KEY})\s*(,|$)", part) for part in parts]
    return {match[1] for match in matches if match}


def bibliography() -> set[str]:
    """Keys that the bibliography defines, each a line of its own: [Key]."""
    text = BIBLIOGRAPHY.read_text(encoding="utf-8")
    return set(re.findall(rf"^\[({KEY})\]$", text, re.MULTILINE))


@every_module
def test_every_citation_stands_in_the_bibliography(path):
    assert citations(path) <= bibliography()


def test_control_an_unknown_citation_is_found(plant):
    path = plant('''
        """A module; see [Nobody99, Eq. 3; Ouyang21] and [0, 1), not [N, 3]."""
        x = 1  # [Noone98a]
    ''')
    assert citations(path) == {"Nobody99", "Ouyang21", "Noone98a"}
    assert citations(path) - bibliography() == {"Nobody99", "Noone98a"}


# ---------------------------------------------------------------- docstrings


def is_protocol(node: ast.ClassDef) -> bool:
    """Whether a class is written down as derived from Protocol."""
    bases = [ast.unparse(base).partition("[")[0] for base in node.bases]
    return any(base.rpartition(".")[2] == "Protocol" for base in bases)


def public_definitions(
    body: list[ast.stmt], prefix: str = "", in_protocol: bool = False
) -> Iterator[tuple[str, Function | ast.ClassDef, bool]]:
    """Public functions, classes and methods: name, node, and whether in a Protocol."""
    for node in body:
        if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
            name = prefix + node.name
            yield name, node, in_protocol
            if isinstance(node, ast.ClassDef):
                yield from public_definitions(node.body, f"{name}.", is_protocol(node))


def section(docstring: str, title: str) -> str | None:
    """Body of a numpydoc section, None where there is no such heading."""
    underlined = re.split(r"^(\w[\w ]*)\n-{3,}$", docstring, flags=re.MULTILINE)
    return dict(zip(underlined[1::2], underlined[2::2], strict=True)).get(title)


def faults_of_docstrings(path: Path) -> list[str]:
    """Public names of a module that lack a docstring.

    What a docstring has to say is a rule of `test_docstrings.py`.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    faults = [] if ast.get_docstring(tree) else ["the module has no docstring"]
    faults += [
        f"{name} has no docstring"
        for name, node, _ in public_definitions(tree.body)
        if ast.get_docstring(node) is None
    ]
    return sorted(faults)


@every_module
def test_every_public_name_is_documented(path):
    if path.name != "__main__.py":
        assert faults_of_docstrings(path) == []


def test_control_each_gap_in_the_docstrings_is_found(plant):
    path = plant('''
        import math

        def _private(x): pass

        def bare(): pass

        def documented(x):
            """Twice x."""

        class Shape:
            def area(self): pass

        class Method(Protocol[T]):
            """Announce."""
            def stop(self, x): pass
    ''')
    assert faults_of_docstrings(path) == [
        "Method.stop has no docstring",
        "Shape has no docstring",
        "Shape.area has no docstring",
        "bare has no docstring",
        "the module has no docstring",
    ]


# ---------------------------------------------------------------- Embree


def imports(path: Path) -> set[str]:
    """Top-level names of everything that a module imports, wherever it does so."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names.append(node.module or "")
    return {name.split(".")[0] for name in names}


@every_module
def test_only_rays_imports_embree(path):
    assert path == EMBREE_FILE or "embreex" not in imports(path)


@pytest.mark.parametrize(
    "statement", ["import embreex", "import embreex.mesh", "from embreex import mesh"]
)
def test_control_an_import_of_embree_is_found(plant, statement):
    path = plant(f"def late():\n    {statement}\n")
    assert "embreex" in imports(path)
