"""The text of a Mitsuba scene, looked at before Mitsuba reads it.

Mitsuba's parser opens what `include`, `path` and `spectrum` name, and it crashes on
deep nests.  So each of these files is found and read here first.
"""

from pathlib import Path
from typing import Any
from xml.parsers import expat
from xml.parsers.expat.errors import messages

from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.system.errors import UsageError

DEEPEST = 64
"""Elements inside each other; real scenes have less than ten."""
MOST_INCLUDED = 256
"""Files of one scene, one that is included twice counted twice."""


def check_source(ledger: Ledger) -> None:
    """Refuse a scene whose XML, or any that it includes, may not be read.

    Raises UsageError: not XML, nested too deeply, or with a file outside the scene's
    folder.
    """
    _Source(ledger).scan(ledger.path, ledger.contents())


class _Source:
    """The files of a scene, and the folders in which it looks for more."""

    def __init__(self, ledger: Ledger) -> None:
        self.ledger = ledger
        self.folders: list[Path] = []
        self.count = 0

    def scan(self, path: Path, contents: bytes, around: tuple[Path, ...] = ()) -> None:
        self.count += 1
        if self.count > MOST_INCLUDED:
            self.ledger.stop(f"it includes more than {MOST_INCLUDED} files")
        parser = expat.ParserCreate()
        depth = 0

        def start(tag: str, attributes: dict[str, str]) -> None:
            nonlocal depth
            depth += 1
            if depth > DEEPEST:
                self.refuse(path, f"elements are nested more than {DEEPEST} deep")
            if tag == "include":
                name = attributes.get("filename", "")
                self.include(path, name, (*around, path))
            elif tag == "path":
                self.search(path, attributes.get("value", ""))
            elif tag == "spectrum" and "filename" in attributes:
                for file in self.candidates(path, attributes["filename"]):
                    self.ledger.read(str(file))

        def end(_tag: str) -> None:
            nonlocal depth
            depth -= 1

        def declare(_version: str, encoding: str | None, _standalone: int) -> None:
            if encoding and encoding.lower() not in ("utf-8", "utf8", "us-ascii"):
                self.refuse(path, f"its encoding is {encoding}; UTF-8 can be read")

        def define(*_entity: Any) -> None:
            self.refuse(path, "it defines entities, which Mitsuba does not know")

        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.XmlDeclHandler = declare
        parser.EntityDeclHandler = define
        try:
            parser.Parse(contents, True)
        except expat.ExpatError as error:
            self.refuse(
                path,
                f"not a valid Mitsuba scene: line {error.lineno}, column"
                f" {error.offset + 1}: {messages.get(error.code, 'not XML')}",
            )

    def include(self, path: Path, name: str, around: tuple[Path, ...]) -> None:
        for file in self.candidates(path, name):
            if any(file.resolve() == outer.resolve() for outer in around):
                self.refuse(path, f'"{name}" includes itself')
            self.scan(file, self.ledger.read(str(file)), around)

    def search(self, path: Path, name: str) -> None:
        """Remember a folder; Mitsuba looks into the last one first."""
        for folder in self.candidates(path, name):
            self.folders.append(folder)

    def candidates(self, path: Path, name: str) -> list[Path]:
        """Whatever exists under a name, beside the file or where the scene looks."""
        if "$" in name:
            self.refuse(path, f'the file name "{name}" is made of parameters')
        found: list[Path] = []
        refused = ""
        for folder in (path.parent, self.ledger.path.parent, *self.folders):
            file = (folder / name).absolute()
            try:
                self.ledger.locate(str(file))
            except UsageError as error:
                refused = str(error).replace(str(file), name)
                if file.exists():
                    self.refuse(path, refused)
            else:
                if file.exists() and file not in found:
                    found.append(file)
        if refused and not found:
            self.refuse(path, refused)
        return found

    def refuse(self, path: Path, problem: str) -> None:
        where = "" if path == self.ledger.path else f'in "{path.name}": '
        self.ledger.stop(f"{where}{problem}")
