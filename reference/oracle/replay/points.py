"""Points of the contract's buffers, as numbers with error bounds."""

from dataclasses import dataclass

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, exact


@dataclass(frozen=True, slots=True, eq=False)
class ReceiverPoint:
    """Visible points, N rows.

    Attributes
    ----------
    position, normal, albedo : Bounded; (N, 3) each
    """

    position: Bounded
    normal: Bounded
    albedo: Bounded

    def rows(self, rows: Indices) -> "ReceiverPoint":
        """Some of the points.

        Parameters
        ----------
        rows : (K,) int
        """
        return ReceiverPoint(self.position[rows], self.normal[rows], self.albedo[rows])


@dataclass(frozen=True, slots=True, eq=False)
class SamplePoint:
    """Sample points, N rows.

    Attributes
    ----------
    position, normal, radiance : Bounded; (N, 3) each
    """

    position: Bounded
    normal: Bounded
    radiance: Bounded

    def rows(self, rows: Indices) -> "SamplePoint":
        """Some of the points.

        Parameters
        ----------
        rows : (K,) int
        """
        return SamplePoint(self.position[rows], self.normal[rows], self.radiance[rows])


def receiver_of(
    buffers: Buffers, rounding: Rounding, prefix: str = ""
) -> ReceiverPoint:
    """Visible points among buffers.

    Parameters
    ----------
    buffers : mapping of str to array
        With ``visible_position``, ``visible_normal`` and ``albedo``.
    """
    names = ("visible_position", "visible_normal", "albedo")
    return ReceiverPoint(*(exact(buffers[prefix + name], rounding) for name in names))


def point_of(buffers: Buffers, rounding: Rounding, prefix: str = "") -> SamplePoint:
    """Sample points among buffers.

    Parameters
    ----------
    buffers : mapping of str to array; with ``position``, ``normal`` and ``radiance``
    """
    names = ("position", "normal", "radiance")
    return SamplePoint(*(exact(buffers[prefix + name], rounding) for name in names))


def same_points(buffers: Buffers, y: SamplePoint) -> Masks:
    """Whether buffers hold the very numbers of sample points.

    Parameters
    ----------
    buffers : mapping of str to array; with ``position``, ``normal`` and ``radiance``

    Returns
    -------
    (N,) bool; copying does not round
    """
    same: Masks = (buffers["position"] == y.position.value).all(axis=1)
    same &= (buffers["normal"] == y.normal.value).all(axis=1)
    same &= (buffers["radiance"] == y.radiance.value).all(axis=1)
    return same
