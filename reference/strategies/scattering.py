"""Points on surfaces of every material."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from restir_gi.reference.numerics.arrays import dot
from restir_gi.reference.scene.materials.kinds import (
    Coated,
    Conductor,
    Dielectric,
    Lambertian,
    Material,
    mirror,
)
from restir_gi.reference.scene.materials.parameters import Kind, MaterialTable, tabulate
from restir_gi.reference.scene.surface import SurfacePoints
from restir_gi.reference.strategies.geometry import (
    directions_above,
    points,
    unit_vectors,
)
from restir_gi.reference.strategies.numbers import ROWS

COLOR = (0.8, 0.5, 0.2)

EXAMPLES: dict[Kind, list[Material]] = {
    Kind.LAMBERTIAN: [Lambertian(COLOR), Lambertian(COLOR, two_sided=False)],
    Kind.ROUGH_CONDUCTOR: [
        Conductor(COLOR, 0.3),
        Conductor((1.0, 1.0, 1.0), 0.6, eta=(0.2, 0.9, 1.1), k=(3.9, 2.4, 2.2)),
        Conductor(COLOR, 1.0, schlick=True),
        Conductor(COLOR, 0.15, two_sided=False),
        Conductor(COLOR, 0.3, distribution="beckmann"),
    ],
    Kind.SMOOTH_CONDUCTOR: [
        mirror(COLOR),
        Conductor((1.0, 1.0, 1.0), 0.0, eta=(0.2, 0.9, 1.1), k=(3.9, 2.4, 2.2)),
    ],
    Kind.ROUGH_COATED: [
        Coated(COLOR, 0.3),
        Coated(COLOR, 0.5, ior=1.8, nonlinear=True),
        Coated((0.0, 0.0, 0.0), 0.3, two_sided=False),
        Coated(COLOR, 0.3, distribution="beckmann"),
    ],
    Kind.SMOOTH_COATED: [
        Coated(COLOR, 0.0),
        Coated(COLOR, 0.0, ior=1.8, nonlinear=True, two_sided=False),
    ],
    Kind.DIELECTRIC: [Dielectric(1.5), Dielectric(1.0 / 1.5)],
    Kind.ROUGH_DIELECTRIC: [
        Dielectric(1.5, 0.3),
        Dielectric(1.0 / 1.5, 0.6, "beckmann"),
    ],
}
"""Materials of each kind, one for each branch of its code."""


def materials(*kinds: Kind) -> st.SearchStrategy[Material]:
    """Materials of given kinds, of all kinds where none is named.

    One of ``EXAMPLES``: the tables of a coat are not cheap.
    """
    chosen = kinds or tuple(Kind)
    return st.sampled_from([m for kind in chosen for m in EXAMPLES[kind]])


@dataclass(frozen=True, slots=True)
class Surfaces:
    """Points on surfaces, with the table of their materials."""

    table: MaterialTable
    points: SurfacePoints


@st.composite
def surfaces(
    draw: st.DrawFn,
    *kinds: Kind,
    rows: int = ROWS,
    smooth: bool | None = None,
    least: float = 0.01,
) -> Surfaces:
    """Points seen from above, on materials of given kinds.

    Fronts and backs; the viewer is above geometric and shading normal.

    Parameters
    ----------
    *kinds : Kind; kinds of material, all where none is named
    smooth : bool or None
        Whether the points have shading normals of their own; ``None``: either.
    least : float; smallest cosine of the viewer with the shading normal
    """
    table = tabulate(draw(st.lists(materials(*kinds), min_size=1, max_size=3)))
    index = st.integers(0, len(table.kind) - 1)
    material = draw(arrays(np.int32, rows, elements=index))
    wo = draw(unit_vectors(rows))
    normal = draw(directions_above(wo, least))
    shading = None
    if draw(st.booleans()) if smooth is None else smooth:
        other = draw(directions_above(wo, least))
        # In the hemisphere of the geometric normal, as interpolation leaves it.
        shading = np.where((dot(other, normal) > 0)[:, None], other, normal)
    found = SurfacePoints(
        position=draw(points(rows=rows)),
        normal=normal,
        smooth=shading,
        wo=wo,
        color=np.take(table.color, material, axis=0),
        material=material,
        primitive=np.arange(rows, dtype=np.int32),
        front=draw(arrays(bool, rows)),
    )
    return Surfaces(table, found)
