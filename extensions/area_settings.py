"""Settings of Area ReSTIR."""

from dataclasses import dataclass

from restir_gi.extensions.area_shift import Primary
from restir_gi.extensions.pt_settings import PathSettings


@dataclass(frozen=True, slots=True, kw_only=True)
class AreaSettings(PathSettings):
    """Settings of Area ReSTIR: those of ReSTIR PT, and what becomes of the primary hit.

    Attributes
    ----------
    primary : 'move' or 'keep'
        Whether paths of the last frame keep their place in the pixel, so that x_1
        moves, or keep x_1, so that its place does.
    """

    primary: Primary = "move"

    def __post_init__(self) -> None:
        PathSettings.__post_init__(self)
        if self.mis == "1/M":
            raise ValueError(
                "mis=1/M counts pixels that could not have made the sample; use 1/Z,"
                " balance, pairwise or defensive"
            )
