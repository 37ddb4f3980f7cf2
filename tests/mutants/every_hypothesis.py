"""Every known mistake is planted: as an edit of the code, or by a backend by hand.

A hypothesis calculates what a backend with the mistake would answer.  Here the mistake
is made from its words and by other code, so that a hypothesis that calculates something
else is found out.  Most stand in the catalogues beside this module; these are the rest.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from restir_gi.gradient_domain.oracle.mistakes import GRADIENT_MISTAKES
from restir_gi.hashgrid.oracle.mistakes import HASH_GRID_MISTAKES, OF_JACOBIANS
from restir_gi.reference.oracle.builtin.backend import FLOAT32
from restir_gi.reference.oracle.cases import Buffers, Case
from restir_gi.reference.resampling.packing.paper import RESERVOIR as RECORD
from tests.mutants import pairs_by_hand, reuse_by_hand, shift_of_tables
from tests.mutants.catalogue import (
    CAP,
    CLOSED,
    COSINE_SAMPLE,
    COSINES,
    COULD,
    FACES,
    GBUFFER,
    LIGHT,
    LIMITED,
    LUMINANCE,
    MIS,
    MUTANTS,
    OUTGOING,
    PAST,
    PAST_S,
    PHI,
    REUSED,
    SAMPLING,
    SCALE,
    SHIFT,
    SPATIAL,
    SUM_M,
    TARGET,
    TEMPORAL,
    TERMS,
    UNIFORM_SAMPLE,
    Mutant,
)
from tests.mutants.catalogue import RESERVOIR as RESERVOIRS
from tests.mutants.further import (
    BOILING,
    CAMERA,
    CHECKERBOARD,
    FURTHER_MUTANTS,
    OCTAHEDRAL,
    OWN,
    PAPER,
    REPROJECT,
    SAME,
    TURN,
    VALIDATION,
)
from tests.mutants.hash_grid import HASH_GRID_MUTANTS
from tests.mutants.hash_grid_by_hand import answer_by_hand
from tests.mutants.plant import planted
from tests.mutants.reuse import ARRIVING, ENGINE, REUSE_MUTANTS
from tests.mutants.shifts import SHIFT_MUTANTS, SHIFTING, SPREAD

Edit = tuple[str, str, str]
Answer = Callable[[Case], Buffers]
Words = NDArray[np.uint32]

KERNELS = "restir_gi.reference.oracle.builtin.kernels"
REUSE_OWN = "restir_gi.extensions.oracle.reuse.own"
SHIFTS_OWN = "restir_gi.extensions.oracle.shifts.own"
TABLES = "tests.mutants.shift_of_tables"


def built_in(case: Case) -> Buffers:
    """What the project's own pass answers, in single precision."""
    outputs: Buffers = getattr(FLOAT32, case.pass_name)(**case.inputs, **case.settings)
    return outputs


@dataclass(frozen=True, slots=True, eq=False)
class Plant:
    """A backend with one mistake.

    Attributes
    ----------
    name : str; what was done
    expected : tuple of str; hypotheses that would be right
    edits : tuple of (str, str, str); as of `Mutant`
    by_hand : mapping of str to callable
        Passes that are answered in another way than by the edited built-in one.
    """

    name: str
    expected: tuple[str, ...]
    edits: tuple[Edit, ...] = ()
    by_hand: Mapping[str, Answer] = field(default_factory=dict)

    def answers(self, cases: Iterable[Case]) -> list[Buffers]:
        """Outputs of each case."""
        plant = planted(self) if self.edits else nullcontext()
        with plant, np.errstate(all="ignore"):
            return [self.by_hand.get(c.pass_name, built_in)(c) for c in cases]


def _edit(hypothesis: str, name: str, *edits: Edit) -> Plant:
    return Plant(name, (hypothesis,), edits)


def _by_hand(hypothesis: str, name: str, **by_hand: Answer) -> Plant:
    return Plant(name, (hypothesis,), by_hand=by_hand)


SQUARES = "v_from, v_to = x_from - x_sample, x_to - x_sample"
Z_OF_TIME = "Z = normalization(mis, R, [past, new])"
NOTHING_MOVES = "if isinstance(past, Reservoirs):"
BY_SOURCE = (
    "sample = sample_uniform_hemisphere if uniform else sample_cosine_hemisphere"
)
SUM_W, SUM_CONFIDENCE = "w = a.w + b.w", "M = a.M + b.M"
MERGED = '"w": w_a + w_b, "M": M_a + M_b'
MERGED_M = f"{Z_OF_TIME}\n    {NOTHING_MOVES}\n        Z = R.merged.M"

BRIGHT = "luminance(receiver.color * y.radiance) * scale"
LEAVING = "luminance(y.radiance)"


def _of_both_targets(hypothesis: str, name: str, changed: str) -> Plant:
    """Equations 9 and 10 with the same change."""
    return _edit(
        hypothesis,
        name,
        (TARGET, LIGHT, LIGHT.replace(BRIGHT, changed.format(BRIGHT))),
        (TARGET, OUTGOING, OUTGOING.replace(LEAVING, changed.format(LEAVING))),
    )


CORE = [
    _of_both_targets(
        "target-doubled-whatever-is-asked", "every target is doubled", "2 * ({})"
    ),
    _of_both_targets(
        "target-times-pi-whatever-is-asked", "every target has a π", "np.pi * ({})"
    ),
    _of_both_targets("root-of-the-target", "the root of a target", "np.sqrt({})"),
    _edit(
        "sum-of-channels",
        "luminance is the sum of the channels",
        (TARGET, LUMINANCE, "color.sum(axis=1)"),
    ),
    _edit(
        "one-each-unless-empty-in-z",
        "Z counts reservoirs that hold something",
        (RESERVOIRS, TERMS, "np.where(holds & (M > 0), M * 0 + 1, M * 0) for"),
    ),
    _edit(
        "jacobian-inverted",
        "source and receiver change places in the formula",
        (SHIFT, SQUARES, SQUARES.replace("v_from, v_to", "v_to, v_from")),
    ),
    _edit(
        "jacobian-omitted",
        "the Jacobian is 1 everywhere",
        (SHIFT, LIMITED, "return np.ones_like(jacobian)"),
    ),
    _edit(
        "first-not-counted",
        "1/M leaves out the reservoir that came first",
        (MIS, "return _sum(M_k)", "return _sum(M_k[1:])"),
        (
            TEMPORAL,
            Z_OF_TIME,
            f"{Z_OF_TIME}\n    {NOTHING_MOVES}\n        Z = R.M[1]",
        ),
    ),
    _edit(
        "capped-on-arrival",
        "a pixel's own reservoirs are capped as they come, moved or not",
        (RESERVOIRS, CAP, "W=r.W, M=r.M"),
        (
            TEMPORAL,
            PAST,
            "from dataclasses import replace\n    from numpy import minimum\n\n"
            "    moved = not isinstance(past, Reservoirs)\n"
            "    r = past.reservoirs if moved else past\n"
            "    r = replace(r, M=minimum(r.M, cap))\n"
            "    past = replace(past, reservoirs=r) if moved else r\n    " + PAST,
        ),
        (
            SPATIAL,
            PAST_S,
            "from dataclasses import replace\n    from numpy import minimum\n\n"
            "    past = replace(past, M=minimum(past.M, cap))\n"
            "    own = replace(own, M=minimum(own.M, cap))\n    " + PAST_S,
        ),
    ),
    _edit(
        "target-pi-twice",
        "the target is divided by π twice",
        (TARGET, SCALE, SCALE.replace("np.pi", "np.pi * np.pi")),
    ),
    _edit(
        "target-with-geometry-term",
        "the geometry term, where squares may leave the number type",
        (
            TARGET,
            SCALE,
            "d2 = dot(toward.astype(float), toward.astype(float))\n"
            "        scale = abs(dot(y.normal, toward).astype(float)) * cosine\n"
            "        scale = divide_or_zero(scale, np.pi * d2 * d2)",
        ),
        (TARGET, LIGHT, LIGHT.replace("return ", "return np.minimum(3e38, ") + ")"),
    ),
    _edit(
        "target-always-outgoing",
        "the target is Equation 10 where 9 is asked for",
        (TARGET, 'if kind == "outgoing":', "if kind:"),
    ),
    _edit(
        "directions-of-the-other-sampler",
        "the two samplers change places",
        (
            KERNELS,
            BY_SOURCE,
            "sample = sample_cosine_hemisphere if uniform else "
            "sample_uniform_hemisphere",
        ),
    ),
    _edit(
        "directions-from-the-other-end",
        "1 − u stands for u in both samplers",
        (
            SAMPLING,
            UNIFORM_SAMPLE,
            "_about_z(1.0 - u1, np.sqrt(u1 * (2.0 - u1)), u2)",
        ),
        (SAMPLING, COSINE_SAMPLE, "_about_z(np.sqrt(u1), np.sqrt(1.0 - u1), u2)"),
    ),
    _edit("azimuth-in-turns", "φ = u", (SAMPLING, PHI, "phi = 1.0 * u\n")),
    _edit(
        "sum-of-weights-lost",
        "the sum of weights forgets what came before, in the kernel too",
        (RESERVOIRS, SUM_W, "w = b.w"),
        (KERNELS, MERGED, '"w": w_b, "M": M_a + M_b'),
    ),
    *(
        _edit(
            hypothesis,
            name,
            (RESERVOIRS, SUM_CONFIDENCE, f"M = {words}"),
            (KERNELS, MERGED, f'"w": w_a + w_b, "M": {kernel}'),
            (REUSED, SUM_M, "return R.merged.M"),
            (TEMPORAL, Z_OF_TIME, MERGED_M),
        )
        for hypothesis, name, words, kernel in (
            ("confidence-lost", "M forgets what came before", "b.M", "M_b"),
            ("one-for-every-merge", "a merge counts one more", "a.M + 1", "M_a + 1"),
        )
    ),
    *(
        _edit(
            f"divisor-at-least-{least:g}",
            f"the target is kept above {least:g} where it divides",
            (
                RESERVOIRS,
                CLOSED,
                f"divide_or_zero(c.w / np.maximum(c.p_hat, {least}), normalization)",
            ),
        )
        for least in (1e-2, 1e-4, 1e-5, 1e-6)
    ),
    *(
        _edit(
            f"scattered-at-least-{least:g}",
            f"the target of Equation 9 has a floor of {least:g}",
            (
                TARGET,
                LIGHT,
                "p_hat = luminance(receiver.color * y.radiance) * scale\n"
                f"    return np.where(p_hat > 0, np.maximum(p_hat, {least}), p_hat)",
            ),
        )
        for least in (1e-2, 1e-4, 1e-5, 1e-6)
    ),
    *(
        _edit(
            f"target-at-least-{least:g}",
            f"both targets have a floor of {least:g}",
            (
                TARGET,
                LIGHT,
                "p_hat = luminance(receiver.color * y.radiance) * scale\n"
                f"    return np.where(p_hat > 0, np.maximum(p_hat, {least}), p_hat)",
            ),
            (
                TARGET,
                OUTGOING,
                "p_hat = np.where(cosine > 0, luminance(y.radiance), 0.0)\n"
                f"            p_hat[p_hat > 0] = np.maximum(p_hat, {least})[p_hat > 0]"
                "\n            return p_hat",
            ),
        )
        for least in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
    ),
]


def _with_pixel_0(case: Case) -> Buffers:
    """Absent neighbours are a copy of pixel 0, and their bits are read as they stand.

    The copy is another row, so that its bits are not those of the pixel itself.
    """
    rows = case.rows
    inputs = {n: np.concatenate([a, a[:1]]) for n, a in case.inputs.items()}
    found = inputs["neighbors"]
    inputs["neighbors"] = np.where(found < 0, rows, found)
    inputs["neighbors"][rows] = -1
    inputs["visible"][rows] = 0
    outputs = built_in(replace(case, inputs=inputs))
    return {name: array[:rows] for name, array in outputs.items()}


CORE.append(
    Plant(
        "a neighbour that there is not is pixel 0",
        ("none-is-pixel-0",),
        ((REUSED, COULD, "could[slot] = q_n.could_make(R.kept.y, full)"),),
        {"spatial": _with_pixel_0},
    )
)

VIEWS = [
    _edit(
        "image-mirrored",
        "right is left",
        (
            CAMERA,
            "(-right if self.mirrored else right)",
            "(right if self.mirrored else -right)",
        ),
    ),
    _edit(
        "behind-the-camera",
        "what lies behind has a row, by the size of its depth",
        (OWN, "[ahead, t > 0, *sides]", "[ahead, *sides]"),
        (CAMERA, "where=depth > 0", "where=depth != 0"),
        (
            REPROJECT,
            "depth = view_depth(before.camera, carry(back, shape, surface.position))",
            "depth = view_depth(before.camera, carry(back, shape, surface.position))\n"
            "    depth = abs(depth)",
        ),
    ),
    _edit(
        "back-faces-not-met",
        "triangles are met from the front alone",
        (OWN, "[ahead, t > 0, *sides]", "[ahead, facing < 0, t > 0, *sides]"),
    ),
    _edit(
        "own-pixel-tested",
        "normal and depth are compared with those of the same pixel",
        (
            REPROJECT,
            "surface, row = visible.surface, np.maximum(rows, 0)",
            "surface, row = visible.surface, np.arange(len(rows))",
        ),
    ),
    _edit(
        "place-depth-relative-to-own",
        "the depth before may differ by a share of the depth of now",
        (GBUFFER, "max_depth * far)", "max_depth * depth_a)"),
    ),
    _edit(
        "validation-relative-to-now",
        "the tolerance is relative to the luminance of now",
        (VALIDATION, SAME, SAME.replace("np.maximum(now, then)", "now")),
    ),
    _edit(
        "validation-asks-nulls",
        "nulls are asked as any sample",
        (OWN, "np.where(null == 1, -1, 0)", "np.where(null == 1, 0, 0)"),
    ),
    _edit(
        "boiling-tiles-of-8",
        "the filter's tiles have 8 pixels on a side",
        (BOILING, "TILE = 16", "TILE = 8"),
    ),
    _edit(
        "checkerboard-of-pixel-numbers",
        "pixels take turns by their numbers",
        (CHECKERBOARD, TURN, "(rows + frame) % 2 == 0"),
    ),
]

HALVES = ("red", "green", "blue")
FIELDS = (
    ("visible_position", "<f4", 3),
    ("visible_normal", "<i2", 2),
    ("position", "<f4", 3),
    ("normal", "<i2", 2),
    *((name, "<f2") for name in HALVES),
    ("M", "<u2"),
    ("W", "<f4"),
    ("seed", "<u4"),
)
"""The layout of the contract, with each channel by itself."""


def _layout(*names: str) -> Any:
    known = {name: (name, *kind) for name, *kind in FIELDS}
    return np.dtype([known[name] for name in names])


CONTRACT_LAYOUT = _layout(*(name for name, *_ in FIELDS))
assert CONTRACT_LAYOUT.itemsize == RECORD.itemsize


def rewritten(words: Words, read: Any, written: Any) -> Words:
    """Records of one layout in another one's words."""
    records = np.ascontiguousarray(words).view(read)[:, 0]
    found = np.empty(len(records), written)
    for name in read.names:
        found[name] = records[name]
    return found.view("<u4").reshape(len(found), -1)


def _laid_out(hypothesis: str, name: str, *fields: str) -> Plant:
    """Fields of the paper's layout in another order, written and read."""
    return _in_layout("paper", CONTRACT_LAYOUT, hypothesis, name, _layout(*fields))


def _in_layout(
    layout: str, right: Any, hypothesis: str, name: str, other: Any
) -> Plant:
    """A layout with its fields in another order; the other layouts are right."""

    def is_other(case: Case) -> bool:
        return case.settings.get("layout", "paper") != layout

    def pack(case: Case) -> Buffers:
        words = built_in(case)["words"]
        return {"words": words if is_other(case) else rewritten(words, right, other)}

    def unpack(case: Case) -> Buffers:
        if is_other(case):
            return built_in(case)
        words = rewritten(case.inputs["words"], other, right)
        return built_in(replace(case, inputs={"words": words}))

    return _by_hand(hypothesis, name, pack=pack, unpack=unpack)


X_V, N_V, X_S, N_S = "visible_position", "visible_normal", "position", "normal"
RED, GREEN, BLUE = HALVES
ENCODED = "codes: NDArray[np.int16] = np.stack([u, v], axis=-1).astype(np.int16)"
READ = "u, v = (np.maximum(codes[:, i].astype(np.int32), -UNIT) for i in range(2))"
HALVES_READ = 'radiance=widened(codes["L_o"])'

PACKED = [
    _edit(
        "v-before-u",
        "v is written and read before u",
        (OCTAHEDRAL, ENCODED, ENCODED.replace("[u, v]", "[v, u]")),
        (OCTAHEDRAL, READ, READ.replace("u, v =", "v, u =")),
    ),
    _laid_out(
        "normals-exchanged",
        "each normal stands where the other should",
        *(X_V, N_S, X_S, N_V, RED, GREEN, BLUE, "M", "W", "seed"),
    ),
    _laid_out(
        "m-before-blue",
        "M stands before blue",
        *(X_V, N_V, X_S, N_S, RED, GREEN, "M", BLUE, "W", "seed"),
    ),
    _laid_out(
        "blue-first",
        "channels from blue to red",
        *(X_V, N_V, X_S, N_S, BLUE, GREEN, RED, "M", "W", "seed"),
    ),
    _laid_out(
        "halves-from-above",
        "the upper half of a word comes first",
        *(X_V, N_V, X_S, N_S, GREEN, RED, "M", BLUE, "W", "seed"),
    ),
    _laid_out(
        "seed-before-w",
        "the seed stands before W",
        *(X_V, N_V, X_S, N_S, RED, GREEN, BLUE, "M", "seed", "W"),
    ),
    _laid_out(
        "positions-before-normals",
        "both positions come first",
        *(X_V, X_S, N_V, N_S, RED, GREEN, BLUE, "M", "W", "seed"),
    ),
    _edit(
        "octahedron-not-divided",
        "unit vectors are points of the octahedron",
        (
            OCTAHEDRAL,
            "total = abs(n[:, 0]) + abs(n[:, 1]) + abs(n[:, 2])",
            "total = np.ones(len(n))",
        ),
    ),
    _edit(
        "octahedron-by-32768",
        "the square has 32768 steps",
        (OCTAHEDRAL, "UNIT = 32767", "UNIT = 32768"),
        (OCTAHEDRAL, ENCODED, ENCODED.replace("1)", "1).clip(-32767, 32767)")),
        (OCTAHEDRAL, READ, READ.replace("-UNIT", "-32767")),
    ),
    _edit(
        "small-halves-are-0",
        "what is dim is read as 0",
        (
            PAPER,
            HALVES_READ,
            "radiance=widened(np.where(abs(codes['L_o']) < 2.0**-14, 0,"
            " codes['L_o']).astype('f2'))",
        ),
    ),
]

PACKING = "restir_gi.reference.resampling.packing"
RTXDI, PATHS = f"{PACKING}.rtxdi", f"{PACKING}.rtxdi_path"
LOG_LUV, COMPONENTS = f"{PACKING}.log_luv", f"{PACKING}.components"

RTXDI_LAYOUT = np.dtype(
    [
        ("position", "<f4", 3),
        ("M", "u1"),
        ("age", "u1"),
        ("misc", "<u2"),
        ("radiance", "<u4"),
        ("W", "<f4"),
        ("normal", "<i2", 2),
        ("unused", "<u4"),
    ]
)
PATH_LAYOUT = np.dtype(
    [
        ("position", "<f4", 3),
        ("W", "<f4"),
        ("x", "<u2"),
        ("y", "<u2"),
        ("z", "<u2"),
        ("M", "<f2"),
        ("jacobian", "<f4"),
        ("pdf", "<f4"),
        ("radiance", "<u4", 3),
        ("age", "u1"),
        ("vertex", "u1"),
        ("length", "u1"),
        ("index", "u1"),
        ("target", "<u4", 3),
        ("seed", "<u4"),
    ]
)


def _in_rtxdi(hypothesis: str, name: str, layout: str, *runs: tuple[str, ...]) -> Plant:
    """A layout of RTXDI with some of its fields in another order.

    Parameters
    ----------
    *runs : tuple of str; neighbours, in their new order
    """
    right = {"rtxdi": RTXDI_LAYOUT, "rtxdi_path": PATH_LAYOUT}[layout]
    order = list(right.names or ())
    for run in runs:
        first = min(order.index(field) for field in run)
        order[first : first + len(run)] = run
    other = np.dtype([(field, right[field]) for field in order])
    return _in_layout(layout, right, hypothesis, name, other)


M_BYTE, AGE_BYTE = 'codes["M"] = nearest_count(r.M, 255)', "nearest_count(age, 255)"
LAST_OF_RTXDI = 'codes["n_s"] = encode_normal(r.y.normal)\n    return codes'
WORDS_OF_RTXDI = (
    'codes["n_s"] = encode_normal(r.y.normal)\n'
    '    words = codes.view("<u4").reshape(-1, 8)\n'
    "    words[:, 3] |= {}\n"
    "    return codes"
)
LEVEL_OF = "LEVELS_PER_STOP * np.log2(np.maximum(Y, DARKEST) / DARKEST)"
LIGHT_OF = "DARKEST * np.exp2((level + 0.5) / LEVELS_PER_STOP)"
CHROMA_OF = "((words >> bit & 511) + 0.5 for bit in (9, 0))"
LUV_WORD = "(L << 18) | (u << 9) | v"
CUT_CELLS = "np.clip(field, 0, most).astype(np.uint32)"
NOT_NEGATIVE = "np.maximum(dot(xyz, row), 0.0) for row"

AGE_OF_PATH = 'codes["age"] = path.age & OLDEST | np.where(path.boosts, BOOST, 0)'
LAST_OF_PATH = 'codes["seed"] = path.seed\n    return codes'
STEPS_OF = "steps = np.rint(UNIT * np.clip("
STEPS_READ = "np.minimum(codes.astype(np.int32) - UNIT, UNIT)"
M_OF_PATH = "nearest_float(r.M, np.float16)"

LAYOUTS = [
    _in_rtxdi(
        "rtxdi-m-and-age-exchanged",
        "the age stands below M",
        "rtxdi",
        ("age", "M"),
    ),
    _in_rtxdi(
        "rtxdi-misc-below",
        "the application's bits come first",
        "rtxdi",
        ("misc", "M", "age"),
    ),
    _in_rtxdi(
        "rtxdi-w-before-radiance",
        "W comes before the radiance",
        "rtxdi",
        ("W", "radiance"),
    ),
    _in_rtxdi(
        "rtxdi-normal-last",
        "the normal comes last",
        "rtxdi",
        ("unused", "normal"),
    ),
    _edit(
        "rtxdi-m-runs-over",
        "M is not cut off",
        (RTXDI, M_BYTE, 'codes["M"] = 0'),
        (RTXDI, LAST_OF_RTXDI, WORDS_OF_RTXDI.format('r.M.astype("u4")')),
    ),
    _edit(
        "rtxdi-m-wraps",
        "of M the low eight bits are kept",
        (RTXDI, M_BYTE, 'codes["M"] = r.M.astype(np.int64) & 255'),
    ),
    _edit(
        "rtxdi-age-runs-over",
        "the age is not cut off",
        (RTXDI, AGE_BYTE, "0"),
        (RTXDI, LAST_OF_RTXDI, WORDS_OF_RTXDI.format("age << np.uint32(8)")),
    ),
    _edit(
        "rtxdi-age-wraps",
        "of the age the low eight bits are kept",
        (RTXDI, AGE_BYTE, "age & 255"),
    ),
    _edit(
        "rtxdi-misc-left-out",
        "nothing of the application's is stored",
        (RTXDI, 'codes["misc"] = misc', 'codes["misc"] = 0'),
    ),
    _edit(
        "log-luv-natural",
        "the level is a natural logarithm",
        (
            LOG_LUV,
            LEVEL_OF,
            "LEVELS_PER_STOP * (np.log(np.maximum(Y, np.exp(-20.0))) + 20)",
        ),
        (LOG_LUV, LIGHT_OF, "np.exp((level + 0.5) / LEVELS_PER_STOP - 20)"),
    ),
    _edit(
        "log-luv-rounded",
        "the nearest edges of cells are written",
        (LOG_LUV, CUT_CELLS, CUT_CELLS.replace("field,", "np.floor(field + 0.5),")),
    ),
    _edit(
        "log-luv-without-half",
        "cells are read at their edges",
        (LOG_LUV, LIGHT_OF, LIGHT_OF.replace("0.5", "0.0")),
        (LOG_LUV, CHROMA_OF, CHROMA_OF.replace("0.5", "0.0")),
    ),
    _edit(
        "log-luv-v-first",
        "v′ stands above u′",
        (LOG_LUV, LUV_WORD, "(L << 18) | (v << 9) | u"),
        (LOG_LUV, CHROMA_OF, CHROMA_OF.replace("(9, 0)", "(0, 9)")),
    ),
    _edit(
        "log-luv-negative",
        "channels are what the matrix gives",
        (LOG_LUV, NOT_NEGATIVE, "dot(xyz, row) for row"),
    ),
    _in_rtxdi(
        "rtxdi-path-m-below-z",
        "M comes before z",
        "rtxdi_path",
        ("M", "z"),
    ),
    _in_rtxdi(
        "rtxdi-path-density-before-jacobian",
        "the density comes before the Jacobian",
        "rtxdi_path",
        ("pdf", "jacobian"),
    ),
    _in_rtxdi(
        "rtxdi-path-target-before-radiance",
        "the target function stands where the radiance should",
        "rtxdi_path",
        ("target", "age", "vertex", "length", "index", "radiance"),
    ),
    _in_rtxdi(
        "rtxdi-path-lengths-exchanged",
        "the length comes before the vertex",
        "rtxdi_path",
        ("length", "vertex"),
    ),
    _in_rtxdi(
        "rtxdi-path-age-above",
        "the bytes of a word from above",
        "rtxdi_path",
        ("index", "length", "vertex", "age"),
    ),
    _edit(
        "rtxdi-path-age-runs-over",
        "the age is not masked",
        (PATHS, AGE_OF_PATH, 'codes["age"] = np.where(path.boosts, BOOST, 0)'),
        (
            PATHS,
            LAST_OF_PATH,
            'codes["seed"] = path.seed\n'
            '    words = codes.view("<u4").reshape(-1, 16)\n'
            "    words[:, 11] |= path.age\n"
            "    return codes",
        ),
    ),
    _edit(
        "rtxdi-path-age-not-masked",
        "the age is a whole byte",
        (PATHS, 'age=codes["age"] & np.uint8(OLDEST)', 'age=codes["age"].copy()'),
    ),
    _edit(
        "rtxdi-path-age-stops",
        "nobody is older than 31",
        (
            PATHS,
            AGE_OF_PATH,
            AGE_OF_PATH.replace("path.age & OLDEST", "np.minimum(path.age, OLDEST)"),
        ),
    ),
    _edit(
        "rtxdi-path-boosts-in-bit-5",
        "the flag stands above the age",
        (PATHS, "OLDEST, BOOST = 31, 0x80", "OLDEST, BOOST = 31, 0x20"),
    ),
    _edit(
        "rtxdi-path-normal-with-sign",
        "components have a sign",
        (
            COMPONENTS,
            "(steps + UNIT).astype(np.uint16)",
            "steps.astype(np.int16).view(np.uint16)",
        ),
        (
            COMPONENTS,
            STEPS_READ,
            "np.maximum(codes.astype(np.int16).astype(np.int32), -UNIT)",
        ),
    ),
    _edit(
        "rtxdi-path-normals-cut",
        "components are rounded down",
        (COMPONENTS, STEPS_OF, STEPS_OF.replace("rint", "floor")),
    ),
    _edit(
        "rtxdi-path-normals-not-normalized",
        "components are read as they stand",
        (COMPONENTS, "normalize(steps.astype(np.float64))", "steps / UNIT"),
    ),
    _edit(
        "rtxdi-path-m-overflows",
        "a half may be infinite",
        (PATHS, M_OF_PATH, "r.M.astype(np.float16)"),
    ),
    _edit(
        "rtxdi-path-m-is-a-count",
        "M is a whole number of 16 bits",
        (
            PATHS,
            M_OF_PATH,
            'np.minimum(np.rint(r.M), 65535).astype("<u2").view("<f2")',
        ),
        (
            PATHS,
            'M=widened(codes["M"])',
            'M=codes["M"].copy().view("<u2").astype(float)',
        ),
    ),
    _edit(
        "rtxdi-path-light-not-marked",
        "a light has radiance as all others",
        (
            PATHS,
            "on_light = np.broadcast_to(path.on_light, len(codes))",
            "on_light = np.zeros(len(codes), bool)",
        ),
        (
            PATHS,
            "words[:, 0] & np.uint32(0x7FFFFFFF) == INFINITY",
            "np.zeros(len(words), bool)",
        ),
    ),
]

STREAM = "stream = [candidate(q_n, slot, target) for slot, q_n in enumerate(neighbors)]"
CAPPED_WEIGHTS = f"""{STREAM}
    if mis not in ("pairwise", "defensive"):
        for slot, c in enumerate(stream):
            m = np.minimum(c.weighted.M, cap)
            w = c.weighted.w * divide_or_zero(m, c.weighted.M)
            stream[slot] = replace(c, weighted=replace(c.weighted, w=w))"""
CLOSED_REUSE = "return cap_confidence(finalize(replace(kept, y=y), total), cap)"

REUSE = [
    _edit(
        "reuse-jacobian-divides",
        "a shifted sample is divided by its Jacobian",
        (
            ENGINE,
            ARRIVING,
            "reused_candidates(\n"
            "        here, target(value), divide_or_zero(np.ones_like(W), jacobian)\n"
            "    )",
        ),
    ),
    _edit(
        "reuse-empty-slots-counted",
        "slots without a source are sources without a sample",
        (REUSE_OWN, "W[:, k], M[:, k]", "W[:, k] * there[:, k], M[:, k]"),
        (REUSE_OWN, "np.where(there[:, k] == 1, here, NONE)", "here"),
    ),
    _edit(
        "reuse-z-for-balance",
        "1/Z is taken where the balance heuristic is asked for",
        (ENGINE, 'if mis == "1/Z":', 'if mis in ("1/Z", "balance"):'),
    ),
    _edit(
        "reuse-balance-for-z",
        "the balance heuristic is taken where 1/Z is asked for",
        (ENGINE, 'if mis == "balance":', 'if mis in ("1/Z", "balance"):'),
        (ENGINE, 'if mis == "1/Z":', 'if mis == "Z":'),
    ),
    _edit(
        "reuse-capped-beforehand",
        "what arrives is capped, and what leaves is not",
        (REUSE_OWN, "W[:, k], M[:, k]", "W[:, k], np.minimum(M[:, k], cap)"),
        (ENGINE, CLOSED_REUSE, "return finalize(replace(kept, y=y), total)"),
    ),
    _edit(
        "reuse-capped-in-weights-alone",
        "the weights have the capped confidences, Z has not",
        (ENGINE, STREAM, CAPPED_WEIGHTS),
    ),
    _edit(
        "reuse-u-turned",
        "1 − u decides on the slots",
        (REUSE_OWN, "decisions = [u[:, k] for", "decisions = [1 - u[:, k] for"),
    ),
]

JACOBIAN = "jacobian = divide_or_zero(density[1], density[0])"
OF_PATH = "density.append(p.astype(float) * came.spread * onward.astype(float))"
BASE = 'base = given["density"]'
WAY = 'given["joint_position"] - given["base_position"]'
BASE_P = 'given["base_pdf_left"]'
BASE_Q = 'np.where(chosen & last, 1.0, given["base_pdf_onward"])'
BASE_S = f"_spread(given, {WAY})"
OFFSET = "p * _spread(given, way) * q, base"
SOLID_ANGLE = 'divide_or_zero(abs(dot(given["joint_normal"], way)), d**3)'
BOTH_ROUGH = "np.minimum(*rough)"
M_BEFORE = 'm = np.where(joined, given["joint"] - 1, given["end"])'


def _in_tables(hypothesis: str, name: str, *edits: tuple[str, str]) -> Plant:
    """A mistake in the pass ``shift`` that was written by hand."""
    found = tuple((TABLES, old, new) for old, new in edits)
    return Plant(name, (hypothesis,), found, {"shift": shift_of_tables.shift})


def _of_joints(hypothesis: str, name: str, own: Edit, *edits: tuple[str, str]) -> Plant:
    """A mistake in the Jacobian, in both passes that have one."""
    plant = _in_tables(hypothesis, name, *edits)
    return replace(plant, edits=(*plant.edits, own))


SHIFTS = [
    _edit(
        "path-jacobian-inverted",
        "base path and offset path change places",
        (SHIFTS_OWN, JACOBIAN, "jacobian = divide_or_zero(density[0], density[1])"),
    ),
    _edit(
        "path-jacobian-omitted",
        "the Jacobian of a joint is 1 where there is one",
        (SHIFTS_OWN, JACOBIAN, "jacobian = (density[1] > 0).astype(float)"),
    ),
    *(
        _of_joints(
            hypothesis,
            f"solid angles are {words}, of both paths",
            (SHIFTING, SPREAD, f"spread = divide_or_zero({wrong}, distance**{power})"),
            (BASE, f"base = {BASE_P} * {BASE_S} * {BASE_Q}"),
            (SOLID_ANGLE, f"divide_or_zero({by_hand}, d**{in_tables})"),
        )
        for hypothesis, words, wrong, power, by_hand, in_tables in (
            (
                "path-jacobian-without-cosine",
                "1 / d²",
                *("np.ones_like(cosine)", 2),
                *("d", 3),
            ),
            (
                "path-jacobian-distance-once",
                "|cos| / d",
                *("cosine", 1),
                *('abs(dot(given["joint_normal"], way))', 2),
            ),
            (
                "path-jacobian-without-distance",
                "|cos|",
                *("cosine", 0),
                *('abs(dot(given["joint_normal"], way))', 1),
            ),
        )
    ),
    _of_joints(
        "path-jacobian-without-left-density",
        "the first density is left out of both paths",
        (SHIFTS_OWN, OF_PATH, OF_PATH.replace("p.astype(float) * ", "")),
        (BASE, f"base = {BASE_S} * {BASE_Q}"),
        (OFFSET, OFFSET.replace("p * ", "")),
    ),
    _of_joints(
        "path-jacobian-without-onward-density",
        "the second density is left out of both paths",
        (SHIFTS_OWN, OF_PATH, OF_PATH.replace(" * onward.astype(float)", "")),
        (BASE, f"base = {BASE_P} * {BASE_S}"),
        (OFFSET, OFFSET.replace(" * q", "")),
    ),
    _of_joints(
        "path-jacobian-densities-omitted",
        "the Jacobian is one of solid angles",
        (SHIFTS_OWN, OF_PATH, "density.append(came.spread)"),
        (BASE, f"base = {BASE_S}"),
        (OFFSET, "_spread(given, way), base"),
    ),
    *(
        _in_tables(hypothesis, f"{words}, in walks that are given", (BOTH_ROUGH, rough))
        for hypothesis, words, rough in (
            ("first-end-rough", "the point that is left decides", "rough[0]"),
            ("second-end-rough", "the one that is reached", "rough[1]"),
            (
                "one-rough-end-is-enough",
                "the rougher of two points decides",
                BOTH_ROUGH.replace("minimum", "maximum"),
            ),
        )
    ),
    _in_tables(
        "path-length-not-asked",
        "the offset path may be shorter",
        ('(given["hit"] | (v > m[:, None])).all(axis=1)', 'given["hit"][:, 0]'),
    ),
    _in_tables(
        "joint-seen-from-behind",
        "either side of the joint will do",
        ("return able & front & ", "return able & "),
    ),
    _in_tables(
        "distance-from-the-base",
        "the solid angle of the joint is the base path's",
        (OFFSET, f"p * {BASE_S} * q, base"),
    ),
    _in_tables(
        "joined-one-vertex-late",
        "the offset path is replayed to x_c",
        (M_BEFORE, M_BEFORE.replace(" - 1", "")),
    ),
    _in_tables(
        "joined-one-vertex-early",
        "the offset path is replayed to x_(c-2)",
        (M_BEFORE, M_BEFORE.replace(" - 1", " - 2")),
    ),
    _in_tables(
        "bases-throughput",
        "the throughput is the base path's",
        ("value = _throughput(given, m)\n", 'value = given["base_throughput"]\n'),
    ),
    _in_tables(
        "share-of-the-base",
        "the share has the base path's density",
        ("p_last = q", 'p_last = given["base_pdf_onward"]'),
    ),
]

BY_HAND = "tests.mutants.reuse_by_hand"
ALL_BY_HAND = dict.fromkeys(
    ("temporal", "moved", "spatial", "fused"), reuse_by_hand.reuse
)
STREAM_ORDER = "order, numbers = 1, list(range(K)), list(range(K))"
ASKED = 'weights = str(case.settings.get("mis", "1/M"))'
IN_MEASURE = "return divide_or_zero(p, shift(x_j, x, slots[s].y))"
TRUSTED = "M = [s.M for s in slots]"
CAPPED = 'cap = float(case.settings["cap"])\n    '
STORED = 'real = case.inputs["past_W"].dtype'
STORED_M = '"M": np.minimum(sum(M), cap),'
HELD = "p = np.where(slots[j].sees[s], target(kind, x_j, slots[s].y), 0.0)"


def _in_reuse(hypothesis: str, name: str, *edits: tuple[str, str]) -> Plant:
    """A choice or mistake in the passes of reuse that were written by hand."""
    found = tuple((BY_HAND, old, new) for old, new in edits)
    return Plant(name, (hypothesis,), found, ALL_BY_HAND)


def _in_order(hypothesis: str, name: str, order: str, numbers: str) -> Plant:
    new = f"order, numbers = 1, {order}, {numbers}"
    return _in_reuse(hypothesis, name, (STREAM_ORDER, new))


STREAM_AS_IT_IS = ("neighbors", "neighbors-in-place", "own-first-in-place")
REVERSED = "neighbors-own-past-turned-in-place"


def _in_orders(name: str, stream: str, past: str = "") -> Iterator[Plant]:
    """Neighbours as they are, or turned; numbers of reservoirs, or of places.

    Parameters
    ----------
    past : str; whose number the past has: that of the first, unless it is the first
    """
    for turned, around, first in (
        ("", "*range(2, K)", "2"),
        ("-turned", "*range(K - 1, 1, -1)", "K - 1"),
    ):
        order = stream.format(n=around)
        own = stream.replace("0", past or first).format(n=around)
        if stream.startswith("0"):
            own = order
        for place, numbers in (("", f"[{own}]"), ("-in-place", "list(range(K))")):
            found = f"{name}{turned}{place}"
            if found not in (*STREAM_AS_IT_IS, REVERSED):
                words = f"{stream.format(n='neighbours')}{turned}{place}"
                yield _in_order(found, words, f"[{order}]", numbers)


HALF_RADIANCE = 'outputs["radiance"] = half(outputs["radiance"])'
HALF_W = 'outputs["W"] = half(outputs["W"])'
OCTAHEDRON = 'outputs["normal"] = octahedral(outputs["normal"])'
IN_LOG_LUV = 'outputs["radiance"] = log_luv(outputs["radiance"])'
SHARED = 'outputs["radiance"] = shared(outputs["radiance"], {})'


def _in_fused(hypothesis: str, name: str, *edits: tuple[str, str]) -> Plant:
    """A mistake in pass ``fused`` alone: of others the catalogues have it already."""
    found = tuple((BY_HAND, old, new) for old, new in edits)
    return Plant(name, (hypothesis,), found, {"fused": reuse_by_hand.reuse})


# By hand slot 0 of its stream is nobody, 1 the pixel's own, and the last is a source.
HELD_M = "np.where(p_k > 0, M_k, 0.0) for p_k, M_k in zip(p, M, strict=True)"
BY_M = 'if weights == "1/M":\n        return sum(M)'
THERE = "there, row = row >= 0, np.maximum(row, 0)"

FUSED = [
    _in_fused(
        "canonical-missing-in-z",
        "1/Z leaves own out",
        (
            HELD_M,
            "np.where(p_k > 0, M_k, 0.0)"
            " for p_k, M_k in zip(p, [M[0], 0 * M[1], *M[2:]])",
        ),
    ),
    _in_fused(
        "canonical-not-merged",
        "own has neither weight nor confidence",
        (TRUSTED, f"{TRUSTED}\n    M[1] = 0 * M[1]"),
    ),
    _in_fused(
        "capped-before-weight",
        "Z is capped",
        (
            "divide_or_zero(total, Z_k * p)",
            "divide_or_zero(total, np.minimum(Z_k, cap) * p)",
        ),
    ),
    _in_fused(
        "one-number-for-all-neighbors",
        "one number decides on all sources",
        (
            "numbers.append(u[:, k].astype(float))",
            "numbers.append(u[:, 0].astype(float))",
        ),
    ),
    _in_fused(
        "last-confidence-in-z",
        "Z adds the last M for each",
        (HELD_M, "np.where(p_k > 0, M[-1], 0.0) for p_k in p[1:]"),
    ),
    _in_fused(
        "one-each-in-z",
        "Z adds 1 for each",
        (HELD_M, "np.where(p_k > 0, 1.0, 0.0) for p_k in p[1:]"),
    ),
    _in_fused(
        "merged-confidence-in-z",
        "own is counted with all that is merged",
        (
            HELD_M,
            "np.where(p_k > 0, M_k, 0.0)"
            " for p_k, M_k in zip(p, [M[0], sum(M), *M[2:]])",
        ),
        (BY_M, f"{BY_M} + sum(M) - M[1]"),
    ),
    _in_fused(
        "first-not-counted",
        "1/M leaves own out",
        (BY_M, f"{BY_M} - M[1]"),
    ),
    _in_fused(
        "capped-on-arrival",
        "own and the past are capped as they come",
        (TRUSTED, f"{CAPPED}M = [np.minimum(s.M, cap) for s in slots]"),
        (STORED_M, '"M": sum(M),'),
    ),
    _in_fused(
        "stream-reversed",
        "the last of the stream comes first",
        (
            STREAM_ORDER,
            "order, numbers = 1, [*range(K - 1, 0, -1), 0], list(range(K))",
        ),
    ),
    _in_fused(
        "one-for-every-merge",
        "a merge counts one more",
        (STORED_M, '"M": np.minimum(M[1] + len(M) - 2.0, cap),'),
        (BY_M, BY_M.replace("sum(M)", "M[1] + len(M) - 2.0")),
    ),
    _in_fused(
        "empty-counts",
        "what is empty counts once",
        (TRUSTED, "M = [0 * slots[0].M, *(np.maximum(s.M, 1) for s in slots[1:])]"),
    ),
    _in_fused(
        "none-is-pixel-0",
        "a source that there is not is row 0",
        (THERE, "there, row = row >= -1, np.maximum(row, 0)"),
    ),
    _in_fused(
        "sources-of-this-frame",
        "sources are looked up in the G-buffer of this frame",
        (
            "x, y = _point(given, prefix, VISIBLE), _point(given, prefix, SAMPLE)",
            'x, y = _point(given, "", VISIBLE), _point(given, prefix, SAMPLE)',
        ),
    ),
]

CHOICES = [
    *_in_orders("own-first", "1, 0, {n}", past="1"),
    *_in_orders("past-last", "1, {n}, 0", past="1"),
    *_in_orders("own-last", "0, {n}, 1"),
    *_in_orders("neighbors", "0, 1, {n}"),
    *_in_orders("neighbors-first", "{n}, 0, 1"),
    *_in_orders("neighbors-own-past", "{n}, 1, 0"),
    _in_reuse(
        "capped-everywhere-on-arrival",
        "all are capped as they come",
        (TRUSTED, f"{CAPPED}M = [np.minimum(s.M, cap) for s in slots]"),
        (STORED_M, '"M": sum(M),'),
    ),
    _in_reuse(
        "capped-twice",
        "the pixel's own are capped as they come, and again as they are stored",
        (
            TRUSTED,
            f"{CAPPED}mine = [k < 2 or s.old for k, s in enumerate(slots)]\n"
            "    capped = [np.minimum(s.M, cap) for s in slots]\n"
            "    M = [c if m else s.M for c, m, s in zip(capped, mine, slots)]",
        ),
    ),
    _in_reuse(
        "capped-twice-everywhere",
        "all are capped as they come, and again as they are stored",
        (TRUSTED, f"{CAPPED}M = [np.minimum(s.M, cap) for s in slots]"),
    ),
    _in_reuse(
        "past-capped-on-arrival",
        "the past alone is capped as it comes",
        (
            TRUSTED,
            f"{CAPPED}M = [np.minimum(s.M, cap) if s.old else s.M for s in slots]",
        ),
        (STORED_M, '"M": sum(M),'),
    ),
    _in_reuse(
        "history-not-merged",
        "the past has neither weight nor confidence",
        (TRUSTED, f"{TRUSTED}\n    M[0] = 0 * M[0]"),
    ),
    _in_reuse(
        "whole-confidence",
        "M is cut to a whole number",
        (STORED_M, '"M": np.floor(np.minimum(sum(M), cap)),'),
    ),
    _in_reuse(
        "confidence-in-a-byte",
        "M is a byte",
        (STORED_M, '"M": np.minimum(np.floor(np.minimum(sum(M), cap)), 255),'),
    ),
    *(
        _in_reuse(
            f"{name}{'' if measured else '-without-jacobian'}",
            f"the weights are {name}{'' if measured else ', each in its measure'}",
            (ASKED, f'weights = "{name}"'),
            *(() if measured else ((IN_MEASURE, "return p"),)),
        )
        for name in (
            "balance",
            "balance-in-weights",
            "pairwise",
            "defensive",
            "pairwise-of-k",
            "defensive-of-k",
        )
        for measured in (True, False)
    ),
    *(
        _in_reuse(
            f"jacobian-refused-both-ways-at-{most}",
            f"no shift has a Jacobian beyond {most}, nor its inverse",
            (
                TRUSTED,
                f"J = [np.where((a >= 1 / {most}) & (a <= {most}), a, 0.0) for a in J]"
                f"\n    {TRUSTED}",
            ),
            (
                HELD,
                f"{HELD}\n"
                "        back = shift(x_j, x, slots[s].y)\n"
                f"        back = (back >= 1 / {most}) & (back <= {most})\n"
                "        p = np.where(back, p, 0.0)",
            ),
        )
        for most in (10, 3, 2)
    ),
    *(
        _in_reuse(
            hypothesis,
            f"merges are closed one by one: {hypothesis}",
            (ASKED, f'weights = "{weights}"'),
            *edits,
        )
        for hypothesis, weights, edits in (
            ("chained-balance", "chained-balance", ()),
            (
                "chained-balance-without-jacobian",
                "chained-balance",
                ((IN_MEASURE, "return p"),),
            ),
            ("chained-one-over-z", "chained-1/Z", ()),
        )
    ),
    *(
        _in_reuse(
            f"stored-as-{name}",
            f"reservoirs are stored as {name}",
            (STORED, STORED + "".join(f"\n    {line}" for line in formats)),
        )
        for name, formats in (
            ("half", (HALF_RADIANCE, HALF_W)),
            ("half-radiance", (HALF_RADIANCE,)),
            ("half-weight", (HALF_W,)),
            ("packed", (OCTAHEDRON, HALF_RADIANCE)),
            ("packed-half", (OCTAHEDRON, HALF_RADIANCE, HALF_W)),
            ("rgb9e5", (OCTAHEDRON, SHARED.format(9), HALF_W)),
            ("rgb9e5-float-weight", (OCTAHEDRON, SHARED.format(9))),
            ("rgbe", (OCTAHEDRON, SHARED.format(8), HALF_W)),
            ("rgbe-float-weight", (OCTAHEDRON, SHARED.format(8))),
            ("rtxdi", (OCTAHEDRON, IN_LOG_LUV)),
            ("octahedral", (OCTAHEDRON,)),
        )
    ),
    Plant(
        "the Jacobian is refused beyond 10, and then clamped to 3",
        ("jacobian-refused-then-clamped",),
        (
            (
                SHIFT,
                LIMITED,
                "J = saturate(jacobian)\n"
                "    inside = (J >= 0.1) & (J <= 10)\n"
                "    return np.where(inside, np.clip(J, 1 / 3, 3), 0).astype(J.dtype)",
            ),
        ),
    ),
    Plant(
        "the back of a sample has a target, and no Jacobian",
        ("back-left-to-the-jacobian",),
        (
            (TARGET, FACES, "dot(y.normal, toward) != 0, lit_cosine"),
            (
                SHIFT,
                COSINES,
                "np.maximum(dot(n_sample, v_to), 0),"
                " np.maximum(dot(n_sample, v_from), 0)",
            ),
            (BY_HAND, "(cosine > 0) & (dot(y.normal, v) < 0)", "cosine > 0"),
            (BY_HAND, "abs(dot(y.normal, b))", "np.maximum(dot(y.normal, b), 0)"),
            (BY_HAND, "abs(dot(y.normal, a))", "np.maximum(dot(y.normal, a), 0)"),
        ),
        ALL_BY_HAND,
    ),
    Plant(
        "a null has W = 1/p",
        ("dark-sample-keeps-its-density",),
        (
            (
                "restir_gi.reference.oracle.builtin.passes",
                "r = finalize(c, c.M)",
                "r = finalize(c, c.M)\n"
                "    r = replace(r, W=np.where(pdf > 0, 1 / pdf, 0))",
            ),
        ),
    ),
]

GRID = [
    Plant(
        f"{h.name}, by hand",
        (h.name,),
        by_hand=dict.fromkeys(h.passes, answer_by_hand(h.name)),
    )
    for h in HASH_GRID_MISTAKES
    if h.passes != ("light_reuse",) or "-in-halves" in h.name
]
LIGHT_REUSE = [
    Plant(f"{plant.name}, of light", (f"light-{name}",), plant.edits)
    for plant in (*REUSE_MUTANTS, *REUSE)
    for name in plant.expected
    if name not in OF_JACOBIANS
]
"""The engine is the same, and so are its mistakes."""

PAIRS = [
    Plant(
        f"{h.name}, by hand",
        (h.name,),
        by_hand=dict.fromkeys(h.passes, partial(pairs_by_hand.by_hand, mistake=h.name)),
    )
    for h in GRADIENT_MISTAKES
]

HERE = (
    *(*CORE, *VIEWS, *PACKED, *LAYOUTS, *REUSE, *SHIFTS, *FUSED, *CHOICES),
    *(*GRID, *LIGHT_REUSE, *PAIRS),
)


def of_mutant(mutant: Mutant) -> Plant:
    """A planted edit of the catalogues."""
    return Plant(mutant.name, mutant.expected, mutant.edits)


CATALOGUES = (
    *MUTANTS,
    *FURTHER_MUTANTS,
    *REUSE_MUTANTS,
    *SHIFT_MUTANTS,
    *HASH_GRID_MUTANTS,
)
PLANTS = (*map(of_mutant, CATALOGUES), *HERE)


def plants_of(name: str, plants: Iterable[Plant] = PLANTS) -> list[Plant]:
    """Plants of a hypothesis."""
    return [plant for plant in plants if name in plant.expected]
