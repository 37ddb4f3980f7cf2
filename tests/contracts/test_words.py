"""One word, one meaning: no retired word of the glossary in names, messages or pages.

The list is the glossary's.  What a word between underscores or capitals is, is decided
here; where a retired word is meant in its plain sense, the place stands in `ALLOWED`
with its reason.
"""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("reference", "extensions", "hashgrid", "gradient_domain")
GLOSSARY = ROOT / "docs" / "reference" / "glossary.md"

SCENE_OF_A_CASE = "a scene's name, which stands in golden folders that people have"

ALLOWED = {
    "excuses": {
        "reference/reports/verdict/plain.py": "a JSON key of the report",
        "reference/reports/verdict/templates/verdict.html": "a JSON key of the report",
    },
    "paint": {
        "extensions/oracle/shifts/cases.py": SCENE_OF_A_CASE,
        "extensions/oracle/shifts/scenes.py": SCENE_OF_A_CASE,
    },
    "rung": {
        "reference/reports/integration/faults.py": "a JSON key of the report",
        "reference/reports/verdict/plain.py": "a JSON key of the report",
        "reference/reports/verdict/table.py": "a JSON key of the report",
        "reference/reports/verdict/templates/verdict.html": "a JSON key of the report",
        "reference/oracle/golden.py": "a JSON key of the manifest",
    },
    "competition": {"CHANGELOG.md": "the name of a class, as it was"},
    "donors": {"CHANGELOG.md": "the name of a module, as it was"},
    "rungs": {"CHANGELOG.md": "the name of a module, as it was"},
    "stage": {"docs/examples/wgsl/backend.py": "WebGPU's word for a shader"},
    "tails": {"reference/oracle/statistics/ranks.py": "of a distribution"},
}
"""Where a retired word may stand, by word and path, and why."""


class Retired(NamedTuple):
    """A row of the glossary: words, and where they must not stand."""

    words: tuple[str, ...]
    in_names: bool
    in_text: bool


class Found(NamedTuple):
    """A retired word, and where it stands."""

    path: str
    line: int
    word: str


def retired(page: str) -> list[Retired]:
    """Rows of the table under "Retired words"."""
    rows = page.partition("## Retired words")[2].split("\n")
    cells = [row.strip("|").split("|") for row in rows if row.startswith("| `")]
    return [
        Retired(
            tuple(re.findall("`([^`]+)`", words)),
            names.strip() == "yes",
            text.strip() == "yes",
        )
        for words, _, names, text in cells
    ]


RETIRED = retired(GLOSSARY.read_text(encoding="utf-8"))
IN_NAMES = {word for row in RETIRED if row.in_names for word in row.words}
IN_TEXT = {word for row in RETIRED if row.in_text for word in row.words}
TEXT = re.compile(rf"(?<![\w-])({'|'.join(sorted(IN_TEXT))})(?![\w-])", re.IGNORECASE)


def parts(name: str) -> list[str]:
    """Words of a name, between underscores and capitals."""
    return [part.lower() for part in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)]


def retired_in_name(name: str) -> list[str]:
    """Retired words of a name."""
    return [word for word in dict.fromkeys((name, *parts(name))) if word in IN_NAMES]


def names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Names that a module gives: of classes, functions, parameters, variables, fields.

    What it imports or reads was named elsewhere.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.attr


def texts(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Strings of a module: docstrings, messages, and what f-strings say."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            for offset, line in enumerate(node.value.split("\n")):
                yield node.lineno + offset, line


def in_module(path: str, source: str) -> Iterator[Found]:
    """Retired words in a module's own name, the names it gives, and its strings."""
    for part in Path(path).with_suffix("").parts:
        yield from (Found(path, 1, word) for word in retired_in_name(part))
    tree = ast.parse(source)
    for line, name in names(tree):
        yield from (Found(path, line, word) for word in retired_in_name(name))
    for line, text in texts(tree):
        yield from (Found(path, line, m[1].lower()) for m in TEXT.finditer(text))


def in_page(path: str, page: str) -> Iterator[Found]:
    """Retired words in the text of a page or template."""
    for line, text in enumerate(page.split("\n"), 1):
        yield from (Found(path, line, m[1].lower()) for m in TEXT.finditer(text))


def sources() -> Iterator[tuple[str, Path]]:
    """All files that are looked at, with their paths from the root."""
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
    for package in PACKAGES:
        found += [*(ROOT / package).rglob("*.py"), *(ROOT / package).rglob("*.html")]
    for suffix in ("md", "rst", "py"):
        found += (ROOT / "docs").rglob(f"*.{suffix}")
    for path in sorted(found):
        name = path.relative_to(ROOT).as_posix()
        if path != GLOSSARY and not {"_build", "generated", "auto_gallery"} & set(
            path.parts
        ):
            yield name, path


def found_in(name: str, text: str) -> list[Found]:
    """Retired words of a file that are not allowed there."""
    look = in_module if name.endswith(".py") else in_page
    return [f for f in look(name, text) if name not in ALLOWED.get(f.word, {})]


# ---------------------------------------------------------------- what is


def test_no_retired_word_is_left():
    found = [
        f"{f.path}:{f.line}: {f.word}"
        for name, path in sources()
        for f in found_in(name, path.read_text(encoding="utf-8"))
    ]
    assert found == []


def test_what_is_allowed_still_has_the_word():
    """The list shrinks: what is done is taken off."""
    files = dict(sources())
    for word, places in ALLOWED.items():
        for path in places:
            text = files[path].read_text(encoding="utf-8")
            look = in_module if path.endswith(".py") else in_page
            assert word in {f.word for f in look(path, text)}, f"{word} in {path}"


def classes() -> dict[str, list[str]]:
    """Paths of the classes of each name, in the packages and their tests."""
    found = defaultdict(list)
    for folder in (*PACKAGES, "tests"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            name = path.relative_to(ROOT).as_posix()
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ClassDef):
                    found[node.name].append(name)
    return found


def test_no_class_name_stands_twice():
    twice = {name: places for name, places in classes().items() if len(places) > 1}
    assert twice == {}


# ---------------------------------------------------------------- controls


@pytest.mark.parametrize(
    ("source", "word"),
    [
        ("def rungs_of(x): ...", "rungs"),
        ("class SceneTheatre: ...", "theatre"),
        ("def f(the_donor): ...", "donor"),
        ("EXCUSE_ALARM = 1e-6", "excuse"),
        ("x.lent = 1", "lent"),
        ("def share_of_choice(): ...", "share_of_choice"),
        ("class Entry: ...", "Entry"),
        ('raise ValueError(f"{x} has other materials than paint")', "paint"),
        ('"""Lights that are met by chance."""', "by chance"),
        ('help = """A line.\n\nWhat a free decision is.\n"""', "free decision"),
    ],
)
def test_control_planted_words_are_found(source, word):
    assert [f.word for f in found_in("planted.py", source)] == [word]


def test_control_module_names_and_pages_are_read():
    assert [f.word for f in found_in("reference/oracle/rungs/a.py", "")] == ["rungs"]
    page = "# Title\n\nThe cheap rungs first.\n"
    assert found_in("docs/a.md", page) == [Found("docs/a.md", 3, "rungs")]


@pytest.mark.parametrize(
    "source",
    [
        "entry = 1",
        "moments = 1",
        "strung = lawful = blended = 1",
        "from restir_gi.reference.passes import taps",
        '"""A bug that is named divided-by-the-donors-target."""',
        '"""At this moment the past stands beside it, free of law."""',
    ],
)
def test_control_plain_words_pass(source):
    assert found_in("planted.py", source) == []


def test_the_glossary_says_what_to_say_instead():
    """Its list is read, and no word of it is defined above it."""
    assert len(RETIRED) > 25
    assert {"rung", "paint", "donor"} <= IN_NAMES & IN_TEXT
    above = GLOSSARY.read_text(encoding="utf-8").partition("## Retired words")[0]
    assert list(in_page("glossary", above)) == []
