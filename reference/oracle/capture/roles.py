"""What the buffers of a frame are, in the words of the contract."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from restir_gi.reference.oracle.contract.fields import Field, bits, index, real, vector
from restir_gi.reference.oracle.contract.groups import RECEIVER, RESERVOIR
from restir_gi.reference.oracle.contract.surfaces import MATERIAL

TARGETS = re.compile(r"targets_[a-z][a-z_]*")
"""Names of roles that hold targets; which ones they are is in the rest of the name."""


@dataclass(frozen=True, slots=True)
class Role:
    """What a buffer is for a frame.

    Attributes
    ----------
    meaning : str; and when in the frame it is copied
    fields : tuple of Field; that buffers of this role may have
    """

    meaning: str
    fields: tuple[Field, ...]

    def field(self, name: str) -> Field | None:
        """The field of a name."""
        return next((field for field in self.fields if field.name == name), None)


VISIBLE_POINTS = (
    *RECEIVER,
    real("depth", "view depth along the camera's axis, m; 0 where nothing is seen"),
    *MATERIAL,
)

SAMPLES = (
    *RESERVOIR,
    real("pdf", "source density of the sample, 1/sr"),
    real("p_hat", "target p̂ of the sample at this pixel"),
    real("w_sum", "sum of the weights w of the stream; W = w_sum / (M p_hat)"),
    *RECEIVER[:2],
    bits("age", "frames since the sample was drawn"),
    bits("seed", "what the path of the sample was drawn with"),
    bits("misc", "bits of the application's own"),
)

ROLES: Mapping[str, Role] = {
    "gbuffer": Role("visible points of this frame", VISIBLE_POINTS),
    "previous_gbuffer": Role(
        "visible points of the frame before, as this one reads them; by default those"
        " of the captured frame before",
        VISIBLE_POINTS,
    ),
    "initial": Role("new samples, before any reuse", SAMPLES),
    "temporal": Role("reservoirs after temporal reuse", SAMPLES),
    "spatial": Role("reservoirs after spatial reuse", SAMPLES),
    "fused": Role("reservoirs after one pass that is both in one", SAMPLES),
    "history": Role(
        "which pixel of the frame before each pixel continues",
        (index("row", "row of the history pixel, or −1"),),
    ),
    "neighbors": Role(
        "which pixels each pixel reuses",
        (index("neighbors", "row of each neighbour, or −1", "K"),),
    ),
    "sources": Role(
        "which pixels of the frame before each pixel reuses in a fused pass: the one"
        " that it continues, too",
        (index("sources", "row of each source, or −1", "K"),),
    ),
    "visible_temporal": Role(
        "what the temporal pass knows of visibility",
        (
            bits(
                "visible",
                "who sees which sample, as pass moved of the contract has it",
                "K",
            ),
        ),
    ),
    "visible_spatial": Role(
        "what the spatial pass knows of visibility",
        (
            bits(
                "visible",
                "who sees which sample, as pass spatial of the contract has it",
                "K",
            ),
        ),
    ),
    "visible_fused": Role(
        "what the fused pass knows of visibility",
        (
            bits(
                "visible",
                "who sees which sample, as pass fused of the contract has it",
                "K",
            ),
        ),
    ),
    "visible_shade": Role(
        "whether the pixel sees the sample that it is shaded with",
        (bits("visible", "1 where it does, else 0"),),
    ),
    "shade": Role(
        "light that the pixel is shaded with",
        (vector("color", "indirect radiance towards the camera, W/(m² sr)"),),
    ),
}
"""All roles but those of targets."""

TARGET_VALUES = Role(
    "targets p̂ that a pass worked with, such as targets_spatial",
    (real("p_hat", "targets, as many numbers a pixel as there are", "K"),),
)


def role_of(name: str) -> Role | None:
    """The role of a name."""
    return TARGET_VALUES if TARGETS.fullmatch(name) else ROLES.get(name)
