"""The passes of the renderer on the toy domain: the same functions, in fractions.

:func:`restir_gi.reference.restir_gi.resampled` runs Algorithms 3 and 4, the fused pass
and the general engine, on :class:`Pixels`, :class:`NeighborPixels` and :class:`History`
as they are.  What stands in is the scene alone: a world whose targets and visibility
are tables of fractions, points that are numbers of pixels, and samples that are numbers
of cells.

A frame ago, as seen from pixel 0, some cells had turned and moved, others were hidden,
and the light was another one:

======  ===========  ===========  ==================
cell    moved since  then         now, from pixel 0
======  ===========  ===========  ==================
0       yes          seen         seen
1       no           dark         seen
2       yes          seen         seen
3       no           seen         hidden
4       yes          hidden       seen
5       no           seen         seen
======  ===========  ===========  ==================
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

from restir_gi.reference import restir_gi
from restir_gi.reference.numerics.arrays import divide_or_zero
from restir_gi.reference.options.fused import spatiotemporal_resampling
from restir_gi.reference.options.motion import EarlierReservoirs
from restir_gi.reference.passes import pixels as scene
from restir_gi.reference.passes.initial import InitialSamples
from restir_gi.reference.passes.pixels import FrameReservoirs, History, reconnection
from restir_gi.reference.resampling import target as targets
from restir_gi.reference.resampling.reservoir import Reservoirs
from restir_gi.reference.restir_gi import PassInput
from restir_gi.reference.settings import Settings
from tests.exact.domain import (
    CELL,
    CELLS,
    EYE,
    MU,
    NORMAL,
    NOTHING,
    SEES,
    SOURCE,
    TARGET,
    rationals,
)
from tests.exact.explore import draw

ZERO, ONE = Fraction(0), Fraction(1)
NO_CAP, DEFAULT = 9999, Settings()


def with_nothing(table, nothing=ZERO):
    """Rows with a column for ``NOTHING``."""
    return np.array([[*row, nothing] for row in table], type(nothing))


# ---------------------------------------------------------------- the scene


@dataclass(frozen=True, slots=True)
class Tables:
    """In place of a world, of its materials and of its caster.

    Attributes
    ----------
    position : (7, 3)
        Of the cells.
    p_hat : (P, 7)
        Target of cells at pixels, without visibility.
    seen : (P, 7) bool
        Visibility.
    """

    position: Any
    p_hat: Any
    seen: Any
    plain: ClassVar[bool] = False

    @property
    def materials(self):
        """The target is in the tables."""
        return self

    @property
    def caster(self):
        """And so is visibility."""
        return self

    def visible(self, points, position, normal, asked, purpose):
        """Whether pixels see the cells at given places; false where not asked."""
        number = {tuple(p): x for x, p in enumerate(self.position)}
        seen = np.zeros(len(asked), bool)
        for k in np.flatnonzero(asked):
            seen[k] = self.seen[points.pixel[k]][number[tuple(position[k])]]
        return seen


@dataclass(frozen=True, slots=True)
class Eyes:
    """In place of visible points: numbers of pixels."""

    pixel: Any

    def __len__(self):
        """Number of rows."""
        return len(self.pixel)

    @property
    def position(self):
        """x_v."""
        return EYE[self.pixel]

    @property
    def viewpoints(self):
        """Of these points."""
        return self


@dataclass(frozen=True, slots=True)
class Cells:
    """In place of samples: numbers of cells."""

    cell: Any

    @property
    def position(self):
        """x_s."""
        return CELL[self.cell]

    @property
    def normal(self):
        """n_s."""
        return NORMAL[self.cell]


@dataclass(frozen=True, slots=True)
class CellsThen:
    """The same cells as they were in the last frame."""

    cell: Any

    @property
    def position(self):
        """x_s."""
        return CELL_THEN[self.cell]

    @property
    def normal(self):
        """n_s."""
        return NORMAL_THEN[self.cell]

    @property
    def radiance(self):
        """L_o, of which only the sign is asked."""
        return LIT_THEN[self.cell][:, None]


NOW = Tables(CELL, with_nothing(TARGET), with_nothing(SEES, False))
PDF = with_nothing(np.array(SOURCE) / MU)

MOVES = np.array([True, False, True, False, True, False, False])
TURN = rationals([[1, 0, 0], [0, "3/5", "-4/5"], [0, "4/5", "3/5"]])
STEP = rationals([[8, 0, 0]])[0]
"""To the right by the distance of pixels 0 and 1: distances remain rational."""


def carried(x, cell):
    """Points of the last frame, carried along with the shapes of cells."""
    return np.where(MOVES[cell][:, None], x @ TURN.T + STEP, x)


def led_back(x, cell):
    """Points of this frame, led back with the shapes of cells."""
    return np.where(MOVES[cell][:, None], (x - STEP) @ TURN, x)


EVERY = np.array([*CELLS, NOTHING])
CELL_THEN = led_back(CELL, EVERY)
NORMAL_THEN = np.where(MOVES[:, None], NORMAL @ TURN, NORMAL)
LIT_THEN = np.array([True, False, True, True, True, True, False])
SOURCE_THEN = [Fraction(n, 60) for n in (12, 0, 15, 10, 0, 8)]
TARGET_THEN = [Fraction(n, 6) for n in (18, 0, 3, 12, 24, 14)]
SEES_THEN = np.array([1, 1, 1, 1, 0, 1], bool)
HOLDS_THEN = SEES_THEN & LIT_THEN[:NOTHING]
THEN = Tables(CELL_THEN, with_nothing([TARGET_THEN]), with_nothing([SEES_THEN], False))
MU_THEN = np.where(MOVES[:NOTHING], MU[1], MU[0])
"""As seen from pixel 0 then: where it moved since, pixel 1 is where pixel 0 was."""


class ToyShift:
    """In place of the temporal shift: cells keep their numbers."""

    def forward(self, y, active):
        """Cells as they are now."""
        return Cells(y.cell)

    def backward(self, y, active):
        """Cells as they were then."""
        return CellsThen(y.cell)

    def points_forward(self, y, x):
        """Points beside cells, carried along."""
        return carried(x, y.cell)

    def points_backward(self, y, x):
        """Points beside cells, led back."""
        return led_back(x, y.cell)


@contextmanager
def on_the_domain() -> Iterator[None]:
    """Targets are read from the tables, while the block runs."""

    def target(kind, tables, points, y):
        return tables.p_hat[points.pixel, y.cell]

    def source_pdf(source, tables, points, omega):
        # The target is 0 wherever a pixel does not draw.
        return np.full(len(points), ONE)

    def direction_and_distance(x_from, x_to):
        return x_to, None

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(scene, "target", target)
        for stand_in in (target, source_pdf, direction_and_distance):
            patch.setattr(targets, stand_in.__name__, stand_in)
        kernel = scene.reconnection_jacobian
        patch.setattr(scene, "reconnection_jacobian", once_for_each(kernel))
        yield


def once_for_each(kernel):
    """The kernel, run on different rows alone: most of a batch are the same few."""

    def distinct(*points):
        rows = np.concatenate(points, axis=1).tolist()
        first, number = {}, []
        for row in rows:
            # Numbers of a table are the same objects wherever they are taken from it.
            number.append(first.setdefault(tuple(map(id, row)), len(first)))
        at = np.unique(number, return_index=True)[1]
        return kernel(*(p[at] for p in points))[number]

    return distinct


# ---------------------------------------------------------------- reservoirs


@dataclass(frozen=True, slots=True)
class Kept:
    """Reservoirs between passes: columns that can be told apart."""

    cell: Any
    W: Any
    M: Any

    def opened(self, cells=Cells):
        """As reservoirs."""
        return Reservoirs(cells(self.cell), self.W, self.M)


def closed(r):
    """Columns of reservoirs; an empty one's sample is nobody's business."""
    assert isinstance(r.y, Cells | CellsThen)
    return Kept(np.where(r.W > 0, r.y.cell, NOTHING), r.W, r.M)


def empty(size):
    """What is left after a reset."""
    return Reservoirs(Cells(np.full(size, NOTHING)), *np.full((2, size), ZERO))


def trust(kept, M):
    """The same reservoirs with another confidence, of which nothing is claimed."""
    return replace(kept, M=np.full(len(kept.W), Fraction(M)))


def drawn(i, uniform):
    """Algorithm 2: a new sample of pixel i."""
    x = draw(uniform(), SOURCE[i])
    return InitialSamples(Cells(x), PDF[i][x], np.full(len(x), ONE), None)


def drawn_then(uniform):
    """What pixel 0 kept in the last frame, when it was lit otherwise."""
    x = draw(uniform(), SOURCE_THEN)
    W = divide_or_zero(with_nothing([MU_THEN])[0], with_nothing([SOURCE_THEN])[0])
    return Kept(x, W[x], np.full(len(x), ONE))


# ---------------------------------------------------------------- passes


def receivers(i, size, settings, largest=None):
    """Pixel i of many outcomes.

    ``largest`` refuses shifts whose Jacobian is above it, and not the way back: a limit
    of the settings would refuse both.
    """
    surface = Eyes(np.full(size, i))
    frame = SimpleNamespace(
        world=NOW, visible=SimpleNamespace(surface=surface), settings=settings
    )
    q = restir_gi.pixels_of(frame, slice(0, size))
    if largest is None:
        return q

    def refuses(x_from, x_to, y):
        return (reconnection(x_from, x_to, y) > largest).astype(bool)

    def shift(x_from, x_to, y):
        J = reconnection(x_from, x_to, y)
        return np.where(refuses(x_from, x_to, y), J * 0, J)

    return replace(q, shift=shift, refuses=refuses)


def frame_of(j, kept, then=False):
    """Pixel j of this frame or the last one, once for each outcome."""
    visible = SimpleNamespace(surface=Eyes(np.full(len(kept.W), j)))
    if then:
        return EarlierReservoirs(THEN, visible, kept.opened(CellsThen), ToyShift())
    return FrameReservoirs(NOW, visible, kept.opened())


def past_of(q, kept, then=False):
    """What the last frame left: q's own, or, since it moved, that of pixel 0."""
    size = len(q.points)
    if kept is None:
        return empty(size)
    last = frame_of(0, kept, then)
    return History(last, last, shifted=then).of(last, q, slice(0, size))


def neighbors(q, kept, uniform, then=False):
    """Pixels beside q, from their number to what they kept, and how it is decided."""
    everyone = np.arange(len(q.points))
    return [
        (frame_of(j, r, then).neighbors(q, everyone), uniform())
        for j, r in kept.items()
    ]


def resampled(q, past, own, around, uniform, settings, cap):
    """The pass that the settings ask for, over what is given to it."""
    given = PassInput(q, past, own, uniform(), around)
    return closed(restir_gi.resampled(given, settings, cap))


def temporal(i, past, uniform, cap=NO_CAP, settings=DEFAULT, then=False):
    """Algorithm 3 at pixel i: a new sample, and its own past, or one of a frame ago."""
    own = drawn(i, uniform)
    q = receivers(i, len(own.M), settings)
    return resampled(q, past_of(q, past, then), own, [], uniform, settings, cap)


def spatial(
    i, past, own, others, uniform, cap=NO_CAP, settings=DEFAULT, largest=None,
    then=False,
):  # fmt: skip
    """Algorithm 4 at pixel i: its past, its own reservoir, and those of others."""
    q = receivers(i, len(own.W), settings, largest)
    around = neighbors(q, others, uniform)
    past = past_of(q, past, then)
    return resampled(q, past, own.opened(), around, uniform, settings, cap)


def of_the_past(i, own, sources, uniform, settings):
    """Pixel i's own reservoir, and those of pixel 0 a frame ago.

    With other weights and visibility it is Algorithm 4 where there is no spatial past.
    """
    q = receivers(i, len(own.W), settings)
    around = [one for r in sources for one in neighbors(q, {0: r}, uniform, then=True)]
    if settings.mis == "1/Z" and settings.visibility == "all":
        R = spatiotemporal_resampling(q, own.opened(), around, cap=NO_CAP)
        return closed(R)
    nobody = empty(len(own.W))
    return resampled(q, nobody, own.opened(), around, uniform, settings, NO_CAP)


def fused(i, past, others, uniform, settings, then=False):
    """All reuse in one pass: a new sample, its past, and others of the last frame."""
    own = drawn(i, uniform)
    q = receivers(i, len(own.M), settings)
    around = neighbors(q, others, uniform, then)
    past = past_of(q, past, then)
    return resampled(q, past, own, around, uniform, settings, NO_CAP)
