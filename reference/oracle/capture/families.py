"""What renderers of a family dump, buffer by buffer, and what they declare."""

from collections.abc import Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Dump:
    """A buffer to be copied in each frame.

    Attributes
    ----------
    name : str; of its table in the manifest
    form : str; of an element, as an engineer says it
    when : str; in the frame it is copied
    otherwise : str; what to do where an engine does not have it
    keys : str; of its table, as TOML has them
    optional : bool; its table is commented out
    """

    name: str
    form: str
    when: str
    otherwise: str
    keys: str
    optional: bool = False


CAPS = """\
# Say what limits M, where something does, and how visible points scatter.
[passes.temporal]
# cap = 20
# surface = "ggx"

[passes.spatial]
# cap = 500
# surface = "ggx"
"""


@dataclass(frozen=True, slots=True)
class Family:
    """Renderers of one layout.

    Attributes
    ----------
    title : str; whose layout it is
    dumps : tuple of Dump; in the order of a frame
    declaration : str; keys of a declaration that is typical, as TOML has them
    passes : str; of the manifest, likewise
    """

    title: str
    dumps: tuple[Dump, ...]
    declaration: str
    passes: str = CAPS


POSITION = Dump(
    "gbuffer-position",
    "RGBA32F: world position x, y, z; the fourth is not read",
    "after the G-buffer is filled",
    "give `depth` and `cameras` instead: positions then follow from them",
    """\
role = "gbuffer"
file = "gbuffer-position.{frame}.bin"
stride = 16
fields = [
    { name = "visible_position", kind = "float32" },
]
""",
)
NORMAL = Dump(
    "gbuffer-normal",
    "RGBA32F: unit normal, on the side that is seen; the fourth is not read",
    "with the position",
    "dump the normal that the resampling uses, in the bits that it reads: `kind` has"
    " octahedral and normalized formats",
    """\
role = "gbuffer"
file = "gbuffer-normal.{frame}.bin"
stride = 16
fields = [
    { name = "visible_normal", kind = "float32" },
]
""",
)
ALBEDO = Dump(
    "gbuffer-albedo",
    "RGBA32F: diffuse reflectance, linear; the fourth is not read",
    "with the position",
    "of a material that is not Lambertian dump `alpha`, `f0` and `view`, too",
    """\
role = "gbuffer"
file = "gbuffer-albedo.{frame}.bin"
stride = 16
fields = [
    { name = "albedo", kind = "float32" },
]
""",
)
DEPTH = Dump(
    "gbuffer-depth",
    "R32F: depth along the camera's axis, m; 0 where nothing is seen",
    "with the position",
    "leave it out; pixels are then not asked whether they are alike in depth",
    """\
role = "gbuffer"
file = "gbuffer-depth.{frame}.bin"
fields = [
    # A depth buffer: given = "device", with cameras.inverse_view_projection.
    { name = "depth", kind = "float32", given = "view", none = 0 },
]
""",
)

RTXDI_NORMAL = replace(
    NORMAL,
    form="R32_UINT: octahedral, two 16-bit numbers of 0 to 65534",
    otherwise="dump the normal that the resampling reads, not the geometric one; for"
    " floats see the kinds in the documentation",
    keys="""\
role = "gbuffer"
file = "gbuffer-normal.{frame}.bin"
fields = [
    { name = "visible_normal", kind = "octahedral-unorm16", unit = 65534 },
]
""",
)
RTXDI_ALBEDO = replace(
    ALBEDO,
    form="R32_UINT: diffuse albedo as 11, 11 and 10 bits of floats",
    keys="""\
role = "gbuffer"
file = "gbuffer-albedo.{frame}.bin"
fields = [
    { name = "albedo", kind = "r11g11b10f" },
]
""",
)
RTXDI_DEPTH = replace(
    DEPTH,
    form="R32F: view depth; 65504 where nothing is seen",
    keys="""\
role = "gbuffer"
file = "gbuffer-depth.{frame}.bin"
fields = [
    # `none`: the depth of the background in your shaders.
    { name = "depth", kind = "float32", given = "view", none = 65504 },
]
""",
)

INITIAL = Dump(
    "initial",
    "reservoir",
    "after the new samples are made, before any reuse",
    "store each new sample as a reservoir of its own: W = 1 / pdf, M = 1; a ray that"
    " met nothing has radiance 0 and counts, too",
    "",
)
TEMPORAL = Dump(
    "temporal",
    "reservoir",
    "after temporal reuse, before spatial reuse",
    "leave it out where there is no temporal pass; where one pass does both, dump"
    " `fused` and `sources` in place of all this",
    "",
)
SPATIAL = Dump(
    "spatial",
    "reservoir",
    "after spatial reuse, or the last of several such passes",
    "leave it out where there is no spatial pass",
    "",
)
FUSED = Dump(
    "fused",
    "reservoir",
    "after the one pass that is temporal and spatial reuse in one",
    "leave it out where there are two passes; else leave out `history`, `temporal`,"
    " `neighbors` and `spatial`, and name the pass `[passes.fused]`",
    "",
    optional=True,
)
SOURCES = Dump(
    "sources",
    "two R32_SINT a pixel: y · width + x of each source in the frame before, −1 for"
    " none",
    "written by the fused pass itself: those that it has merged, in its order",
    "they are needed for the fused pass alone; pixels x, y will do: `given`",
    """\
file = "sources.{frame}.bin"
fields = [
    # count: how many sources, of pairs x, y twice as many.
    { name = "sources", kind = "int32", count = 2, given = "rows" },
]
""",
    optional=True,
)
HISTORY = Dump(
    "history",
    "R32_SINT: y · width + x of the history pixel, −1 for none",
    "written by the temporal pass itself: the pixel whose reservoir it has taken",
    "write each pixel's own number where nothing moves; a pixel x, y will do, as two"
    ' numbers with given = "pixels"',
    """\
file = "history.{frame}.bin"
fields = [
    { name = "row", kind = "int32" },
]
""",
)
NEIGHBORS = Dump(
    "neighbors",
    "two R32_SINT a pixel: y · width + x of each neighbour, −1 for none",
    "written by the spatial pass itself: those that it has merged, in its order",
    "they are needed for the spatial pass; pixels or offsets x, y will do: `given`",
    """\
file = "neighbors.{frame}.bin"
fields = [
    # count: how many neighbours, of pairs x, y twice as many.
    { name = "neighbors", kind = "int32", count = 2, given = "rows" },
]
""",
)
VISIBLE_TEMPORAL = Dump(
    "visible_temporal",
    "two R32_UINT a pixel: masks of who sees which sample, as pass `moved` of the"
    " contract has them",
    "written by the temporal pass, if it traces rays",
    "leave it out; rays are traced where a scene is given, or else all is taken to be"
    " visible",
    """\
file = "visible_temporal.{frame}.bin"
fields = [
    { name = "visible", kind = "uint32", count = 2 },
]
""",
    optional=True,
)
VISIBLE_SPATIAL = Dump(
    "visible_spatial",
    "R32_UINT for the pixel and for each neighbour: masks of who sees which sample, as"
    " pass `spatial` of the contract has them",
    "written by the spatial pass, if it traces rays",
    VISIBLE_TEMPORAL.otherwise,
    """\
file = "visible_spatial.{frame}.bin"
fields = [
    { name = "visible", kind = "uint32", count = 3 },
]
""",
    optional=True,
)
VISIBLE_FUSED = Dump(
    "visible_fused",
    "R32_UINT for the pixel and for each source: masks of who sees which sample, as"
    " pass `fused` of the contract has them",
    "written by the fused pass, if it traces rays",
    VISIBLE_TEMPORAL.otherwise,
    """\
file = "visible_fused.{frame}.bin"
fields = [
    { name = "visible", kind = "uint32", count = 3 },
]
""",
    optional=True,
)
VISIBLE_SHADE = Dump(
    "visible_shade",
    "R32_UINT: 1 where the pixel sees the sample that it is shaded with, else 0",
    "written by the shading, if it traces a ray",
    "leave it out where the shading traces no ray",
    """\
file = "visible_shade.{frame}.bin"
fields = [
    { name = "visible", kind = "uint32" },
]
""",
    optional=True,
)
SHADE = Dump(
    "shade",
    "RGBA32F: indirect light that the pixel is shaded with, before any denoiser; the"
    " fourth is not read",
    "after the shading",
    "leave it out",
    """\
file = "shade.{frame}.bin"
stride = 16
fields = [
    { name = "color", kind = "float32" },
]
""",
    optional=True,
)


def _reservoirs(form: str, keys: str) -> tuple[Dump, ...]:
    """All kinds of reservoirs, in one layout."""
    return tuple(
        replace(
            dump,
            form=form,
            keys=f'file = "{dump.name}.{{frame}}.bin"\n{keys}',
        )
        for dump in (INITIAL, TEMPORAL, SPATIAL, FUSED)
    )


def _frame(gbuffer: tuple[Dump, ...], reservoirs: tuple[Dump, ...]) -> tuple[Dump, ...]:
    """All that a frame has, in the order of its passes."""
    initial, temporal, spatial, fused = reservoirs
    return (
        *gbuffer,
        initial,
        HISTORY,
        temporal,
        VISIBLE_TEMPORAL,
        NEIGHBORS,
        spatial,
        VISIBLE_SPATIAL,
        SOURCES,
        fused,
        VISIBLE_FUSED,
        SHADE,
        VISIBLE_SHADE,
    )


PLAIN = (POSITION, NORMAL, ALBEDO, DEPTH)
IN_FIELDS = """\
stride = 48
fields = [
    { name = "position", kind = "float32", offset = 0 },
    { name = "W", kind = "float32", offset = 12 },
    { name = "normal", kind = "float32", offset = 16 },
    { name = "M", kind = "float32", offset = 28 },
    { name = "radiance", kind = "float32", offset = 32 },
    # A sum of weights in place of W: name = "w_sum", beside "p_hat" and "M".
]
"""

FAMILIES: Mapping[str, Family] = {
    "rtxdi": Family(
        "RTXDI",
        _frame(
            (POSITION, RTXDI_NORMAL, RTXDI_ALBEDO, RTXDI_DEPTH),
            _reservoirs(
                "packed GI reservoir, 32 bytes, in blocks of 16 x 16 pixels",
                """\
layout = "rtxdi"
# Of a copy of all reservoir arrays say how many, and which of them this is:
# slots = 2
# slot = 0
""",
            ),
        ),
        """\
[choices]
generator = "own"         # its own random numbers
order = "own-first"       # the pixel's own sample, then the history, then neighbours
cap = "on arrival"        # M of the history is limited when it is read
mis = "balance"           # biasCorrectionMode; where that is off: "1/M"
mis_jacobian = false      # the weights compare densities each in its own measure
visibility = "shading"    # a ray in the final shading, none in the weights
# Mode "basic" takes sources to see what they are asked about, which is biased; for
# "ray traced" take this out, and dump what the rays found, or name the scene.
visibility_in_domain = false
M.whole = true            # M is stored in 8 bits
M.most = 255
boiling = true            # enableBoilingFilter
max_age = [15, 30]        # the sample application draws a limit; the library has 30

[choices.jacobian]
refused = [0.1, 10]       # as the sample application validates it
clamped = ["1/3", 3]
""",
        """\
[passes.temporal]
cap = 8  # maxHistoryLength
# surface = "ggx"  # where RAB_GetGISampleTargetPdfForSurface has a lobe

[passes.spatial]
# surface = "ggx"

# The fused pass, in place of both: dump `fused` and `sources`.
# [passes.fused]
# cap = 8
""",
    ),
    "restir_pt": Family(
        "ReSTIR_PT's screen-space ReSTIR GI",
        _frame(
            PLAIN,
            _reservoirs(
                "three words of four times 32 bits, 48 bytes, in rows",
                """\
layout = "restir_pt"
# Of a copy of the whole buffer say how many slots it has, and which this is; even ones
# are temporal, odd ones spatial:
# slots = 2
# slot = 0
""",
            ),
        ),
        """\
[choices]
generator = "own"         # its own random numbers
order = "own-first"       # the pixel's own sample, then the history, then neighbours
storage = "packed"        # radiance in halves, normals in two 16-bit numbers
M.whole = true            # M is stored in 16 bits
M.most = 65535
target.luminance = "rec601"

[choices.spatial]
W_most = 10               # W is cut after spatial reuse
""",
    ),
    "paper": Family(
        "the paper",
        _frame(
            PLAIN,
            _reservoirs(
                "48 bytes, as the documentation of packing has them, in rows",
                'layout = "paper"\n',
            ),
        ),
        """\
[choices]
generator = "own"         # its own random numbers
storage = "packed"        # radiance in halves, normals in two 16-bit numbers
M.whole = true            # M is stored in 16 bits
M.most = 65535
""",
        """\
[passes.temporal]
cap = 30

[passes.spatial]
cap = 500
""",
    ),
    "fields": Family(
        "an engine of its own layout",
        _frame(PLAIN, _reservoirs("struct of 48 bytes, field by field", IN_FIELDS)),
        """\
[choices]
generator = "own"         # its own random numbers
# order = "own-first"     # the pixel's own sample comes first in the stream
# cap = "on arrival"      # M is limited when it is read; else when it is stored
# mis = "1/M"             # "1/Z", "balance", "pairwise", ...
# visibility = "shading"  # a ray in the final shading, none in the weights
""",
    ),
}
"""By the words of ``restir capture-template --layout``."""
