"""Passes ``pack`` and ``unpack`` of the contract: reservoirs in bits, in any layout."""

from restir_gi.reference.oracle.contract.fields import (
    Pass,
    Setting,
    bits,
    given_with,
    real,
    vector,
)
from restir_gi.reference.oracle.contract.groups import RECEIVER, RESERVOIR

PAPER, RESTIR_PT, RTXDI, RTXDI_PATH = LAYOUTS = (
    "paper",
    "restir_pt",
    "rtxdi",
    "rtxdi_path",
)

LAYOUT = Setting(
    "layout",
    PAPER,
    "which fields there are, and where they stand",
    more=(RESTIR_PT, RTXDI, RTXDI_PATH),
    default=PAPER,
)

FIELDS = (
    *given_with("layout", (PAPER, RESTIR_PT), RECEIVER[:2]),
    *RESERVOIR,
    *given_with(
        "layout",
        (PAPER, RTXDI_PATH),
        (bits("seed", "what the path was drawn with"),),
    ),
    *given_with(
        "layout",
        (RESTIR_PT, RTXDI, RTXDI_PATH),
        (bits("age", "frames that the sample has survived"),),
    ),
    *given_with(
        "layout", (RTXDI,), (bits("misc", "16 bits that are the application's own"),)
    ),
    *given_with(
        "layout",
        (RTXDI_PATH,),
        (
            bits("boosts", "1 where the next spatial reuse takes more samples, else 0"),
            bits("reconnection_vertex", "vertex where the path is joined"),
            bits("path_length", "vertices from the visible point to the light"),
            bits("random_index", "random numbers drawn before the path began"),
            real("partial_jacobian", "of the base path, as the renderer has it"),
            real("onward_pdf", "density of the direction onward from there, 1/sr"),
            vector("target_function", "a colour, of which p̂ is the luminance"),
            bits("on_light", "1 where the path is joined at a sampled light, else 0"),
            bits("light", "which light that is; 0 without one"),
            bits("light_place", "where on it; 0 without one"),
        ),
    ),
)

WORDS = (
    *given_with(
        "layout",
        (PAPER, RESTIR_PT),
        (bits("words", "48 bytes, as twelve little-endian words", 12),),
    ),
    *given_with(
        "layout",
        (RTXDI,),
        (bits("words", "32 bytes, as eight little-endian words", 8),),
    ),
    *given_with(
        "layout",
        (RTXDI_PATH,),
        (bits("words", "64 bytes, as sixteen little-endian words", 16),),
    ),
)

_PLACES = (
    "paper: words 0 to 2: visible_position, three float32; 3: visible_normal; "
    "4 to 6: position; 7: normal; 8: red in bits 15:0, green in 31:16; "
    "9: blue in bits 15:0, M in 31:16; 10: W, float32; 11: seed;\n"
    "restir_pt: the same, but for word 11: age;\n"
    "rtxdi: words 0 to 2: position, three float32; 3: M in bits 7:0, age in 15:8, misc "
    "in 31:16; 4: radiance in LogLuv; 5: W, float32; 6: normal; 7: not used;\n"
    "rtxdi_path: words 0 to 2: position, three float32; 3: W, float32; 4: x of the "
    "normal in bits 15:0, y in 31:16; 5: z in bits 15:0, M in 31:16; "
    "6: partial_jacobian, 7: onward_pdf, float32; 8 to 10: radiance, three float32, or "
    "where on_light is 1 infinity, light, light_place; 11: age in bits 4:0, boosts in "
    "7, reconnection_vertex in 15:8, path_length in 23:16, random_index in 31:24; "
    "12 to 14: target_function, three float32; 15: seed;\n"
)

PACK = Pass(
    name="pack",
    summary="A reservoir in 48 bytes, or in another layout",
    formula=(
        _PLACES + "paper, restir_pt: red, green, blue of the radiance are float16, M is"
        " a uint16;\n"
        "rtxdi: M is a uint8, and given whole, age too; what is larger becomes 255; "
        "L = ⌊409.6 (log₂ Y + 20)⌋, from 0 to 16383, in bits 31:18; "
        "⌊820 · 4X / (X + 15Y + 3Z)⌋ in 17:9, ⌊820 · 9Y / (X + 15Y + 3Z)⌋ in 8:0; "
        "0 where L = 0; X, Y, Z of Rec. 709 with white at (0.3127, 0.3290);\n"
        "rtxdi_path: M is a float16; of age the low five bits are kept;\n"
        "normals but those of rtxdi_path: s = |x| + |y| + |z|, (u, v) = (x, y) / s, and"
        " where z < 0 (u, v) = "
        "((1 − |v|) sign u, (1 − |u|) sign v), with sign 0 = +1; the int16 of 32767 u "
        "in bits 15:0, of 32767 v in 31:16, in two's complement; (0, 0) for a normal "
        "of 0;\n"
        "those of rtxdi_path: three uint16 of 32767 (n + 1);\n"
        "all rounded to nearest, but the three of LogLuv; what is too large becomes the"
        " largest number of its field, never infinity; a positive M becomes at least "
        "1, but as a float16;\n"
        "judged as pass unpack reads it.  Errors: float32 relative 2⁻²⁴; a channel in "
        "float16 relative 2⁻¹¹, below 2⁻¹⁴ absolute 2⁻²⁵; octahedral normals 6.474e-5 "
        "radians, a component of the others 1/2 of 1/32767; M "
        "1/2, and none where it is whole; M in float16 relative 2⁻¹⁰, and none where it"
        " is one; LogLuv none but where rounding leaves a cell open; others none"
    ),
    inputs=FIELDS,
    outputs=WORDS,
    settings=(LAYOUT,),
    source="docs/reference/packing.md; fields of [Ouyang21, section 5]",
    clauses=(
        "the fields stand in their places",
        "the lower half of normals is folded",
        "normals are divided by |x| + |y| + |z|",
        "the sign of 0 is +1",
        "numbers are rounded to nearest",
        "what is too large becomes the largest",
        "small halves are kept",
        "a positive M becomes 1 at least",
        "restir_pt: the last word is the age",
        "rtxdi: the fields stand in their places",
        "rtxdi: M and age are 255 at most",
        "rtxdi: the application's bits are kept",
        "rtxdi: L is a logarithm to the base 2",
        "rtxdi: level and chromaticities are rounded down",
        "rtxdi: u′ stands above v′",
        "rtxdi_path: the fields stand in their places",
        "rtxdi_path: a component of 0 has the code 32767",
        "rtxdi_path: components are rounded to nearest",
        "rtxdi_path: M is a half, 65504 at most",
        "rtxdi_path: of an age five bits are kept",
        "rtxdi_path: a light that was sampled has an infinite red",
    ),
)

UNPACK = Pass(
    name="unpack",
    summary="A reservoir from 48 bytes, or from another layout",
    formula=(
        _PLACES + "normals but those of rtxdi_path: (u, v) from two int16, −32768 read"
        " as −32767, divided by "
        "32767; z = 1 − |u| − |v|; where z < 0, (u, v) = ((1 − |v|) sign u, "
        "(1 − |u|) sign v); (u, v, z) normalized;\n"
        "those of rtxdi_path: three uint16, less 32767, 65535 read as 65534; "
        "normalized; 32767 in all three is no direction, and not asked;\n"
        "LogLuv: Y = 2^((L + 1/2) / 409.6 − 20), u′ = (u + 1/2) / 820, v′ = (v + 1/2) /"
        " 820; X = 9u′ Y / 4v′, Z = (12 − 3u′ − 20v′) Y / 4v′; channels below 0 become "
        "0; black where L = 0;\n"
        "on_light is 1 where red is infinite: then radiance is 0; else light and "
        "light_place are;\n"
        "numbers as they stand, also subnormal halves; of paper and restir_pt infinity "
        "is read as the largest number of its field, with its sign, and NaN as 0"
    ),
    inputs=WORDS,
    outputs=FIELDS,
    settings=(LAYOUT,),
    source="docs/reference/packing.md",
    clauses=(
        "the fields stand in their places",
        "the lower half of normals is folded",
        "codes have a sign, and −32768 is −32767",
        "M has no sign",
        "normals are made unit vectors",
        "small halves are kept",
        "infinity is the largest number, NaN is 0",
        "restir_pt: the last word is the age",
        "rtxdi: the fields stand in their places",
        "rtxdi: a cell is read at its middle",
        "rtxdi: L is a logarithm to the base 2",
        "rtxdi: u′ stands above v′",
        "rtxdi: channels are 0 at least",
        "rtxdi_path: the fields stand in their places",
        "rtxdi_path: a component of 0 has the code 32767",
        "rtxdi_path: normals are made unit vectors",
        "rtxdi_path: M is a half",
        "rtxdi_path: an age has five bits",
        "rtxdi_path: an infinite red stands for a light",
    ),
)
