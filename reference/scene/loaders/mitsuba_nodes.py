"""A Mitsuba 3 file as Mitsuba's own parser understands it: a tree of plugins."""

import os
import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from restir_gi.reference.numerics.arrays import Scalars, Vec3s
from restir_gi.reference.scene.loaders.ledger import REMOTE, Ledger
from restir_gi.reference.scene.loaders.mitsuba_source import DEEPEST, check_source
from restir_gi.reference.scene.loaders.mitsuba_words import find, modelled
from restir_gi.reference.scene.loaders.words import Use, Word
from restir_gi.reference.system.errors import UsageError

TYPES = {"ReconstructionFilter": "rfilter", "PhaseFunction": "phase"}
INTERNAL = re.compile(
    r"\[[\w.]+(:\d+)?\] ?"
    r'|At dictionary node "root": failed to instantiate \w+ plugin of type "\w+": '
    r'|Error while loading (?:(?=[^ ]+ \()|XML file "[^"]*": )'
)
"""What Mitsuba's messages say about itself."""
LARGEST = 1e50
VARIANT = "scalar_rgb"  # the one that needs no compiler at run time


@contextmanager
def mitsuba_session() -> Iterator[Any]:
    """Mitsuba in its scalar RGB variant, quiet.

    The variant and the log level belong to the process; what the caller had chosen
    comes back.  A caller who had chosen no variant is left with this one, for Mitsuba
    cannot go back to none.

    Raises UsageError: it is not installed.
    """
    try:
        mi: Any = import_module("mitsuba")
    except ImportError as error:
        raise UsageError(
            "Mitsuba XML is read by the package mitsuba, which is not installed:"
            " pip install 'restir-gi-oracle[mitsuba]'"
        ) from error
    variant = mi.variant()
    mi.set_variant(VARIANT)
    level = mi.log_level()
    mi.set_log_level(mi.LogLevel.Error)
    try:
        yield mi
    finally:
        mi.set_log_level(level)
        if variant is not None:
            mi.set_variant(variant)


@contextmanager
def reading(what: str, ledger: Ledger) -> Iterator[None]:
    """Tell Mitsuba's failure on malformed data without the names of its own parts.

    Raises UsageError in place of whatever Mitsuba raises.

    Parameters
    ----------
    what : str; what it ought to be: "metal of ..."
    """
    with ledger.reading(what):
        try:
            yield
        except RuntimeError as error:
            error.args = (INTERNAL.sub("", str(error)),)
            raise


@dataclass(slots=True, eq=False)
class Node:
    """One plugin of the file.

    Attributes
    ----------
    type : str; "shape", "bsdf", "emitter", ...
    name : str; kind with id, place in the file, or name of what it is in: for messages
    id : str; as in the file, else kind and place
    values : dict; numbers, strings, colours, transforms
    children : dict of str to Node
        Plugins inside; those without a name of their own begin with "_arg".
    folders : list of Path
        Where the files that it names are looked for, the first first.
    """

    type: str
    kind: str
    name: str
    id: str
    values: dict[str, Any]
    children: dict[str, "Node"] = field(default_factory=dict)
    folders: list[Path] = field(default_factory=list)

    def inside(self, type_name: str) -> "list[Node]":
        """Plugins of one type inside this one, in the order of the file.

        Parameters
        ----------
        type_name : str; "bsdf", "emitter", ...
        """
        return [node for node in self.children.values() if node.type == type_name]

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a parameter as Mitsuba parsed it."""
        return self.values.get(key, default)

    def number(self, key: str, default: float, ledger: Ledger) -> float:
        """Value of a parameter that is a number."""
        value = self.values.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            self._refuse_value(key, "a number", ledger)
        return float(value)

    def flag(self, key: str, default: bool, ledger: Ledger) -> bool:
        """Value of a parameter that is true or false."""
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            self._refuse_value(key, "true or false", ledger)
        return value

    def text(self, key: str, default: str, ledger: Ledger) -> str:
        """Value of a parameter that is a string."""
        value = self.values.get(key, default)
        if not isinstance(value, str):
            self._refuse_value(key, "a string", ledger)
        return value

    def point(self, key: str, default: Vec3s, ledger: Ledger) -> Vec3s:
        """Value of a parameter that is a point or a vector.

        Parameters
        ----------
        default : (3,) float64; what it is if the file does not say

        Returns
        -------
        (3,) float64; as in the file
        """
        value = self.values.get(key, default)
        try:
            point = np.array(value, np.float64)
        except (TypeError, ValueError):
            point = np.zeros(0)
        if point.shape != (3,):
            self._refuse_value(key, "three numbers", ledger)
        return point

    def matrix(self, ledger: Ledger, key: str = "to_world") -> Scalars:
        """Transform of a parameter.

        Returns (4, 4) float64; the identity if the file has none.
        """
        transform = self.values.get(key)
        if transform is None:
            return np.eye(4)
        if not hasattr(transform, "matrix"):
            self._refuse_value(key, "a transform", ledger)
        matrix = np.array(transform.matrix, np.float64)
        check_matrix(matrix, f'{self.name}: "{key}"', ledger)
        return matrix

    def file(self, ledger: Ledger) -> Path:
        """The file that it names; a regular file that may be read.

        Raises UsageError: it names none, or one that is missing or may not be read.
        """
        name = self.text("filename", "", ledger).replace("\\", "/")
        if not name:
            raise UsageError("it names no file; it needs a filename")
        if REMOTE.match(name):
            ledger.locate(name)  # which refuses it
        places = [str((folder / name).absolute()) for folder in self.folders]
        # The first that exists, as Mitsuba; else the last, which is the scene's own.
        there = list(filter(os.path.exists, places))
        place = there[0] if there else places[-1]
        try:
            path = ledger.locate(place)
        except UsageError as error:
            raise UsageError(str(error).replace(place, name)) from error
        if not path.exists():
            raise UsageError(f'the file "{name}" is missing')
        if not path.is_file():
            raise UsageError(f'"{name}" is not a regular file')
        return path

    def check_words(self, ledger: Ledger, apart: Collection[str] = ()) -> None:
        """Refuse, or note, what the table of words says is not modelled.

        Parameters
        ----------
        apart : collection of str
            Parameters that are refused by their value alone, elsewhere.
        """
        for key, value in (*self.values.items(), *self.children.items()):
            plugin = value if isinstance(value, Node) else None
            named = plugin is None or plugin.type in ("texture", "volume")
            name = key if plugin is None or named else plugin.type
            word = find(self.kind, name)
            if word.use in (Use.MODELLED, Use.HARMLESS) or name in apart:
                continue
            self.refuse_word(key, word, ledger)

    def refuse_word(self, key: str, word: Word, ledger: Ledger) -> None:
        """Refuse, or note, a parameter or an inner plugin."""
        inner = self.children.get(key)
        what = f'parameter "{key}"' if inner is None else f"{inner.type} {inner.name}"
        ledger.replace(f"{self.name}: its {what} is not modelled", word.remark)

    def is_modelled(self, ledger: Ledger) -> bool:
        """Whether the plugin itself is modelled; if not, it is refused or noted."""
        word = find(self.type, self.kind)
        if word.use is Use.MODELLED:
            return True
        known = f"of {self.type}s, {modelled(self.type)} are"
        ledger.replace(f"{self.name} is not modelled ({known})", word.remark)
        return False

    def _refuse_value(self, key: str, right: str, ledger: Ledger) -> NoReturn:
        value = " ".join(str(self.values[key]).split())
        ledger.stop(f'{self.name}: "{key}" is {value:.60}; it has to be {right}')


def check_matrix(matrix: Scalars, where: str, ledger: Ledger) -> None:
    """Refuse a transform whose determinant may not be computed with.

    Parameters
    ----------
    matrix : (4, 4) float64; the transform
    where : str; what it is of, for the message

    Raises
    ------
    UsageError
        A number is not finite, or beyond `LARGEST`.
    """
    if not (np.abs(matrix) <= LARGEST).all():
        ledger.stop(f"{where} holds numbers beyond {LARGEST:g}")


def parse(mi: Any, ledger: Ledger) -> Node:
    """Tree of a Mitsuba file, defaults, includes and references resolved.

    A plugin that is referred to twice is one node.

    Raises UsageError: not well-formed, or with a reference to nothing.

    Parameters
    ----------
    mi : module; ``mitsuba``, from `mitsuba_session`
    """
    check_source(ledger)
    with reading("Mitsuba scene", ledger), _search_path(mi, ledger) as folders:
        config = mi.parser.ParserConfig(VARIANT)
        state = mi.parser.parse_file(config, str(ledger.path))
        mi.parser.transform_upgrade(config, state)
        mi.parser.transform_resolve(config, state)
        folders += [Path(str(folder)) for folder in mi.file_resolver()]
        nodes = [_node(mi, state, entry, folders) for entry in state.nodes]
        reference = mi.Properties.Type.ResolvedReference
        for node, entry in zip(nodes, state.nodes, strict=True):
            for key in entry.props.keys():  # noqa: SIM118 (no mapping)
                if entry.props.type(key) == reference:
                    node.children[key] = nodes[entry.props[key].index()]
                    del node.values[key]
        for node in nodes[1:]:  # outer ones first
            for inner in node.children.values():
                if inner.id == inner.name:
                    inner.name = f"{inner.kind} in {node.name}"
    _check_nesting(nodes[0], ledger)
    return nodes[0]


def _check_nesting(root: Node, ledger: Ledger) -> None:
    """Refuse plugins that refer to what they are part of, or in too long a chain."""
    reached = {id(root): 0}
    waiting = [root]
    while waiting:
        node = waiting.pop()
        depth = reached[id(node)] + 1
        if depth > DEEPEST:
            ledger.stop(
                f"{node.name} refers to itself, or is nested more than {DEEPEST} deep"
            )
        for inner in node.children.values():
            if reached.get(id(inner), -1) < depth:
                reached[id(inner)] = depth
                waiting.append(inner)


@contextmanager
def _search_path(mi: Any, ledger: Ledger) -> Iterator[list[Path]]:
    """Have Mitsuba look beside the scene alone; afterwards, where it did before."""
    resolver = mi.file_resolver()
    before = [str(folder) for folder in resolver]
    resolver.clear()
    resolver.append(str(ledger.path.parent))
    try:
        yield []
    finally:
        resolver.clear()
        for folder in before:
            resolver.append(folder)


def _node(mi: Any, state: Any, entry: Any, folders: list[Path]) -> Node:
    props = entry.props
    kind_of_plugin = str(entry.type).rpartition(".")[2]
    kind, given = props.plugin_name(), props.id()
    place = mi.parser.file_location(state, entry).rpartition("(")[2].rstrip(")")
    name = f'{kind} "{given}"' if given else f"{kind} at {place}"
    values = {key: props[key] for key in props.keys()}  # noqa: SIM118 (no mapping)
    return Node(
        type=TYPES.get(kind_of_plugin, kind_of_plugin.lower()),
        kind=kind,
        name=name,
        id=given or name,
        values=values,
        folders=folders,
    )
