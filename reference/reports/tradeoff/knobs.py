"""Knobs: what can be turned at a method, and how far."""

from collections.abc import Iterable
from dataclasses import dataclass, fields

from restir_gi.reference.methods import Method
from restir_gi.reference.reports.tradeoff.points import Design, can_run
from restir_gi.reference.scene.animation import Changes
from restir_gi.reference.system.errors import UsageError


@dataclass(frozen=True, slots=True)
class Knob:
    """What can be turned, and how far.

    Attributes
    ----------
    levels : tuple of (str, tuple of str); a label, and the settings that it stands for
    """

    name: str
    levels: tuple[tuple[str, tuple[str, ...]], ...]


def _levels(key: str, *values: object) -> Knob:
    return Knob(key, tuple((str(v), (f"{key}={v}",)) for v in values))


KNOBS = (
    Knob(
        "mode",
        (
            ("no reuse", ("temporal=false", "spatial=false")),
            ("1/M, no rays", ("mis=1/M", "visibility=none")),
            ("1/M", ("mis=1/M",)),
            ("1/Z, no rays", ("mis=1/Z", "visibility=none")),
            ("1/Z, rays of the kept", ("mis=1/Z", "visibility=chosen")),
            ("1/Z", ("mis=1/Z",)),
            ("balance", ("mis=balance",)),
            ("pairwise", ("mis=pairwise",)),
            ("defensive", ("mis=defensive",)),
        ),
    ),
    _levels("temporal_cap", 1, 8, 30, 100, "inf"),
    _levels("spatial_cap", 1, 100, 500, "inf"),
    Knob(
        "iterations",
        tuple(
            (str(n), (f"iterations_few={n}", f"iterations_many={n}"))
            for n in (0, 1, 3, 6, 9)
        ),
    ),
    _levels("neighbors", 0, 1, 2, 3, 6),
    _levels("radius", 0.02, 0.05, 0.1, 0.2, 0.4),
    _levels("target", "scattered", "outgoing"),
    _levels("source", "uniform", "cosine", "bsdf"),
    _levels("storage", "float64", "float32", "half", "paper"),
    _levels("jacobian_limit", "inf", 10, 3),
    _levels("checkerboard", "false", "true"),
    _levels("lattice", 1, 2, 4),
)
IN_MOTION = (_levels("motion", "shifted", "as-stored"),)
VALIDATED = (
    Knob(
        "validation",
        tuple(
            (
                f"every {n}" if n else "never",
                ("motion=as-stored", f"validate_every={n}"),
            )
            for n in (0, 2, 6, 30)
        ),
    ),
)
LONG = (_levels("roulette", 1, 0.5, 0.25),)


def built_in_knobs(changes: Changes, bounces: int) -> tuple[Knob, ...]:
    """Knobs that can matter.

    Those of motion where something moves, validation where light may change, and
    roulette where paths are long enough for it.

    Parameters
    ----------
    changes : 'nothing', 'camera' or 'scene'; what may differ between frames
    """
    moving = IN_MOTION if changes != "nothing" else ()
    validated = VALIDATED if changes == "scene" else ()
    return (*KNOBS, *moving, *validated, *(LONG if bounces > 1 else ()))


def knobs_of(words: Iterable[str]) -> tuple[Knob, ...]:
    """Knobs as they are written on the command line.

    Raises UsageError: it is not of that form.

    Parameters
    ----------
    words : iterable of str; each ``KEY=VALUE,VALUE,...``
    """
    found = []
    for word in words:
        key, equals, values = word.partition("=")
        if not (key and equals and all(values.split(","))):
            raise UsageError(f"--sweep {word!r} is not of the form KEY=VALUE,VALUE,...")
        found.append(_levels(key, *values.split(",")))
    return tuple(found)


def usable(knobs: Iterable[Knob], method: Method) -> tuple[Knob, ...]:
    """Knobs that a method has, without the levels that it does not take.

    Knobs that are left with fewer than two levels are left out.
    """
    found = []
    for knob in knobs:
        levels = tuple(level for level in knob.levels if _takes(method, level[1]))
        if len(levels) > 1:
            found.append(Knob(knob.name, levels))
    return tuple(found)


def _takes(method: Method, values: tuple[str, ...]) -> bool:
    own = {field.name for field in fields(method.settings)}
    has_them = {value.partition("=")[0] for value in values} <= own
    return has_them and can_run(Design(method.name, values))
