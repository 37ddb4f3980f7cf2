"""What a frame of a gradient-domain method leaves behind."""

from dataclasses import dataclass

import numpy as np

from extensions.area_donor import AreaShift
from extensions.frame_loop import Moment, PathFrame
from gradient_domain.differences import Differences
from gradient_domain.paired_domain import MINUS, contribution
from gradient_domain.pairs import Pairs, as_differences
from gradient_domain.shifts import InnerShift
from reference.arrays import Vec3s
from reference.resampling.reservoir import Reservoirs
from reference.world import World


@dataclass(frozen=True, slots=True)
class BySign:
    """What pairs keep, P rows.

    Attributes
    ----------
    plus : Reservoirs
        Of `PairedPaths`, for the positive part; for magnitudes where ``minus`` is not
        there.
    minus : Reservoirs or None; for the negative part
    """

    plus: Reservoirs
    minus: Reservoirs | None = None

    @property
    def parts(self) -> list[Reservoirs]:
        """One of both signs, or one each."""
        return [self.plus] if self.minus is None else [self.plus, self.minus]

    def of(self, sign: int) -> Reservoirs:
        """The reservoirs of a sign."""
        return self.parts[1 if sign == MINUS else 0]


@dataclass(frozen=True, slots=True, eq=False)
class GradientFrame(PathFrame):
    """A frame of pixels, and of differences: what an image is reconstructed from.

    Attributes
    ----------
    differences : Differences; of neighbouring pixels, N rows
    pairs : BySign or None; P rows; ``None`` where pairs keep nothing
    """

    differences: Differences
    pairs: BySign | None = None

    @property
    def estimates(self) -> Vec3s:
        """(N, 9): pixels, and differences to the right and down.

        Their means over frames are what an image is best reconstructed from.
        """
        d = self.differences
        return np.concatenate([self.color, d.x, d.y], axis=1)


def gradient_frame(
    moment: Moment,
    primal: Reservoirs,
    pairs: Pairs,
    delta: Vec3s,
    held: BySign | None = None,
) -> GradientFrame:
    """A frame from what its passes have found.

    Parameters
    ----------
    delta : (P, 3) float64; Δ of each
    """
    color = primal.y.paths.value * primal.W[:, None]
    found = as_differences(pairs, delta, moment.pixels)
    now = moment.number, moment.world, moment.visible
    return GradientFrame(*now, primal, color, found, held)


def inner_shift(moment: Moment, world: World) -> InnerShift:
    """Shift between the pixels of pairs.

    Parameters
    ----------
    world : World; of this frame, or of the last
    """
    return InnerShift(AreaShift(moment.shift, "move", world, world))


def estimate(parts: list[Reservoirs]) -> Vec3s:
    """What reservoirs of pairs say of differences.

    Parameters
    ----------
    parts : list of Reservoirs
        Of `PairedPaths`, K rows each: of both signs, or of both k.

    Returns
    -------
    (K, 3) float64; sum of contributions times W
    """
    terms = [contribution(r.y.value) * r.W[:, None] for r in parts]
    return sum(terms[1:], terms[0])
