"""Hypothesis strategies that construct valid input, for the tests here and for yours.

Each takes the number of rows (a *batch*) and makes whole arrays; nothing is filtered
away, so no example is thrown out.  Values span what a scene may hold, their ends
included; what lies beyond is in :mod:`restir_gi.reference.strategies.extremes`.
Hypothesis comes with ``pip install '.[test]'``.

>>> from hypothesis import given
>>> @given(views_of_a_patch(rows=2))
... def test(views):
...     assert views.eyes[0].shape == views.position.shape == (2, 3)
>>> test()
"""

from restir_gi.reference.strategies.extremes import (
    extreme_offsets,
    extreme_uniforms,
    extreme_weights,
    grazing_directions,
)
from restir_gi.reference.strategies.geometry import (
    Views,
    colors,
    directions_above,
    points,
    samples,
    unit_vectors,
    views_of_a_patch,
)
from restir_gi.reference.strategies.numbers import (
    ROWS,
    cuts,
    draws,
    scalars,
    tabled_uniforms,
    uniforms,
)
from restir_gi.reference.strategies.resampling import candidates, reservoirs
from restir_gi.reference.strategies.scattering import (
    COLOR,
    EXAMPLES,
    Surfaces,
    materials,
    surfaces,
)

__all__ = [
    "COLOR",
    "EXAMPLES",
    "ROWS",
    "Surfaces",
    "Views",
    "candidates",
    "colors",
    "cuts",
    "directions_above",
    "draws",
    "extreme_offsets",
    "extreme_uniforms",
    "extreme_weights",
    "grazing_directions",
    "materials",
    "points",
    "reservoirs",
    "samples",
    "scalars",
    "surfaces",
    "tabled_uniforms",
    "uniforms",
    "unit_vectors",
    "views_of_a_patch",
]
