"""Groups of buffers that several passes share."""

from dataclasses import replace

from restir_gi.reference.oracle.contract.fields import Field, real, vector

RECEIVER = (
    vector("visible_position", "visible point x, m"),
    vector("visible_normal", "unit normal at x, on the side that is seen"),
    vector("albedo", "reflectance of the visible point's diffuse part"),
)

SAMPLE = (
    vector("position", "sample point x_s, m"),
    vector("normal", "unit normal at x_s, on the side that was seen"),
    vector("radiance", "radiance L_o that leaves x_s, W/(m² sr); 0 for a null"),
)

RESERVOIR = (
    *SAMPLE,
    real("W", "unbiased contribution weight, sr; 0 for an empty row"),
    real("M", "confidence weight; nulls count"),
)


def prefixed(prefix: str, fields: tuple[Field, ...]) -> tuple[Field, ...]:
    """The same buffers under longer names, in the same order.

    Parameters
    ----------
    prefix : str; put before each name, with an underscore
    """
    return tuple(replace(f, name=f"{prefix}_{f.name}") for f in fields)
