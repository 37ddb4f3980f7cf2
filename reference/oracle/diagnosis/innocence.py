"""Whether choices leave the mean alone: calculated, in worlds that are summed exactly.

A pixel q, another one that is near, and one that is far look at three patches whose
solid angles are known.  Each of their reservoirs holds each patch, or nothing, with
probability 1/4, so that one of patch x has W = 4 mu(x).  Over all outcomes, and for
each over all samples that may be kept, with the probability that the replay's own
weights give them, E[W 1{y = x}] must be mu_q(x): for every patch, and among the rows of
each M by itself, since the next frame weighs by M.  Nothing may be kept that q does not
hold, since q could not have made it.  Where 1/M is asked for, its own expectation is
right, too.  Of what is biased by design the same sums say how much of a pixel's light
it adds or takes away.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.reference.numerics.arrays import Indices, Masks, Scalars
from restir_gi.reference.oracle.buffers import given, prefixed
from restir_gi.reference.oracle.cases import Case
from restir_gi.reference.oracle.contract.fields import Value
from restir_gi.reference.oracle.contract.surfaces import NODES
from restir_gi.reference.oracle.contract.weights import MIS, MIS_AT_REST
from restir_gi.reference.oracle.diagnosis.hypothesis import Hypothesis, combined
from restir_gi.reference.oracle.replay.bounded import (
    Bounded,
    constant,
    exact,
    rounding_of,
)
from restir_gi.reference.oracle.replay.chain import (
    Merge,
    first_of_chain,
    merge_weights,
    merged_with,
)
from restir_gi.reference.oracle.replay.formulas import reflected
from restir_gi.reference.oracle.replay.geometry import luminance
from restir_gi.reference.oracle.replay.mis import CHAINED, OWN, with_mis_weights
from restir_gi.reference.oracle.replay.points import (
    ReceiverPoint,
    SamplePoint,
    point_of,
    receiver_of,
)
from restir_gi.reference.oracle.replay.resampling import (
    closed,
    closed_confidence,
    of_kept,
)
from restir_gi.reference.oracle.replay.reuse import STREAMS, stream_of
from restir_gi.reference.oracle.replay.rules import CONTRACT_RULES, Rules
from restir_gi.reference.oracle.replay.slots import Closing, Slot
from restir_gi.reference.oracle.replay.stream import sums_of
from restir_gi.reference.oracle.replay.surface_rules import CONTRACT_SURFACES
from restir_gi.reference.oracle.replay.target_rules import TargetRules

Buffers = dict[str, NDArray[Any]]

OUTCOMES, NOTHING = 4, 3

PLACE = np.array([[0.5, 1.5, 0.25], [-1.0, 1.25, 0.5], [0.8, 1.0, -0.9]])
FACING = np.array([[0.1, -1.0, 0.2], [0.5, -0.8, -0.3], [-0.6, -0.7, 0.3]])
AREA = np.array([0.12, 0.6, 0.2])
LIGHT = np.array([[2.0, 0.7, 0.1], [4e-8, 2e-7, 1e-11], [0.0, 0.0, 30.0]])
"""Colours, one that is darker than any floor, and one of a single channel."""

UP = np.array([[0.0, 1.0, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.6, -0.8]])
DOWN, ASIDE = [0.2, -0.97, -0.1], [0.9, 0.3, 0.3]
BESIDE, ABOVE = np.array([[1.5, -0.25, 0.5], [-1.0, 0.5, 1.0]]), [0.4, 1.9, 0.3]

EYES = {
    "beside": ([[0, 0, 0], *BESIDE], UP),
    # Of the first patch J is 1/100 from the second pixel; from the third it is 100.
    "near and far": ([[0, 0, 0], [0.52, 1.34, 0.28], [-1.8, -15.0, 2.0]], UP),
    # One sees the back of a patch that q holds, or q that of what others hold.
    "behind": ([[0, 0, 0], ABOVE, BESIDE[1]], [UP[0], DOWN, UP[2]]),
    "from behind": ([ABOVE, [0, 0, 0], BESIDE[1]], [DOWN, UP[0], UP[2]]),
    # Others hold a patch that is below the horizon of q.
    "tilted": ([[0, 0, 0], *BESIDE], [ASIDE, UP[1], UP[2]]),
}
"""Places and normals of q and of two others."""

ALBEDO = np.array([[0.8, 0.5, 0.3], [0.5, 0.5, 0.9], [0.3, 0.9, 0.2]])
SEES = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 0]], bool)
HIDDEN = np.array([[1, 1, 0], [1, 1, 1], [0, 1, 1]], bool)

REC_709 = (0.2126, 0.7152, 0.0722)

VIEWS = np.array([[0.36, 0.8, -0.48], [-0.48, 0.6, -0.64], [0.0, 0.8, -0.6]])
ASIDE_OF_Q = np.array([VIEWS[0], [-0.9, -0.3, 0.3], VIEWS[2]])
GLOSSY: Buffers = {
    "view": VIEWS,
    "alpha": np.array([0.5, 0.1, 1.0]),
    "f0": np.full((3, 3), 0.04),
}
COAT: Buffers = {
    "view": VIEWS,
    "alpha": np.array([0.3, 0.1, 0.8]),
    "ior": np.array([1.5, 1.3, 2.0]),
    "internal_reflectance": np.array([0.6, 0.4, 0.7]),
    "transmittance": np.linspace([0.1, 0.2, 0.3], [0.9, 0.95, 0.8], NODES, axis=1),
    "nonlinear": np.array([0, 1, 1], np.uint32),
}
LOOKS: Mapping[str, Buffers] = {
    "glossy": GLOSSY,
    "coated": COAT,
    "metal": GLOSSY | {"f0": ALBEDO, "albedo": ALBEDO * [[0.0], [1.0], [1.0]]},
    # One is seen from below its horizon; or from where q is not.
    "from below": GLOSSY | {"view": VIEWS * [[1.0], [-1.0], [1.0]]},
    "aside": GLOSSY | {"view": ASIDE_OF_Q},
}
"""Declared surfaces of q and of two others, by name: buffers of three rows each."""

TOLERANCE = 1e-9
"""Of a sum of some hundred products in float64, and of a bias far below any that a
picture could show."""


@dataclass(frozen=True, slots=True)
class Situation:
    """One of the worlds.

    Attributes
    ----------
    eyes : str; where the pixels are, by their name in `EYES`
    hidden : bool; one patch is hidden from q, too
    M : tuple of float; of the past, of q's own and of the two neighbours
    neighbors : int; of the two, those that there are
    look : str; a declared surface, by its name in `LOOKS`; empty for Lambertian ones
    """

    eyes: str
    hidden: bool
    M: tuple[float, float, float, float]
    cap: float
    target: str
    mis: str
    neighbors: int = 2
    look: str = ""


def _situations() -> Iterator[Situation]:
    worlds = (
        ("beside", False, (2.0, 1.0, 3.0, 1.0), 20.0, "scattered", 2),
        ("near and far", False, (4.0, 4.0, 4.0, 2.0), 4.0, "scattered", 2),
        ("behind", True, (1.0, 2.0, 1.0, 2.0), 9.0, "scattered", 2),
        ("near and far", True, (0.0, 1.0, 2.0, 4.0), 4.0, "outgoing", 2),
        ("beside", True, (2.5, 1.0, 2.5, 1.5), 2.5, "outgoing", 1),
        ("from behind", False, (300.0, 1.0, 260.0, 2.0), 500.0, "outgoing", 2),
        ("tilted", True, (1.0, 2.0, 3.0, 1.0), 9.0, "outgoing", 2),
        ("tilted", True, (1.0, 1.0, 1.0, 1.0), 9.0, "scattered", 2),
    )
    for (eyes, hidden, M, cap, target, count), mis in product(worlds, ("1/Z", "1/M")):
        yield Situation(eyes, hidden, M, cap, target, mis, count)


SITUATIONS = tuple(_situations())

SURFACE_SITUATIONS = tuple(
    replace(situation, target="scattered", look=look)
    for look in LOOKS
    for situation in SITUATIONS
    if situation.eyes == "beside" and not situation.hidden and situation.mis == "1/Z"
)
"""Worlds of those who do other things with declared surfaces alone.

Of 1/M nothing is asked: its own expectation hangs on what others could have made.
"""


WEIGHT_SITUATIONS = tuple(
    replace(situation, mis=mis)
    for mis in MIS.more
    for situation in SITUATIONS
    if situation.target == "scattered"
    and situation.eyes in ("beside", "near and far")
    and situation.mis == "1/Z"
)
"""Worlds of declared weights, for rules that do not put others in their place."""


@dataclass(frozen=True, slots=True, eq=False)
class PatchWorld:
    """Pixels and patches.

    Attributes
    ----------
    eye, up : (3, 3); the pixels and their normals
    mu : (3, 4); solid angle of each patch from each pixel; 0 where it is not held
    sees : (3, 4) bool
    """

    eye: Scalars
    up: Scalars
    mu: Scalars
    sees: NDArray[np.bool_]


@cache
def world(eyes: str, hidden: bool) -> PatchWorld:
    """Solid angles from their definition."""
    normal = FACING / np.linalg.norm(FACING, axis=1, keepdims=True)
    eye, up = (np.array(part, float) for part in EYES[eyes])
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    v = PLACE[None] - eye[:, None]
    d = np.linalg.norm(v, axis=-1)
    facing = -np.einsum("ijk,jk->ij", v, normal) / d
    cosine = np.einsum("ijk,ik->ij", v, up) / d
    sees = HIDDEN if hidden else SEES
    held = sees & (cosine > 0) & (facing > 0)
    mu = np.where(held, AREA * np.abs(facing) / d**2, 0.0)
    pad = ((0, 0), (0, 1))
    return PatchWorld(eye, up, np.pad(mu, pad), np.pad(sees, pad))


def _reservoir(at: PatchWorld, who: int, cells: Indices, M: float) -> Buffers:
    mu = at.mu[who][cells]
    normal = FACING / np.linalg.norm(FACING, axis=1, keepdims=True)
    light = np.concatenate([LIGHT, np.zeros((1, 3))])[cells]
    return {
        "position": np.concatenate([PLACE, [[0.0, 1.0, 0.0]]])[cells],
        "normal": np.concatenate([normal, [[0.0, -1.0, 0.0]]])[cells],
        "radiance": np.where((mu > 0)[:, None], light, 0.0),
        "W": OUTCOMES * mu if M else mu * 0,
        "M": np.full(len(cells), M),
    }


def _eye(at: PatchWorld, who: int, rows: int, look: str) -> Buffers:
    one = {
        "visible_position": at.eye[who],
        "visible_normal": at.up[who],
        "albedo": ALBEDO[who],
    }
    if look:
        one |= {name: a[who] for name, a in LOOKS[look].items()}
    return {
        name: np.tile(np.asarray(a), (rows,) + (1,) * np.ndim(a))
        for name, a in one.items()
    }


def _new(at: PatchWorld, cells: Indices) -> Buffers:
    found = _reservoir(at, 0, cells, 1.0)
    W = found.pop("W")
    del found["M"]
    pdf = np.divide(1.0, W, out=np.full_like(W, 0.2), where=W > 0)
    return prefixed("new", found) | {"new_pdf": pdf}


def _bits(
    at: PatchWorld, viewers: list[int], cells: list[Indices], made_by: list[int]
) -> NDArray[np.uint32]:
    words = np.zeros((len(cells[0]), len(viewers)), np.uint32)
    for column, viewer in enumerate(viewers):
        for bit, (cell, maker) in enumerate(zip(cells, made_by, strict=True)):
            seen = at.sees[viewer][cell] | (viewer == maker)
            words[:, column] |= seen.astype(np.uint32) << np.uint32(bit)
    return words


def _outcomes(count: int) -> Indices:
    return np.array(list(product(range(OUTCOMES), repeat=count)))


def _temporal(at: PatchWorld, s: Situation) -> tuple[Case, Indices]:
    cells = _outcomes(2)
    past = _reservoir(at, 0, cells[:, 0], s.M[0])
    inputs = (
        _eye(at, 0, len(cells), s.look) | prefixed("past", past) | _new(at, cells[:, 1])
    )
    inputs |= {"u": np.full(len(cells), 0.5)}
    settings: dict[str, Value] = {"target": s.target, "cap": s.cap}
    settings |= {"mis": s.mis} if s.mis in MIS_AT_REST.more else {}
    case = Case("world", "temporal", settings, given(inputs, "float64"))
    return case, np.arange(len(cells))


def _moved(at: PatchWorld, s: Situation) -> tuple[Case, Indices]:
    cells = _outcomes(2)
    past = _eye(at, 1, len(cells), s.look) | _reservoir(at, 1, cells[:, 0], s.M[2])
    visible = _bits(at, [0, 1], [cells[:, 1], cells[:, 0]], [0, 1])
    inputs = (
        _eye(at, 0, len(cells), s.look) | prefixed("past", past) | _new(at, cells[:, 1])
    )
    inputs |= {"u": np.full(len(cells), 0.5), "visible": visible}
    settings: dict[str, Value] = {"target": s.target, "cap": s.cap, "mis": s.mis}
    case = Case("world", "moved", settings, given(inputs, "float64"))
    return case, np.arange(len(cells))


def _spatial(at: PatchWorld, s: Situation) -> tuple[Case, Indices]:
    """Rows in threes: q, and the two neighbours that only q looks at."""
    cells = _outcomes(4)
    past, own, *around = cells.T
    count, everyone = len(cells), [own, *around]

    def interleaved(parts: list[Buffers]) -> Buffers:
        return {
            name: np.stack([p[name] for p in parts], axis=1).reshape(
                3 * count, *parts[0][name].shape[1:]
            )
            for name in parts[0]
        }

    inputs = interleaved([_eye(at, k, count, s.look) for k in range(3)])
    held = [_reservoir(at, k, everyone[k], s.M[1 + k]) for k in range(3)]
    inputs |= interleaved(held)
    before = _reservoir(at, 0, past, s.M[0])
    inputs |= prefixed("past", interleaved([before] * 3))
    row = np.arange(count) * 3
    neighbors = np.full((3 * count, 2), -1)
    for k in range(s.neighbors):
        neighbors[row, k] = row + 1 + k
    visible = np.zeros((3 * count, 3), np.uint32)
    visible[row] = _bits(at, [0, 1, 2], [*everyone, past], [0, 1, 2, 0])
    inputs |= {
        "neighbors": neighbors,
        "visible": visible,
        "u_own": np.full(3 * count, 0.5),
        "u_neighbors": np.full((3 * count, 2), 0.5),
    }
    settings: dict[str, Value] = {"target": s.target, "cap": s.cap, "mis": s.mis}
    return Case("world", "spatial", settings, given(inputs, "float64")), row


def _fused(at: PatchWorld, s: Situation) -> tuple[Case, Indices]:
    """As many rows, of which q reads two each of the past frame."""
    cells = _outcomes(3)
    count = len(cells)
    parts = [
        (_eye(at, k, count, s.look), _reservoir(at, k, cells[:, k], s.M[1 + k]))
        for k in range(3)
    ]
    own, *others = [x | r for x, r in parts]
    inputs = {name: np.tile(a, (2,) + (1,) * (a.ndim - 1)) for name, a in own.items()}
    past = {n: np.concatenate([other[n] for other in others]) for n in own}
    sources = np.arange(count)[:, None] + [0, count]
    sources[:, s.neighbors :] = -1
    visible = _bits(at, [0, 1, 2], list(cells.T), [0, 1, 2])
    inputs |= prefixed("past", past)
    inputs |= {
        "sources": np.tile(sources, (2, 1)),
        "visible": np.tile(visible, (2, 1)),
        "u": np.full((2 * count, 2), 0.5),
    }
    settings: dict[str, Value] = {"target": s.target, "cap": s.cap, "mis": s.mis}
    case = Case("world", "fused", settings, given(inputs, "float64"))
    return case, np.arange(count)


BUILT = {"temporal": _temporal, "moved": _moved, "spatial": _spatial, "fused": _fused}


def _patches(at: PatchWorld) -> SamplePoint:
    """The patches, with their light whoever looks at them."""
    rounding, patches = rounding_of("float64"), np.arange(len(PLACE))
    y = point_of(_reservoir(at, 0, patches, 1.0), rounding)
    return replace(y, radiance=exact(LIGHT, rounding))


def _point(at: PatchWorld, who: int, situation: Situation) -> ReceiverPoint:
    """A pixel, once for each patch."""
    eye = _eye(at, who, len(PLACE), situation.look)
    return receiver_of(eye, rounding_of("float64"))


def _kept(situation: Situation, rules: Rules) -> tuple[bool, ...]:
    """Whether each pixel keeps each patch, with the target of the rules.

    Empty for Lambertian points, which keep whatever they see.
    """
    at = world(situation.eyes, situation.hidden)
    if not situation.look:
        return ()
    y, points = _patches(at), (_point(at, who, situation) for who in range(len(at.mu)))
    p_hat = (rules.target(situation.target, x, y) for x in points)
    return tuple(k for p in p_hat for k in (*(p.value > 0).tolist(), False))


@cache
def case_of(
    pass_name: str, situation: Situation, kept: tuple[bool, ...] = ()
) -> tuple[Case, Indices]:
    """Case of all outcomes of a world, and the rows of q, (R,) int.

    Parameters
    ----------
    kept : tuple of bool; whether each pixel keeps each patch; empty where all do
    """
    at = world(situation.eyes, situation.hidden)
    if kept:
        at = replace(at, mu=np.where(np.reshape(kept, at.mu.shape), at.mu, 0.0))
    return BUILT[pass_name](at, situation)


@dataclass(frozen=True, slots=True, eq=False)
class KeptSample:
    """A sample that may be kept in each row.

    Attributes
    ----------
    chance, W : (N,); its probability, and its weight
    place : (N, 3); where it is
    """

    chance: Scalars
    W: Scalars
    place: Scalars


def _acceptance(rules: Rules, before: Bounded, w: Bounded) -> Scalars:
    """Probability that a candidate is kept: preferences are linear in u, (N,)."""
    ends = [
        rules.preference(exact(np.full_like(w.value, u), w.rounding), before, w).value
        for u in (0.0, 1.0)
    ]
    high, low = np.maximum(*ends), np.minimum(*ends)
    share = np.divide(high, high - low, out=np.zeros_like(high), where=high > low)
    found = np.where(low > 0, 1.0, np.where(high <= 0, 0.0, share))
    alone = (before.value == 0) & (w.value > 0)
    return np.where(alone, 1.0, found)


def _stream_outcomes(
    slots: list[Slot], closing: Closing, rules: Rules
) -> tuple[list[KeptSample], Scalars]:
    slots = with_mis_weights(slots, closing, rules)
    sums = sums_of(slots, rules)
    accepted = [np.ones_like(sums[0].value)]
    accepted += [
        _acceptance(rules, sums[k - 1], slots[k].w) for k in range(1, len(slots))
    ]
    of_others = len(slots) - sum(slot.domain is not None for slot in slots)
    shared = {"": len(slots), "neighbors": of_others, "all": 1}[rules.shared_decision]
    found, later, most = [], np.ones_like(sums[0].value), np.zeros_like(sums[0].value)
    M = sums[-1].value
    for k in reversed(range(len(slots))):
        if k >= shared:
            # One number: the last of those that it would keep.
            chance = np.maximum(accepted[k] - most, 0.0)
            most = np.maximum(most, accepted[k])
            later = 1 - most
        else:
            chance, later = accepted[k] * later, later * (1 - accepted[k])
        kept = np.full(len(later), k)
        parts, confidence = closed(slots, kept, sums[-1], closing, rules)
        W = np.where(sums[-1].value == 0, 0.0, parts["W"].value)
        found.append(KeptSample(chance, W, slots[k].y.position.value))
        M = confidence.value
    return found, M


def _chain_outcomes(
    slots: list[Slot], closing: Closing, rules: Rules
) -> tuple[list[KeptSample], Scalars]:
    ways: list[tuple[Merge, Scalars, Scalars]] = [
        (first_of_chain(slots), np.ones_like(slots[0].w.value), slots[0].w.value)
    ]
    for _ in range(1, len(slots)):
        ways = [way for before in ways for way in _next(before, slots, closing, rules)]
    found, M = [], slots[0].M.value
    for chain, chance, total in ways:
        y, p_hat = of_kept(slots, chain.kept)
        W = rules.closed(chain.held, p_hat, constant(1.0, p_hat)).value
        found.append(KeptSample(chance, np.where(total == 0, 0.0, W), y.position.value))
        M = closed_confidence(chain.M, closing, rules).value
    return found, M


def _next(
    before: tuple[Merge, Scalars, Scalars],
    slots: list[Slot],
    closing: Closing,
    rules: Rules,
) -> Iterator[tuple[Merge, Scalars, Scalars]]:
    """Both ways that a merge can go, with their probabilities and sums of weights."""
    chain, chance, _ = before
    weights = merge_weights(chain, slots, closing, rules)
    total = (weights[0] + weights[1]).value
    accepted = _acceptance(rules, *weights)
    for kept, share in ((True, accepted), (False, 1 - accepted)):
        taken = np.full(len(total), kept)
        after = merged_with(chain, weights, taken, slots, closing, rules)
        yield after, chance * share, total


# E[W 1{y = x}] of each patch, among rows of one M: by M, (3,) each.
Expectations = dict[float, Scalars]


def outcomes_of(
    pass_name: str, rules: Rules, situation: Situation
) -> tuple[list[KeptSample], Scalars]:
    """Samples that may be kept in each row of a world, and M of the rows, (N,)."""
    case, _ = case_of(pass_name, situation, _kept(situation, rules))
    slots, closing = stream_of(case, rules, "float64")
    follow = _chain_outcomes if rules.normalization in CHAINED else _stream_outcomes
    return follow(slots, closing, rules)


@lru_cache(maxsize=4096)
def _sums(
    pass_name: str, rules: Rules, situation: Situation
) -> tuple[Scalars, Scalars]:
    """M of the rows of q, (R,), and E[W 1{y = x}] of each patch in them, (3, R)."""
    _, rows = case_of(pass_name, situation)
    found, M = outcomes_of(pass_name, rules, situation)
    sums = np.zeros((len(PLACE), len(M)))
    for kept in found:
        for x, place in enumerate(PLACE):
            here = (np.abs(kept.place - place) < 1e-6).all(axis=1)
            sums[x] += kept.chance * np.where(here, kept.W, 0.0)
    return M[rows], sums[:, rows]


@lru_cache(maxsize=4096)
def expectations(pass_name: str, rules: Rules, situation: Situation) -> Expectations:
    """What a pass keeps of each patch in the mean, summed over all that can happen."""
    M, sums = _sums(pass_name, rules, situation)
    return {float(m): sums[:, m == M].mean(axis=1) for m in np.unique(M)}


@dataclass(frozen=True, slots=True)
class BiasOfLight:
    """What rules do to the light that a pixel shows, in the worlds that are summed.

    Attributes
    ----------
    beside : float; relative to the light, where other pixels lie beside it
    least, most : float; of all worlds, in some of which J is 1/100 and 100
    """

    beside: float
    least: float
    most: float

    @property
    def text(self) -> str:
        """In words."""
        return (
            f"{_percent(self.beside)} of a pixel's light where others lie beside it,"
            f" {_percent(self.least)} to {_percent(self.most)} where J is 1/100 to 100"
        )


def _percent(relative: float) -> str:
    """A relative bias; what is below a sum's own rounding is none."""
    if abs(relative) <= TOLERANCE:
        return "0 %"
    off = 100 * relative
    return f"{off:+.0f} %" if abs(off) >= 100 else f"{off:+.2g} %"


@lru_cache(maxsize=4096)
def bias_of_light(pass_name: str, rules: Rules) -> BiasOfLight:
    """What rules do to the light that q shows, Σ f(x) E[W 1{y = x}], asked for 1/Z.

    Of a patch that q does not see nothing is shown.
    """
    found = [
        (situation.eyes, bias_in(pass_name, _heeded(rules, situation), situation))
        for situation in situations_of(rules)
        if situation.mis == "1/Z"
    ]
    beside = max((off for eyes, off in found if eyes == "beside"), key=abs)
    every = [off for _, off in found]
    return BiasOfLight(beside, min(every), max(every))


def bias_in(pass_name: str, rules: Rules, situation: Situation) -> float:
    """What rules do to the light that q shows in one world, relative to that."""
    light = light_of(situation)
    mu = world(situation.eyes, situation.hidden).mu[0][:NOTHING]
    shown = _sums(pass_name, rules, situation)[1].mean(axis=1)
    return float(light @ shown) / float(light @ mu) - 1


def light_of(situation: Situation) -> Scalars:
    """Luminance of f · cos θ · L_o of each patch at q, (3,); 0 if hidden."""
    at = world(situation.eyes, situation.hidden)
    if situation.look:
        f = luminance(reflected(_point(at, 0, situation), _patches(at)))
        return np.where(at.sees[0][:NOTHING], f.value, 0.0)
    v = PLACE - at.eye[0]
    cosine = np.maximum(v @ at.up[0] / np.linalg.norm(v, axis=1), 0.0)
    color = ALBEDO[0] / np.pi * LIGHT * cosine[:, None]
    found: Scalars = color @ np.array(REC_709) * at.sees[0][:NOTHING]
    return found


AT_REST = (MIS_AT_REST.default, *MIS_AT_REST.more)
"""Weights that pass ``temporal`` has."""

KEPT_WITH_1_M = (
    "refused",
    "refused_both_ways",
    "cap_when",
    "cap_arriving",
    "past_merged",
    "capped",
    "whole_confidence",
    "most_confidence",
    "fresh_confidence",
    "reused_confidence",
)
"""Choices with which 1/M has another expectation, and no better one."""


@lru_cache(maxsize=4096)
def bias_of_rules(pass_name: str, rules: Rules, shaded: bool = False) -> str:
    """What rules do to the mean of a pass that reuses samples; empty: nothing.

    Parameters
    ----------
    shaded : bool; the shading hides what q does not see, so that it may be anything
    """
    names = (*KEPT_WITH_1_M, "visibility_in_weight") if shaded else KEPT_WITH_1_M
    kept = {name: getattr(rules, name) for name in names}
    biased = replace(CONTRACT_RULES, **kept)
    for situation in situations_of(rules):
        if pass_name == "temporal" and situation.mis not in AT_REST:
            continue  # which has no such setting
        at = world(situation.eyes, situation.hidden)
        mu = at.mu[0][:NOTHING]
        shown = at.sees[0][:NOTHING] | (not shaded)
        found = expectations(pass_name, _heeded(rules, situation), situation)
        allowed = [dict.fromkeys(found, mu)]
        if pass_name != "temporal" and situation.mis == "1/M":
            allowed.append(expectations(pass_name, biased, situation))
        if not any(_equal(found, right, shown) for right in allowed):
            return _told(found, mu, situation, shown)
    return ""


def situations_of(rules: Rules) -> tuple[Situation, ...]:
    """Worlds in which rules may be other than the contract."""
    weights = WEIGHT_SITUATIONS if rules.normalization == "asked" else ()
    surfaces = SURFACE_SITUATIONS if without_surfaces(rules) != rules else ()
    return (*SITUATIONS, *surfaces, *weights)


def _heeded(rules: Rules, situation: Situation) -> Rules:
    """Rules as far as they are heeded in a world, so that sums are done once."""
    return rules if situation.look else without_surfaces(rules)


def without_surfaces(rules: Rules) -> Rules:
    """Rules with the target on declared surfaces as the contract has it."""
    if not isinstance(rules.target, TargetRules):
        return rules
    target = replace(rules.target, surface=CONTRACT_SURFACES)
    return replace(rules, target=target, views=CONTRACT_RULES.views)


def _equal(found: Expectations, right: Expectations, shown: Masks) -> bool:
    def close(a: Scalars, b: Scalars) -> bool:
        return np.allclose(a[shown], b[shown], rtol=TOLERANCE, atol=TOLERANCE)

    return found.keys() == right.keys() and all(
        close(found[m], right[m]) for m in found
    )


def _told(found: Expectations, mu: Scalars, situation: Situation, shown: Masks) -> str:
    off = [(float(abs(E - mu)[shown].max()), M, E) for M, E in found.items()]
    _, M, E = max(off, key=lambda one: one[0])
    x = int(np.argmax(abs(E - mu) * shown))
    among = f" among the rows with M = {M:g}" if len(found) > 1 else ""
    return (
        f"E[W 1(y = x)] of a patch is {E[x]:.4g} instead of {mu[x]:.4g}{among}"
        f" (target {situation.target}, {situation.mis})"
    )


def bias_of(pass_name: str, chosen: tuple[Hypothesis, ...]) -> str:
    """What differences from the contract do to the mean together; empty: nothing.

    Calculated for passes that reuse samples: of what a receiver sees alone where the
    shading tests that.  Of other passes what is declared of each difference holds, and
    of weights that nobody knows but their backend.
    """
    rules = combined(chosen)
    if pass_name not in STREAMS or rules.normalization == OWN:
        return ""
    shaded = any(h.departure == "visibility" for h in chosen)
    return bias_of_rules(pass_name, rules, shaded)
