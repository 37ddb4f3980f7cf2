"""Every outcome of what a pass is given, with the weights that the contract gives it.

A pixel q and two others look at five patches whose solid angles are known.  Each draws
each patch, or nothing, with probability 1/6, so that a reservoir of patch x has
W = 6 mu(x).  What must come out is E[W 1{y = x}] = mu_q(x): it knows nothing of what
the weights are divided by, nor of the order in which candidates come.  By 1/M it is
mu_q(x) times the share of the confidences whose pixels can draw x, a known bias.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Scalars
from restir_gi.reference.oracle.buffers import prefixed
from restir_gi.reference.oracle.cases import SOURCES, Buffers
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.weights import MIS, MIS_AT_REST
from restir_gi.reference.oracle.levels.patches import (
    CLOSE_NEIGHBORS,
    FAR_NEIGHBORS,
    HIDDEN,
    NEAR,
    NOTHING,
    OUTCOMES,
    PATCHES,
    SEES,
    Placement,
    eye,
    patch_reservoirs,
    theory,
    visible_bits,
    whole_weight,
)

Target = Literal["scattered", "outgoing"]
Table = dict[str, NDArray[Any]]
TARGETS: tuple[Target, ...] = ("scattered", "outgoing")
CAP = 6.0

DRAWS = ((0, 1, 2, 3, HIDDEN), (0, 2, HIDDEN, NOTHING), (0, 1, HIDDEN, NOTHING))
"""Of each pixel, what makes a difference; the last is a null, and stands for all."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Where the reservoirs of a stream come from.

    Attributes
    ----------
    M : tuple of float
        Their confidences, in the contract's order; a reservoir with 0 is empty.
    pixels : tuple of int; who drew them; -1 for a neighbour that is not there
    """

    world: Placement
    M: tuple[float, ...]
    pixels: tuple[int, ...]

    @property
    def title(self) -> str:
        """For messages."""
        return f"{self.world.name}, M = {', '.join(f'{M:g}' for M in self.M)}"


@dataclass(frozen=True, slots=True, eq=False)
class LatticeEnumeration:
    """All R outcomes of several setups, for one pass and its settings.

    Attributes
    ----------
    inputs : callable
        From (L,) outcomes and (L, D) numbers u that decide to the buffers of a case,
        whose first L rows they are.
    setups : tuple of Setup; S
    setup : (R,) int; of each outcome
    probability : (R,); of each outcome in its setup
    weights : (R, D + 1)
        Whole numbers that the contract's stream compares; by weights of pairs, which
        stand in the stream, it compares others.
    solid_angle : (S, 5), sr; of each patch at the pixel that resamples
    expected : (S, 5), sr; E[W 1{y = x}] by the contract
    unbiased : (S, 5), sr; the same by any weights without bias
    M : (S,); confidence by the contract
    """

    name: str
    pass_name: str
    settings: dict[str, Value]
    inputs: Callable[[Indices, Scalars], Buffers]
    setups: tuple[Setup, ...]
    setup: Indices
    probability: Scalars
    weights: Scalars
    solid_angle: Scalars
    expected: Scalars
    unbiased: Scalars
    M: Scalars

    @property
    def decisions(self) -> int:
        """D: how many numbers u a row has."""
        return int(self.weights.shape[1]) - 1


# The same for every backend.
@cache
def enumerations() -> tuple[LatticeEnumeration, ...]:
    """Of the passes that choose: both targets, both weights, and all their setups."""
    return (*_without_neighbors(), *enumerations_around())


@cache
def declared_enumerations() -> tuple[LatticeEnumeration, ...]:
    """Of weights that have to be declared: each with one target, and all setups."""
    at_rest = (_temporal(TARGETS[0], mis) for mis in MIS_AT_REST.more)
    moved = (_moved(TARGETS[0], mis) for mis in MIS.more)
    return (*at_rest, *moved, *enumerations_around(declared=True))


def _without_neighbors() -> Iterator[LatticeEnumeration]:
    yield from map(_temporal, TARGETS)
    yield from (_moved(t, mis) for mis in ("1/Z", "1/M") for t in TARGETS)


@cache
def enumerations_around(
    count: int = 2, history: bool = True, declared: bool = False
) -> tuple[LatticeEnumeration, ...]:
    """Of passes ``spatial`` and ``fused``, with one neighbour or two.

    Parameters
    ----------
    history : bool; whether the spatial past is there
    declared : bool; weights that have to be declared, and no others
    """
    weights = MIS.more if declared else ("1/Z", "1/M")
    targets = TARGETS[:1] if declared else TARGETS
    asked = [(t, mis) for mis in weights for t in targets]
    fused = (_fused(*words, count) for words in asked)
    return (*(_spatial(*words, count, history) for words in asked), *fused)


def _temporal(target: Target, mis: str = "") -> LatticeEnumeration:
    setups = tuple(Setup(NEAR, (M, 1.0), (0, 0)) for M in (0.0, 1.0, CAP - 1, CAP))

    def rows(s: Setup, cells: Indices) -> Table:
        past = patch_reservoirs(s.world, target, 0, cells[:, 0], s.M[0])
        new = _new(s.world, target, cells[:, 1])
        return eye(s.world, 0, len(cells)) | prefixed("past", past) | new

    settings: dict[str, Value] = {"target": target, "cap": CAP}
    settings |= {"mis": mis} if mis else {}
    return _enumerated("temporal", settings, setups, rows, ("u",))


def _moved(target: Target, mis: str) -> LatticeEnumeration:
    makers = ((NEAR, 1), (FAR_NEIGHBORS, 1), (FAR_NEIGHBORS, 2), (CLOSE_NEIGHBORS, 1))
    setups = tuple(
        Setup(world, (M, 1.0), (who, 0))
        for world, who in makers
        for M in (0.0, 1.0, CAP - 1, CAP)
    )

    def rows(s: Setup, cells: Indices) -> Table:
        who = s.pixels[0]
        then = eye(s.world, who, len(cells))
        past = patch_reservoirs(s.world, target, who, cells[:, 0], s.M[0])
        bits = visible_bits(np.array([0, who]), [cells[:, 1], cells[:, 0]])
        return (
            eye(s.world, 0, len(cells))
            | prefixed("past", then | past)
            | _new(s.world, target, cells[:, 1])
            | {"visible": bits}
        )

    settings: dict[str, Value] = {"target": target, "cap": CAP, "mis": mis}
    return _enumerated("moved", settings, setups, rows, ("u",))


def _spatial(target: Target, mis: str, count: int, history: bool) -> LatticeEnumeration:
    """The neighbours, with each of their draws, stand behind the rows that count."""
    both, one = (0, 0, 1, 2), (0, 0, 1, -1)
    every = (
        Setup(NEAR, (0.0, 1.0, 2.0, 1.0), both),
        Setup(NEAR, (CAP - 1, 1.0, CAP, 0.0), one),
        Setup(FAR_NEIGHBORS, (0.0, CAP, CAP - 1, CAP), both),
        Setup(FAR_NEIGHBORS, (1.0, 1.0, 1.0, 0.0), both),
        Setup(CLOSE_NEIGHBORS, (0.0, 1.0, CAP, 1.0), both),
        Setup(CLOSE_NEIGHBORS, (CAP, 1.0, 1.0, 0.0), one),
    )
    setups = [_with(s, count, history) for s in every]
    others = _stacked([_neighbors_of(s, target) for s in setups])

    def rows(s: Setup, cells: Indices) -> Table:
        past, own = (
            patch_reservoirs(s.world, target, 0, cells[:, k], s.M[k]) for k in (0, 1)
        )
        behind = np.arange(count) + setups.index(s) * count
        first = behind * OUTCOMES
        around = np.where(np.array(s.pixels[2:]) > 0, first + cells[:, 2:], -1)
        viewers = np.array([0, *s.pixels[2:]])
        slots = [*cells.T[1:], cells[:, 0]]
        return (
            eye(s.world, 0, len(cells))
            | own
            | prefixed("past", past)
            | {"neighbors": around, "visible": visible_bits(viewers, slots)}
        )

    settings: dict[str, Value] = {"target": target, "cap": CAP, "mis": mis}
    numbers = ("u_own", "u_neighbors")
    about = tuple(setups), rows, numbers, others
    found = _enumerated("spatial", settings, *about)
    words = [found.name, "1-neighbor" * (count == 1), "no-past" * (not history)]
    return replace(found, name="-".join(filter(None, words)))


def _with(s: Setup, count: int, history: bool) -> Setup:
    """The same with the first neighbours, and with an empty past if there is none."""
    past = s.M[0] if history else 0.0
    return Setup(s.world, (past, *s.M[1 : 2 + count]), s.pixels[: 2 + count])


def _fused(target: Target, mis: str, count: int) -> LatticeEnumeration:
    """The past frame, with each draw of its points, stands behind the rows."""
    both, one = (0, 1, 2), (0, 1, -1)
    every = (
        Setup(NEAR, (1.0, 2.0, 1.0), both),
        Setup(NEAR, (1.0, CAP, 0.0), one),
        Setup(FAR_NEIGHBORS, (1.0, CAP - 1, CAP), both),
        Setup(FAR_NEIGHBORS, (2.0, 1.0, 0.0), both),
        Setup(CLOSE_NEIGHBORS, (1.0, CAP, 1.0), both),
        Setup(CLOSE_NEIGHBORS, (1.0, 0.0, 2.0), both),
    )
    setups = [Setup(s.world, s.M[: 1 + count], s.pixels[: 1 + count]) for s in every]
    past = _stacked([_past_of(s, target) for s in setups])

    def rows(s: Setup, cells: Indices) -> Table:
        first = (np.arange(count) + setups.index(s) * count) * OUTCOMES
        sources = np.where(np.array(s.pixels[1:]) > 0, first + cells[:, 1:], -1)
        return (
            _now(s, target, cells[:, 0])
            | _then(s, target, 0, np.full(len(cells), NOTHING), 0.0)
            | {
                "sources": sources,
                "visible": visible_bits(np.array(s.pixels), [*cells.T]),
            }
        )

    settings: dict[str, Value] = {"target": target, "cap": CAP, "mis": mis}
    found = _enumerated("fused", settings, tuple(setups), rows, ("u",), past)
    return replace(found, name=f"{found.name}-1-source") if count == 1 else found


def _past_of(s: Setup, target: Target) -> Table:
    """Points of the past with each of their draws, `OUTCOMES` rows each."""
    count = len(s.pixels) - 1
    cells = np.arange(PATCHES + 1)
    found = [
        _now(s, target, np.full_like(cells, NOTHING))
        | _then(s, target, k, cells, s.M[k])
        | {"sources": np.full((len(cells), count), -1)}
        | {"visible": visible_bits(np.array([0, *[-1] * count]), [cells])}
        for k in range(1, 1 + count)
    ]
    return _stacked(found)


def _now(s: Setup, target: Target, cells: Indices) -> Table:
    """The pixel, and the reservoirs that it has drawn in this frame."""
    own = patch_reservoirs(s.world, target, 0, cells, s.M[0])
    return eye(s.world, 0, len(cells)) | own


def _then(s: Setup, target: Target, who: int, cells: Indices, M: float) -> Table:
    """A point of the past frame with its reservoirs."""
    kept = patch_reservoirs(s.world, target, who, cells, M)
    return prefixed("past", eye(s.world, who, len(cells)) | kept)


def _neighbors_of(s: Setup, target: Target) -> Table:
    """The neighbours with each of their draws, `OUTCOMES` rows each."""
    count = len(s.pixels) - 2
    cells = np.arange(PATCHES + 1)
    nothing = patch_reservoirs(s.world, target, 0, np.full_like(cells, NOTHING), 0.0)
    found = [
        eye(s.world, k, len(cells))
        | patch_reservoirs(s.world, target, k, cells, s.M[1 + k])
        | prefixed("past", nothing)
        | {"neighbors": np.full((len(cells), count), -1)}
        | {"visible": visible_bits(np.array([k, *[-1] * count]), [cells])}
        for k in range(1, 1 + count)
    ]
    return _stacked(found)


def _new(world: Placement, target: Target, cells: Indices) -> Table:
    found = patch_reservoirs(world, target, 0, cells, 1.0)
    W = found.pop("W")
    del found["M"]
    # A null has a density as well.
    pdf = np.divide(1.0, W, out=np.ones_like(W), where=W > 0)
    return prefixed("new", found) | {"new_pdf": pdf}


def _enumerated(
    pass_name: str,
    settings: dict[str, Value],
    setups: tuple[Setup, ...],
    rows: Callable[[Setup, Indices], Table],
    numbers: tuple[str, ...],
    behind: Table | None = None,
) -> LatticeEnumeration:
    draws = [_outcomes(s) for s in setups]
    cells = [drawn for drawn, _ in draws]
    table = _stacked([rows(*about) for about in zip(setups, cells, strict=True)])
    target, mis = str(settings["target"]), str(settings.get("mis", "1/Z"))
    angles = [theory(s.world, target) for s in setups]
    unbiased = np.array([known.mu[0] for known in angles])
    shares = np.array([_share_that_can_draw(s) for s in setups])
    words = [pass_name, target] if target != TARGETS[0] else [pass_name]
    words += [{"1/Z": "", "1/M": "1-over-M"}.get(mis, mis)]
    return LatticeEnumeration(
        "-".join(filter(None, ["lattice", *words])),
        pass_name,
        settings,
        lambda lines, u: _buffers(pass_name, table, behind, numbers, lines, u),
        setups,
        np.repeat(np.arange(len(setups)), [len(drawn) for drawn in cells]),
        np.concatenate([chance for _, chance in draws]),
        np.concatenate([_weights(*about) for about in zip(setups, cells, strict=True)]),
        np.array([known.solid_angle[0] for known in angles]),
        unbiased * shares if mis == "1/M" else unbiased,
        unbiased,
        np.minimum([sum(s.M) for s in setups], CAP),
    )


def _outcomes(s: Setup) -> tuple[Indices, Scalars]:
    """Draws of all reservoirs, (R, D + 1), and their chances; what is empty has one."""
    draws = [
        (NOTHING,) if M == 0 or who < 0 else DRAWS[who]
        for M, who in zip(s.M, s.pixels, strict=True)
    ]
    chances = [
        (*[1 / OUTCOMES] * (len(cells) - 1), 1 - (len(cells) - 1) / OUTCOMES)
        for cells in draws
    ]
    cells, chance = (np.array(list(product(*columns))) for columns in (draws, chances))
    return cells, chance.prod(axis=1)


def _weights(s: Setup, cells: Indices) -> Scalars:
    columns = [
        M * whole_weight(who, cells[:, k])
        for k, (M, who) in enumerate(zip(s.M, s.pixels, strict=True))
    ]
    return np.stack(columns, axis=1).astype(float)


def _share_that_can_draw(s: Setup) -> Scalars:
    """Of all confidences those of pixels that can draw each patch, (5,)."""
    M = np.array(s.M)
    can = np.array([SEES[who] & SEES[0] for who in s.pixels])
    found: Scalars = (M[:, None] * can).sum(axis=0) / M.sum()
    return found


def _stacked(tables: list[Table]) -> Table:
    return {name: np.concatenate([t[name] for t in tables]) for name in tables[0]}


def _buffers(
    pass_name: str,
    table: Table,
    behind: Table | None,
    numbers: tuple[str, ...],
    lines: Indices,
    u: Scalars,
) -> Buffers:
    found = {name: column[lines] for name, column in table.items()}
    if behind is not None:
        rows = SOURCES[pass_name].rows
        here = found[rows]
        found[rows] = np.where(here >= 0, here + len(lines), -1)
        found = _stacked([found, behind])
        u = np.concatenate(
            [u, np.full((len(found["W"]) - len(lines), u.shape[1]), 0.5)]
        )
    if numbers == ("u",):
        return found | {"u": u if behind is not None else u[:, 0]}
    return found | {numbers[0]: u[:, 0], numbers[1]: u[:, 1:]}
