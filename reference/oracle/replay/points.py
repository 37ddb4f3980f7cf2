"""Points of the contract's buffers, as numbers with error bounds."""

from dataclasses import dataclass, replace

from restir_gi.reference.numerics.arrays import Indices, Masks
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.oracle.replay.bounded import Bounded, Rounding, exact
from restir_gi.reference.oracle.replay.materials import Material, material_of


@dataclass(frozen=True, slots=True, eq=False)
class ReceiverPoint:
    """Visible points, N rows.

    Attributes
    ----------
    position, normal, albedo : Bounded; (N, 3) each
    material : Material or None; of a declared surface; ``None`` for a Lambertian one
    number : int; column of `SamplePoint.given` that holds the targets there
    """

    position: Bounded
    normal: Bounded
    albedo: Bounded
    material: Material | None = None
    number: int = 0

    def rows(self, rows: Indices) -> "ReceiverPoint":
        """Some of the points.

        Parameters
        ----------
        rows : (K,) int
        """
        material = None if self.material is None else self.material.rows(rows)
        return ReceiverPoint(
            self.position[rows], self.normal[rows], self.albedo[rows], material
        )

    def viewed_as(self, other: "ReceiverPoint") -> "ReceiverPoint":
        """The points, but seen from where others are seen; if they have a view."""
        if self.material is None or other.material is None:
            return self
        material = replace(self.material, view=other.material.view)
        return replace(self, material=material)


@dataclass(frozen=True, slots=True, eq=False)
class SamplePoint:
    """Sample points, N rows.

    Attributes
    ----------
    position, normal, radiance : Bounded; (N, 3) each
    given : Bounded or None; (N, V), targets at V visible points, where they are data
    """

    position: Bounded
    normal: Bounded
    radiance: Bounded
    given: Bounded | None = None

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
        With ``visible_position``, ``visible_normal`` and ``albedo``, and what a
        declared surface has beside.
    """
    names = ("visible_position", "visible_normal", "albedo")
    position, normal, albedo = (exact(buffers[prefix + n], rounding) for n in names)
    material = material_of(buffers, rounding, prefix)
    return ReceiverPoint(position, normal, albedo, material)


def point_of(buffers: Buffers, rounding: Rounding, prefix: str = "") -> SamplePoint:
    """Sample points among buffers.

    Parameters
    ----------
    buffers : mapping of str to array; with ``position``, ``normal`` and ``radiance``
    """
    names = ("position", "normal", "radiance")
    return SamplePoint(*(exact(buffers[prefix + name], rounding) for name in names))


def receiver_read(case: Case, rounding: Rounding, prefix: str = "") -> ReceiverPoint:
    """Visible points of a case, to what the backend's decoder may round."""
    x = receiver_of(case.inputs, rounding, prefix)
    x = replace(x, normal=_read(case, f"{prefix}visible_normal", x.normal))
    if x.material is None:
        return x
    view = _read(case, f"{prefix}view", x.material.view)
    return replace(x, material=replace(x.material, view=view))


def sample_read(case: Case, rounding: Rounding, prefix: str = "") -> SamplePoint:
    """Sample points of a case, to what the backend's decoder may round."""
    y = point_of(case.inputs, rounding, prefix)
    normal = _read(case, f"{prefix}normal", y.normal)
    radiance = _read(case, f"{prefix}radiance", y.radiance)
    return replace(y, normal=normal, radiance=radiance)


def _read(case: Case, name: str, x: Bounded) -> Bounded:
    """A vector that came out of storage, (N, 3)."""
    if not case.decoded or name not in case.decoded:
        return x
    return Bounded(x.value, x.error + case.decoded[name][:, None], x.rounding)


def with_given(y: SamplePoint, case: Case, sample: int) -> SamplePoint:
    """Samples with their targets, where these are data.

    Parameters
    ----------
    sample : int; which of the row's, as the bits of ``visible`` count them
    """
    given = case.inputs.get("p_hat_given")
    if given is None:
        return y
    at = given.reshape(case.rows, -1, given.shape[-1] if given.ndim > 1 else 1)
    return replace(y, given=exact(at[:, :, sample], y.position.rounding))


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
