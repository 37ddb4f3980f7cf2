"""Targets that are given as data, of renderers whose BSDF nobody else evaluates."""

from dataclasses import replace

from restir_gi.reference.oracle.contract.fields import Field, given_with, real
from restir_gi.reference.oracle.contract.kernels import TARGET

DATA = "data"

TARGET_OR_DATA = replace(TARGET, more=(DATA,))
"""Of passes that evaluate the target of samples."""


def given_targets(meaning: str, *columns: int | str) -> tuple[Field, ...]:
    """The buffer of a pass, given where its target is data."""
    field = real("p_hat_given", meaning, *columns)
    return given_with(TARGET.name, (DATA,), (field,))


SEEN_ALIKE = (
    "target of each sample at each point, as `visible` counts them: [n, column, bit]"
)

CLAUSE = "a target that is given is taken as it is"

PAGE = """
## Targets as data

A renderer whose materials are not those of [Surfaces](#surfaces) may declare `target =
"data"`: then p̂ is what `p_hat_given` holds, of whatever BSDF, and nothing but the light
L_o, which says whether a sample is a null, is looked at beside it. In `moved`,
`spatial` and `fused` the buffer has a row for each point and a column for each sample,
in the order of the words and bits of `visible`: `p_hat_given[n, 0, s]` is the target of
sample s at the receiver, `p_hat_given[n, 1 + k, s]` that at the visible point of source
k, both without visibility. A source holds a sample where this is above 0 and it sees
it. Points and normals are given as always: J is calculated. Who declares no other
target is given those of the contract as data, in lattices, frames and whole runs.
"""
"""Section of the contract's page."""
