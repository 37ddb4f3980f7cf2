"""A Mitsuba 3 file as Mitsuba's own parser understands it: a tree of plugins."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from reference.arrays import Scalars
from reference.errors import UsageError
from reference.scene.loaders.ledger import Ledger

VARIANT = "scalar_rgb"  # the one that needs no compiler at run time


@contextmanager
def mitsuba_session() -> Iterator[Any]:
    """Mitsuba in its scalar RGB variant, quiet.

    Yields
    ------
    module
        ``mitsuba``.

    Raises
    ------
    UsageError
        It is not installed.

    Notes
    -----
    The variant and the log level belong to the process; what the caller had chosen
    comes back.  A caller who had chosen no variant is left with this one, for Mitsuba
    cannot go back to none.
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


@dataclass(slots=True, eq=False)
class Node:
    """One plugin of the file.

    Attributes
    ----------
    type : str
        "Shape", "BSDF", "Emitter", ...
    kind : str
        Name of the plugin.
    name : str
        Kind with id, place in the file, or name of what it is in: for messages.
    id : str
        As in the file, else kind and place.
    values : dict
        Numbers, strings, colours, transforms.
    children : dict of str to Node
        Plugins inside; those without a name of their own begin with "_arg".
    unread : set of str
        Parameters that nobody has asked for yet.
    """

    type: str
    kind: str
    name: str
    id: str
    values: dict[str, Any]
    children: dict[str, "Node"] = field(default_factory=dict)
    unread: set[str] = field(default_factory=set)

    def get(self, key: str, default: Any = None) -> Any:
        """Value of a parameter.

        Parameters
        ----------
        key : str
            Name of the parameter.
        default : Any
            What it is if the file does not say.

        Returns
        -------
        Any
            As Mitsuba parsed it.
        """
        self.unread.discard(key)
        return self.values.get(key, default)

    def child(self, key: str) -> "Node | None":
        """Plugin that is the value of a parameter.

        Parameters
        ----------
        key : str
            Name of the parameter.

        Returns
        -------
        Node or None
            ``None`` if the file has none of that name.
        """
        self.unread.discard(key)
        return self.children.get(key)

    def inside(self, type_name: str) -> "list[Node]":
        """Plugins of one type inside this one.

        Parameters
        ----------
        type_name : str
            "BSDF", "Emitter", ...

        Returns
        -------
        list of Node
            In the order of the file.
        """
        found = {k: n for k, n in self.children.items() if n.type == type_name}
        self.unread -= found.keys()
        return list(found.values())

    def matrix(self, key: str = "to_world") -> Scalars:
        """Transform of a parameter.

        Parameters
        ----------
        key : str
            Name of the parameter.

        Returns
        -------
        (4, 4) float64
            The identity if the file has none.
        """
        transform = self.get(key)
        if transform is None:
            return np.eye(4)
        return np.array(transform.matrix, np.float64)

    def refuse_unread(self, ledger: Ledger, harmless: str = "") -> None:
        """Stop, or note, if a parameter was never asked for.

        Parameters
        ----------
        ledger : Ledger
            Of the file.
        harmless : str
            Names, separated by spaces, that do not change the picture's expectation.

        Raises
        ------
        UsageError
            Unless lenient.
        """
        for key in sorted(self.unread - set(harmless.split())):
            inner = self.children.get(key)
            what = f'parameter "{key}"' if inner is None else f"inner {inner.name}"
            ledger.replace(f"{self.name}: its {what} is not modelled", "ignored")
        self.unread.clear()


def parse(mi: Any, ledger: Ledger) -> Node:
    """Tree of a Mitsuba file, defaults, includes and references resolved.

    Parameters
    ----------
    mi : module
        ``mitsuba``, from `mitsuba_session`.
    ledger : Ledger
        Of the file.

    Returns
    -------
    Node
        The scene.  A plugin that is referred to twice is one node.

    Raises
    ------
    UsageError
        Not well-formed, or with a reference to nothing.
    """
    with ledger.reading("Mitsuba scene"):
        config = mi.parser.ParserConfig(VARIANT)
        state = mi.parser.parse_file(config, str(ledger.path))
        mi.parser.transform_upgrade(config, state)
        mi.parser.transform_resolve(config, state)
        nodes = [_node(mi, state, entry) for entry in state.nodes]
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
        return nodes[0]


def _node(mi: Any, state: Any, entry: Any) -> Node:
    props = entry.props
    kind, given = props.plugin_name(), props.id()
    place = mi.parser.file_location(state, entry).rpartition("(")[2].rstrip(")")
    name = f'{kind} "{given}"' if given else f"{kind} at {place}"
    values = {key: props[key] for key in props.keys()}  # noqa: SIM118 (no mapping)
    return Node(
        type=str(entry.type).rpartition(".")[2],
        kind=kind,
        name=name,
        id=given or name,
        values=values,
        unread=set(values),
    )
