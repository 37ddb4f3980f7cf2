"""Commands of the documentation: what stands in its shell blocks and in its prose."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FENCE = re.compile(
    r"^```(?:sh|bash|shell|console)\n(.*?)^```", re.MULTILINE | re.DOTALL
)
PROSE = re.compile(r"`(restir [a-z-]+ [^`.<]*[^`<]*)`")


@dataclass(frozen=True, slots=True)
class DocumentedCommand:
    """One command, as it is printed."""

    page: str
    words: tuple[str, ...]

    @property
    def text(self) -> str:
        """Its words, quoted where a shell wants it."""
        return shlex.join(self.words)

    @property
    def asked(self) -> tuple[str, ...] | None:
        """What the project's own command line is given; else None."""
        return self.words[1:] if Path(self.words[0]).name == "restir" else None


def pages() -> list[Path]:
    """All that is written for people."""
    found = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "tests" / "README.md"]
    built = ROOT / "docs" / "_build"
    return found + [
        page
        for page in sorted((ROOT / "docs").rglob("*"))
        if page.suffix in {".md", ".rst", ".py"} and built not in page.parents
    ]


def commands_in(text: str, page: str = "") -> Iterator[DocumentedCommand]:
    """Commands of the shell blocks of a page, in order."""
    for block in FENCE.findall(text):
        for line in block.replace("\\\n", " ").splitlines():
            # A settings of the environment before a command is no part of it.
            words: list[str] = []
            for word in [*shlex.split(line, comments=True), "&&"]:
                if word != "&&":
                    words.append(word)
                    continue
                while words and re.fullmatch(r"[A-Z_]+=.*", words[0]):
                    del words[0]
                if words:
                    yield DocumentedCommand(page, tuple(words))
                words = []


def in_prose(text: str, page: str = "") -> Iterator[DocumentedCommand]:
    """Commands of the project's own in running text that say more than their name."""
    for found in PROSE.findall(text):
        yield DocumentedCommand(page, tuple(shlex.split(found.replace("\n", " "))))


def documented() -> list[DocumentedCommand]:
    """All commands of all shell blocks."""
    return [
        command
        for page in pages()
        for command in commands_in(page.read_text("utf-8"), str(page.relative_to(ROOT)))
    ]


def mentioned() -> list[DocumentedCommand]:
    """All commands of running text."""
    return [
        command
        for page in pages()
        for command in in_prose(page.read_text("utf-8"), str(page.relative_to(ROOT)))
    ]
