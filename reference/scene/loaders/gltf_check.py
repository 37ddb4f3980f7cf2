"""The JSON of a glTF file against the table of words, before anything else is read."""

import re
from functools import cached_property
from typing import Any

from restir_gi.reference.scene.loaders.gltf_forms import Many, One, fault, shown
from restir_gi.reference.scene.loaders.gltf_words import WORDS, GltfWord
from restir_gi.reference.scene.loaders.ledger import Ledger
from restir_gi.reference.scene.loaders.words import Use

TABLE = {(word.element, word.name): word for word in WORDS}
ELEMENTS = {word.element for word in WORDS}


def check_words(tree: dict[str, Any], ledger: Ledger) -> None:
    """Hold every word of a file against the table.

    Afterwards every word that a reader finds has a value of its form, and every index
    an element.

    Raises UsageError: a value is not what its word needs; or, with all that is refused
    so far, the file uses what cannot be replaced either.

    Parameters
    ----------
    ledger : Ledger; takes notes, and what a strict loader refuses
    """
    check = _Check(tree, ledger)
    check.object("file", tree, "the file")
    check.extensions_by_name()


def replace_word(
    ledger: Ledger, element: str, name: str, where: str, problem: str
) -> None:
    """Treat a word as its row of the table says: replaced, or refused.

    Parameters
    ----------
    element, name : str; row of the table that a reader judges
    where : str; 'material "wall"'
    problem : str; what is not modelled
    """
    ledger.replace(f"{where}: {problem}", TABLE[element, name].remark)


def named(element: str, entry: dict[str, Any], index: int) -> str:
    """An element as messages call it: by its name, or else by its number.

    'material "wall"' or 'material 3'.

    Parameters
    ----------
    element : str; "material"
    """
    name = entry.get("name")
    if not isinstance(name, str) or not name:
        return f"{element} {index}"
    return f"{element} {shown(name)}"


class _Check:
    """One pass over a file.

    Names of extensions are gathered on the way, and judged at the end.  Materials that
    nothing wears must be well formed, but what they are made of does not matter.
    """

    def __init__(self, tree: dict[str, Any], ledger: Ledger) -> None:
        self.tree = tree
        self.ledger = ledger
        self.met: dict[str, None] = {}
        self.worn = True

    def replace(self, problem: str, instead: str) -> None:
        if self.worn:
            self.ledger.replace(problem, instead)

    def object(self, element: str, entry: dict[str, Any], where: str) -> None:
        # Materials come after the meshes that wear them.
        for key in sorted(entry, key=lambda key: key == "materials"):
            value = entry[key]
            if key == "extensions":
                self.extensions(value, where)
            elif key != "extras":
                self.word(element, key, value, where)
        for word in WORDS:
            if word.needed and word.element == element and word.name not in entry:
                self.ledger.stop(f'{where} has no "{word.name}", which glTF needs')

    def word(self, element: str, key: str, value: Any, where: str) -> None:
        word = _row(element, key)
        if word is None:
            problem = f"{where}: glTF 2.0 has no word {shown(key)} here"
            self.replace(problem, "ignored")
            return
        needs = fault(word.form, value, self.tree)
        if needs is not None:
            problem = f"{key} is {shown(value)}; it must be {needs}"
            self.ledger.stop(f"{where}: {problem}")
        at_once = word.use is Use.REPLACED and not word.judged
        if at_once and value not in word.neutral:
            self.replace(f"{where}: {key} is not modelled", word.remark)
        if isinstance(word.form, One):
            self.object(word.form.element, value, f"{where}, {key}")
        if isinstance(word.form, Many):
            for i, entry in enumerate(value):
                if word.form.element == "material":
                    self.worn = i in self.materials
                inner = named(word.form.element, entry, i)
                is_part = element not in ("file", "KHR_lights_punctual")
                inner = f"{where}, {inner}" if is_part else inner
                self.object(word.form.element, entry, inner)
            self.worn = True

    @cached_property
    def materials(self) -> set[int]:
        """Those that some mesh wears."""
        meshes = self.tree.get("meshes", [])
        primitives = [each for mesh in meshes for each in mesh["primitives"]]
        return {each["material"] for each in primitives if "material" in each}

    def extensions(self, value: Any, where: str) -> None:
        if not isinstance(value, dict):
            self.ledger.stop(f"{where}: extensions is {shown(value)}, no object")
        for name, entry in value.items():
            if self.worn:
                self.met[name] = None
            word = TABLE.get(("extension", name))
            if word is not None and name in ELEMENTS:
                if not isinstance(entry, dict):
                    self.ledger.stop(f"{where}: {name} is {shown(entry)}, no object")
                self.object(name, entry, f"{where}, {name}")
            elif word is not None and word.use is Use.REPLACED:
                self.replace(f"{where}: {name} is not modelled", word.remark)

    def extensions_by_name(self) -> None:
        required = self.tree.get("extensionsRequired", [])
        used = self.tree.get("extensionsUsed", [])
        hopeless = False
        for name in dict.fromkeys([*required, *used, *self.met]):
            word = TABLE.get(("extension", name))
            if word is None:
                if name in required:
                    problem = f"the file requires {shown(name)}, which is unknown"
                    self.ledger.refuse(f"{problem}; save it without")
                    hopeless = True
                else:
                    problem = f"the file uses {shown(name)}, which is unknown"
                    self.ledger.replace(problem, "ignored")
            elif word.use is Use.REFUSED:
                verb = "requires" if name in required else "uses"
                problem = f"the file {verb} {name}, which is not modelled"
                self.ledger.refuse(f"{problem}; {word.remark}")
                hopeless = True
            elif word.use is Use.HARMLESS:
                self.ledger.note(f"The extension {name} is ignored: {word.remark}")
        if hopeless:
            self.ledger.settle()


def _row(element: str, key: str) -> GltfWord | None:
    """Row of a word; names of attributes have a number, or are another program's."""
    word = TABLE.get((element, key))
    if word is None and element.endswith("attribute"):
        pattern = "_*" if key.startswith("_") else re.sub(r"_\d+$", "_n", key)
        word = TABLE.get((element, pattern))
    return None if word is not None and " " in word.name else word
